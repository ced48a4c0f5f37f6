// The package's types: a project that uses them compiles, in the ways in which projects find modules. publint accepts the package.
import assert from 'node:assert/strict';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import { pathToFileURL } from 'node:url';
import { link_package, modules_folder, package_folder, root } from './load.mjs';

const require_module = createRequire(path.join(modules_folder, 'package.json'));
const ts = require_module('typescript');
link_package();

for (const resolution of ['bundler', 'nodenext'])
  test(`a project compiles that finds modules as ${resolution}`, () => {
    const { options, errors } = ts.convertCompilerOptionsFromJson({ noEmit: true, strict: true, target: 'es2022', lib: ['es2022', 'dom', 'esnext.disposable'],
      module: resolution === 'nodenext' ? 'nodenext' : 'esnext', moduleResolution: resolution, types: [] }, root);
    assert.deepEqual(errors, []);
    const host = ts.createCompilerHost(options);
    // As if the file were in the project that has the modules.
    const usage = path.join(modules_folder, 'usage.ts'), source = path.join(root, 'tests/web/usage.ts');
    const { readFile, fileExists } = host;
    host.readFile = (file) => readFile.call(host, file === usage ? source : file);
    host.fileExists = (file) => file === usage || fileExists.call(host, file);
    const diagnostics = ts.getPreEmitDiagnostics(ts.createProgram([usage], options, host));
    // Declarations of other packages may need what this project does not have.
    const own = diagnostics.filter(({ file }) => file === undefined || file.fileName === usage || file.fileName.startsWith(package_folder));
    assert.equal(ts.formatDiagnostics(own, { getCanonicalFileName: (name) => name, getCurrentDirectory: () => root, getNewLine: () => '\n' }), '');
  });

test('publint accepts the package', async () => {
  const { publint } = await import(pathToFileURL(require_module.resolve('publint')));
  const { messages } = await publint({ pkgDir: package_folder, strict: true });
  assert.deepEqual(messages.map(({ code, path: at, args }) => `${code} ${at.join('.')} ${JSON.stringify(args)}`), []);
});
