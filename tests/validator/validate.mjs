// Checks whole files, with their external resources, with the official glTF validator:
//
//   node validate.mjs [--like INPUT] [--allow CODE]... FILE...
//
// Prints every error, and exits with 1 if there is one. With --like, errors whose code INPUT itself has do not count,
// because psplit passes faults of an asset through. --allow exempts one code, for inputs that are not glTF.
//
// gltf-validator is in node_modules beside this file, or beside a copy of it in build/.
import { readFile } from 'node:fs/promises';
import path from 'node:path';
import validator from 'gltf-validator';

const extension = 'PSPLIT_mesh_draco_patches';

async function errors_of(file) {
  const folder = path.dirname(file);
  const report = await validator.validateBytes(new Uint8Array(await readFile(file)), {
    uri: path.basename(file),
    maxIssues: 0,
    externalResourceFunction: async (uri) =>
      new Uint8Array(await readFile(path.join(folder, decodeURIComponent(uri)))),
  });
  const of_extension = (message) =>
    message.code === 'UNSUPPORTED_EXTENSION' && message.message.includes(extension);
  return report.issues.messages.filter((message) => message.severity === 0 && !of_extension(message));
}

const files = process.argv.slice(2);
let known = new Set();
if (files[0] === '--like') {
  const input = files[1];
  files.splice(0, 2);
  // An input that the validator cannot read exempts no code.
  known = new Set((await errors_of(input).catch(() => [])).map((error) => error.code));
}
while (files[0] === '--allow') {
  known.add(files[1]);
  files.splice(0, 2);
}
let failed = 0;
for (const file of files) {
  let errors;
  try {
    errors = (await errors_of(file)).filter((error) => !known.has(error.code));
  } catch (error) {
    errors = [{ code: 'UNREADABLE', message: String(error), pointer: '' }];
  }
  for (const error of errors) console.log(`${file}: ${error.code} ${error.pointer ?? ''}: ${error.message}`);
  failed += errors.length > 0 ? 1 : 0;
}
console.log(`validator: ${files.length - failed} of ${files.length} files without errors`);
process.exit(failed > 0 || files.length === 0 ? 1 : 0);
