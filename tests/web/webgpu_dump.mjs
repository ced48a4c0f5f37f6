// Compiles the shaders of psplit/webgpu by Dawn, which prints their SPIR-V: of Draco's streams, then of condensed ones.
// webgpu_compilers.mjs runs it.
import path from 'node:path';
import { compressed_primitives, samples_folder } from './load.mjs';
import { createGpuDecoder, request_device } from './webgpu_device.mjs';

const decoder = await createGpuDecoder(await request_device());
// The first condensed container has them compiled.
const [{ bytes }] = compressed_primitives(path.join(samples_folder, 'condensed.glb'), 'PSPLIT_mesh_draco_patches');
await decoder.decode(bytes);
process.exit();
