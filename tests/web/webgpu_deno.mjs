// Decodes containers in Deno, whose WebGPU is wgpu: another implementation than Dawn, with another compiler of WGSL (naga), as in Firefox.
//
//   deno run -A webgpu_deno.mjs PACKAGE [FOLDER]
//
// Prints a line with the adapter and the messages about the shaders. In FOLDER, batches.json lists containers, whose bytes are in files, and
// a line is printed with the sum of each batch (webgpu_compare.js).
/* global Deno */
import { pathToFileURL } from 'node:url';
import { add, compare } from './webgpu_compare.js';

const [folder_of_package, folder] = Deno.args;
const of_package = (name) => import(pathToFileURL(`${folder_of_package}/${name}`));
const adapter = await navigator.gpu?.requestAdapter();
const say = (value) => console.log(JSON.stringify(value));
if (!adapter) {
  say({ adapter: null });
  Deno.exit();
}
const device = await adapter.requestDevice(), found = [];
for (const { code } of [await of_package('webgpu/shaders.js'), (await of_package('webgpu/condensed.js')).condensed]) {
  device.pushErrorScope('validation');
  const module = device.createShaderModule({ code }), error = await device.popErrorScope();
  const { messages = [] } = (await module.getCompilationInfo?.()) ?? {};
  found.push(...(error === null ? [] : [error.message]), ...messages.map(({ message, lineNum }) => `${lineNum}: ${message}`));
}
say({ adapter: adapter.info.description, messages: found });
if (folder !== undefined && found.length === 0) {
  const { createGpuDecoder } = await of_package('webgpu.js'), { decodeContainer } = await of_package('index.js');
  const decoder = await createGpuDecoder(device), batches = JSON.parse(Deno.readTextFileSync(`${folder}/batches.json`)), sum = {};
  for (const batch of batches)
    add(sum, await compare(decoder, decodeContainer, batch.map(({ file, ...container }) => ({ ...container, bytes: Deno.readFileSync(`${folder}/${file}`) }))));
  say(sum);
}
Deno.exit();
