// WebGPU in Node.js: Dawn (npm's package webgpu) on SwiftShader, which Debian's Chromium brings, so that shaders run without a GPU.
import { existsSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { modules_folder, package_folder } from './load.mjs';

// Another driver, such as a GPU's, may be named.
export const kDriver = '/usr/lib/chromium/vk_swiftshader_icd.json';
process.env.VK_DRIVER_FILES ??= kDriver;

function find_dawn() {
  try {
    return createRequire(path.join(modules_folder, 'package.json')).resolve('webgpu');
  } catch {
    return null;
  }
}
const file = find_dawn();
const dawn = file === null || !existsSync(process.env.VK_DRIVER_FILES) ? null : await import(pathToFileURL(file));
// It must not be collected: its devices do not keep it, and the process crashes when one is used then.
globalThis.gpu_of_tests = null;
if (dawn !== null) {
  Object.assign(globalThis, dawn.globals);
  globalThis.gpu_of_tests = dawn.create(process.env.PSPLIT_DAWN?.split(' ') ?? []);
}
/** An adapter, or null. */
export const request_adapter = async () => (globalThis.gpu_of_tests === null ? null : globalThis.gpu_of_tests.requestAdapter().catch(() => null));
globalThis.adapter_of_tests = await request_adapter();
/** The reason to skip tests, or false. */
export const skip = globalThis.adapter_of_tests === null && 'there is no WebGPU: npm\'s webgpu, libvulkan1 and a Vulkan driver';
export const { createGpuDecoder } = await import(pathToFileURL(path.join(package_folder, 'webgpu.js')));

/** A device; it fails a test if a call is invalid. */
export async function request_device(descriptor) {
  const device = await (await request_adapter()).requestDevice(descriptor);
  device.addEventListener('uncapturederror', ({ error }) => {
    throw error;
  });
  return device;
}
