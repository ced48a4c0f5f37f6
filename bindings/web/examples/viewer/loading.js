// Loads an asset with three's GLTFLoader.
import { LoadingManager } from './three/three.module.js';
import { MeshoptDecoder } from './three/libs/meshopt_decoder.module.js';
import { GLTFLoader } from './three/loaders/GLTFLoader.js';
import { PsplitDracoLoader, PsplitPlugin } from './psplit/three.js';
import { glb_of_stream } from './streams.js';

/**
 * @param {import('./files.js').Asset} asset
 * @param {object} options of PsplitPlugin, with a pool
 * @returns {Promise<object>} what GLTFLoader made; it has a scene
 */
export async function load_asset(asset, options) {
  const { pool } = options, manager = new LoadingManager().setURLModifier(asset.resolve);
  const loader = new GLTFLoader(manager).setMeshoptDecoder(MeshoptDecoder).setDRACOLoader(new PsplitDracoLoader({ manager, pool }));
  loader.register((parser) => new PsplitPlugin(parser, { ...options, file: asset.name }));
  const bytes = asset.is_stream ? await glb_of_stream(asset.bytes, pool) : asset.bytes.slice(0);
  const gltf = await loader.parseAsync(bytes, '');
  return Object.assign(gltf, { scene: gltf.scene ?? gltf.scenes[0] });
}
