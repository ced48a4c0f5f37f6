// Compilers of WGSL take the shaders of psplit/webgpu without a word. scripts/web-gpu --compilers says more.
import assert from 'node:assert/strict';
import path from 'node:path';
import test from 'node:test';
import { pathToFileURL } from 'node:url';
import { package_folder } from './load.mjs';
import { no_deno, run_in_deno } from './webgpu_compilers.mjs';
import { request_device, skip } from './webgpu_device.mjs';

test('Dawn has no message about the shaders', { skip }, async () => {
  const { code } = await import(pathToFileURL(path.join(package_folder, 'webgpu/shaders.js'))), device = await request_device();
  const messages = async (text) => (await device.createShaderModule({ code: text }).getCompilationInfo()).messages.map(({ type, message, lineNum }) => `${type}, line ${lineNum}: ${message}`);
  assert.deepEqual(await messages(code), []);
  // It has one about code that can not be reached.
  assert.equal((await messages(`${code}\nfn warned() -> u32 { return 1u; return 2u; }`)).length, 1);
  device.destroy();
});

test('wgpu has no message about the shaders', { skip: skip || no_deno }, () => {
  const [{ adapter, messages }] = run_in_deno();
  assert.notEqual(adapter, null);
  assert.deepEqual(messages, []);
});
