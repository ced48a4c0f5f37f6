// The package's types: a project that uses them compiles, in the ways in which projects find modules. publint accepts the package.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import { pathToFileURL } from 'node:url';
import { link_package, modules_folder, package_folder, root } from './load.mjs';

const require_module = createRequire(path.join(modules_folder, 'package.json'));
const ts = require_module('typescript');
link_package();

// Compiles texts as files of the project that has the modules. Returns what the compiler says of them and of the package.
function compile(sources, resolution) {
  const { options, errors } = ts.convertCompilerOptionsFromJson({ noEmit: true, strict: true, target: 'es2022', lib: ['es2022', 'dom', 'esnext.disposable'],
    module: resolution === 'nodenext' ? 'nodenext' : 'esnext', moduleResolution: resolution, types: [] }, root);
  assert.deepEqual(errors, []);
  const host = ts.createCompilerHost(options), { readFile, fileExists } = host;
  const files = new Map(Object.entries(sources).map(([name, text]) => [path.join(modules_folder, name), text]));
  host.readFile = (file) => files.get(file) ?? readFile.call(host, file);
  host.fileExists = (file) => files.has(file) || fileExists.call(host, file);
  const diagnostics = ts.getPreEmitDiagnostics(ts.createProgram([...files.keys()], options, host));
  // Declarations of other packages may need what this project does not have.
  const own = diagnostics.filter(({ file }) => file === undefined || files.has(file.fileName) || file.fileName.startsWith(package_folder));
  return ts.formatDiagnostics(own, { getCanonicalFileName: (name) => name, getCurrentDirectory: () => root, getNewLine: () => '\n' });
}

const usage = (name) => ({ [name.replace('.ts', '.mts')]: readFileSync(path.join(root, 'tests/web', name), 'utf8') });
test('a project of a bundler compiles', () => assert.equal(compile({ ...usage('usage.ts'), ...usage('usage_stdlib.ts') }, 'bundler'), ''));
test('a project of Node.js compiles', () => assert.equal(compile(usage('usage.ts'), 'nodenext'), ''));

test("the README's code compiles as TypeScript", () => {
  const given = `declare const bytes: Uint8Array, container: Uint8Array, streams: Uint8Array[], scene: import('@babylonjs/core/scene.js').Scene;
    declare global { var ModelViewerElement: { dracoDecoderLocation: string } }\n`;
  const blocks = [...readFileSync(path.join(root, 'web/README.md'), 'utf8').matchAll(/^```js\n(.*?)^```$/gms)].map(([, code]) => code);
  assert.ok(blocks.length >= 10);
  assert.equal(compile(Object.fromEntries(blocks.map((code, i) => [`block${i}.mts`, given.replace(
    /,? scene:[^;]*/, (scene) => (/\bscene\b.* = /.test(code) ? '' : scene)) + code])), 'bundler'), '');
});

test('publint accepts the package', async () => {
  const { publint } = await import(pathToFileURL(require_module.resolve('publint')));
  const { messages } = await publint({ pkgDir: package_folder, strict: true });
  assert.deepEqual(messages.map(({ code, path: at, args }) => `${code} ${at.join('.')} ${JSON.stringify(args)}`), []);
});
