// bench/web/webgpu.mjs, which scripts/gpu-check runs, says no speed of a processor, but compares what it decodes.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, readFileSync, rmSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { corpus_folder, gltf_psplit, root } from './load.mjs';
import { kDriver, skip } from './webgpu_device.mjs';

test('a processor is compared, not measured', { skip: skip || (!existsSync(kDriver) && 'there is no SwiftShader') || (gltf_psplit === null && 'there is no gltf-psplit') }, () => {
  const json = path.join(root, 'build/web/webgpu_speed.json');
  rmSync(json, { force: true });
  const text = execFileSync(process.execPath, [path.join(root, 'bench/web/webgpu.mjs'), '--quick', '--json', json],
    { encoding: 'utf8', env: { ...process.env, VK_DRIVER_FILES: kDriver }, stdio: ['ignore', 'pipe', 'ignore'] });
  assert.match(text, /^WebGPU: google, swiftshader/);
  assert.equal(text.match(/: equal, [\d,]+ faces in \d+ container/g)?.length, corpus_folder === null ? 2 : 3, text);
  assert.doesNotMatch(text, /ms|a second/);
  assert.deepEqual([JSON.parse(readFileSync(json)).is_software, JSON.parse(readFileSync(json)).rows], [true, []]);
});
