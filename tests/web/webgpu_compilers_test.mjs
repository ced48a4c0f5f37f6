// Compilers of WGSL take the shaders of psplit/webgpu without a word. scripts/web-gpu --compilers says more.
import assert from 'node:assert/strict';
import path from 'node:path';
import test from 'node:test';
import { pathToFileURL } from 'node:url';
import { package_folder } from './load.mjs';
import { no_deno, run_in_deno } from './webgpu_compilers.mjs';
import { request_device, skip } from './webgpu_device.mjs';

test('Dawn has no message about the shaders', { skip }, async () => {
  const from_package = async (name) => import(pathToFileURL(path.join(package_folder, 'webgpu', name))), device = await request_device();
  const { code } = await from_package('shaders.js'), { condensed } = await from_package('condensed.js');
  const messages = async (text) => (await device.createShaderModule({ code: text }).getCompilationInfo()).messages.map(({ type, message, lineNum }) => `${type}, line ${lineNum}: ${message}`);
  for (const each of [code, condensed.code]) assert.deepEqual(await messages(each), []);
  // It has one about code that can not be reached.
  assert.equal((await messages(`${code}\nfn warned() -> u32 { return 1u; return 2u; }`)).length, 1);
  device.destroy();
});

test('wgpu has no message about the shaders', { skip: skip || no_deno }, () => {
  const [{ adapter, messages }] = run_in_deno();
  assert.notEqual(adapter, null);
  assert.deepEqual(messages, []);
});
