// The package's types: a project that uses them compiles, in the ways in which projects find modules. publint accepts the package.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import { pathToFileURL } from 'node:url';
import { link_package, modules_folder, package_folder, readme_blocks, root } from './load.mjs';

const require_module = createRequire(path.join(modules_folder, 'package.json'));
const ts = require_module('typescript');
link_package();

// Compiles texts as files of the project that has the modules. Returns what the compiler says of them and of the package.
function compile(sources, resolution) {
  const { options, errors } = ts.convertCompilerOptionsFromJson({ noEmit: true, strict: true, target: 'es2022', lib: ['es2022', 'dom', 'esnext.disposable'],
    module: resolution === 'nodenext' ? 'nodenext' : 'esnext', moduleResolution: resolution, types: [], jsx: 'react-jsx' }, root);
  assert.deepEqual(errors, []);
  const host = ts.createCompilerHost(options), { readFile, fileExists } = host;
  const files = new Map(Object.entries(sources).map(([name, text]) => [path.join(modules_folder, name), text]));
  host.readFile = (file) => files.get(file) ?? readFile.call(host, file);
  host.fileExists = (file) => files.has(file) || fileExists.call(host, file);
  // Declarations of other packages may need what this project does not have. To check them takes most of the time.
  const program = ts.createProgram([...files.keys()], options, host);
  const checked = program.getSourceFiles().filter(({ fileName }) => files.has(fileName) || fileName.startsWith(package_folder));
  assert.ok(checked.length > files.size);
  const own = [...program.getOptionsDiagnostics(), ...program.getGlobalDiagnostics(), ...checked.flatMap((file) =>
    [...program.getSyntacticDiagnostics(file), ...program.getSemanticDiagnostics(file)])];
  return ts.formatDiagnostics(own, { getCanonicalFileName: (name) => name, getCurrentDirectory: () => root, getNewLine: () => '\n' });
}

const usage = (name) => ({ [name.replace('.ts', '.mts')]: readFileSync(path.join(root, 'tests/web', name), 'utf8') });
test('a project of a bundler compiles', () => assert.equal(compile({ ...usage('usage.ts'), ...usage('usage_stdlib.ts') }, 'bundler'), ''));
test('a project of Node.js compiles', () => assert.equal(compile(usage('usage.ts'), 'nodenext'), ''));

test("the README's code compiles as TypeScript", () => {
  const given = `declare const bytes: Uint8Array, container: Uint8Array, streams: Uint8Array[], scene: import('@babylonjs/core/scene.js').Scene;
    declare global { var ModelViewerElement: { dracoDecoderLocation: string } }\n`;
  const blocks = Object.values(readme_blocks()).flat().filter((code) => !code.startsWith('<'));
  assert.ok(blocks.length >= 10);
  const typed = (code) => code.replace('({ io })', "({ io }: { io: import('@gltf-transform/core').NodeIO })");
  const files = blocks.map((code, i) => [`block${i}.${/^'use client'/.test(code) ? 'tsx' : 'mts'}`, given.replace(
    /,? scene:[^;]*/, (scene) => (/\bscene\b.* = /.test(code) ? '' : scene)) + typed(code)]);
  assert.equal(compile(Object.fromEntries(files), 'bundler'), '');
});

test('publint accepts the package', async () => {
  const { publint } = await import(pathToFileURL(require_module.resolve('publint')));
  const { messages } = await publint({ pkgDir: package_folder, strict: true });
  assert.deepEqual(messages.map(({ code, path: at, args }) => `${code} ${at.join('.')} ${JSON.stringify(args)}`), []);
});

test('the types of psplit/draco have the calls that its modules have', async () => {
  const unlike = { Decoder: ['GetEncodedGeometryType_Deprecated', 'GetTriangleStripsFromMesh'] };
  for (const [file, create] of [['draco_wasm_wrapper', 'createDecoderModule'], ['draco_encoder', 'createEncoderModule']]) {
    const text = readFileSync(path.join(package_folder, `draco/${file}.d.ts`), 'utf8');
    const module = await require_module(path.join(package_folder, `draco/${file}.js`))[create]();
    let count = 0;
    for (const [name, Class] of Object.entries(module)) {
      // Encoders make no attributes.
      if (file === 'draco_encoder' && name === 'PointAttribute') continue;
      if (typeof Class !== 'function' || !/^[A-Z]/.test(name) || /Array$|^WrapperObject|^VoidPtr/.test(name)) continue;
      for (const method of Object.getOwnPropertyNames(Class.prototype).filter((of) => !/^(constructor|__destroy__|.*_)$/.test(of) && !unlike[name]?.includes(of))) {
        assert.match(text, new RegExp(`\\b${method}[(:]`), `${name}.${method}`);
        ++count;
      }
    }
    for (const [, name] of text.matchAll(/readonly ([A-Z_]+): number;/g)) assert.equal(typeof module[name], 'number', name);
    assert.ok(count > 10, `${count}`);
  }
});
