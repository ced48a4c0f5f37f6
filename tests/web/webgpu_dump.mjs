// Compiles the shaders of psplit/webgpu by Dawn, which prints their SPIR-V; webgpu_compilers.mjs runs it.
import { createGpuDecoder, request_device } from './webgpu_device.mjs';

await createGpuDecoder(await request_device());
process.exit();
