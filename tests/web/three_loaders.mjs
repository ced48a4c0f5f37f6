// three's GLTFLoader in Node.js, with psplit's classes.
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { plain_materials } from './compare_scenes.mjs';
import { modules_folder, package_folder } from './load.mjs';

globalThis.ProgressEvent ??= class extends Event {};
globalThis.self ??= globalThis;

const module_of = (name) => import(pathToFileURL(path.join(modules_folder, 'node_modules/three', name)));
export const THREE = await module_of('build/three.module.js');
export const { GLTFLoader } = await module_of('examples/jsm/loaders/GLTFLoader.js');
export const { MeshoptDecoder } = await module_of('examples/jsm/libs/meshopt_decoder.module.js');
export const { loadStreaming, PsplitDracoLoader, PsplitPlugin } = await import(pathToFileURL(path.join(package_folder, 'three.js')));

// A loader without images, and the options of the plugin, if it has one.
export function make_loader({ manager, draco, plugin } = {}) {
  const loader = new GLTFLoader(manager).setMeshoptDecoder(MeshoptDecoder);
  loader.register(plain_materials(THREE.MeshStandardMaterial));
  if (draco !== undefined) loader.setDRACOLoader(draco);
  if (plugin !== undefined) loader.register((parser) => new PsplitPlugin(parser, plugin));
  return loader;
}

export function buffer_of(bytes) {
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
}
