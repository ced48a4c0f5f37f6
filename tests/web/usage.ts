// What the package's types let a project write. types_test.mjs compiles it; it never runs.
import { NodeIO } from '@gltf-transform/core';
import { type DecodedContainer, type DecodedMesh, type DecodedPart, type Pool, PsplitError, createPool, decodeContainer, decodeDraco, ready } from 'psplit';
import { loadStreaming as loadIntoBabylon, registerPsplit } from 'psplit/babylon';
import createDecoderModule from 'psplit/draco/draco_wasm_wrapper.js';
import { PsplitMeshDracoPatches, createDecoder, decodeAhead } from 'psplit/gltf-transform';
import * as inline from 'psplit/inline';
import { PsplitDracoLoader, PsplitPlugin, loadStreaming } from 'psplit/three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

export async function decode(bytes: Uint8Array, signal: AbortSignal): Promise<number> {
  await ready();
  const mesh: DecodedMesh = await decodeDraco(bytes, { attributes: [{ uniqueId: 0, type: 'float32' }, { semantic: 'NORMAL' }] });
  const container: DecodedContainer = await decodeContainer(bytes, { attributes: [
    { name: 'POSITION', uniqueId: 0, type: 'float32', componentCount: 3 }] });
  const pool: Pool = createPool({ workers: 2, wasm: new URL('https://example.com/psplit.wasm'), idleMs: 100, shared: false });
  await pool.decodePatches(bytes, { signal, onProgress: (done, total) => console.log(done / total),
    onPart: (part: DecodedPart) => console.log(part.patches[0], part.indices.length) });
  pool.dispose();
  const same: typeof createPool = inline.createPool;
  return mesh.indices.length + container.patchCount + container.attributes[0]!.array.length + same().workerCount;
}

export function code_of(error: unknown): string {
  if (!(error instanceof PsplitError)) return 'another error';
  // @ts-expect-error: not a code
  if (error.code === 'no such code') return '';
  return `${error.code} ${error.patch ?? ''}`;
}

export function loaders(pool: Pool, signal: AbortSignal): GLTFLoader {
  const loader = new GLTFLoader().setDRACOLoader(new PsplitDracoLoader({ pool }) as never);
  return loader.register((parser) => new PsplitPlugin(parser, { pool, signal, patchByPatch: true, onProgress(done, total, { mesh, primitive }) {
    console.log(done, total, mesh, primitive);
  } }));
}

export async function arriving(pool: Pool, signal: AbortSignal): Promise<number> {
  const { json, primitives } = await pool.decodeUrl(new URL('https://example.com/a.glb'), { signal, workers: 1,
    onProgress: (done, total) => console.log(done / total), onPart: (part, { faceCount }, { mesh }) => console.log(part.isFinal, faceCount, mesh) });
  const { body } = await fetch('/a.bin'), mesh: DecodedContainer = await pool.decodeStream(body!, { onPart: (part) => console.log(part.firstFace) });
  const { scene, psplit } = await loadStreaming(new GLTFLoader(), '/a.glb', { signal, onProgress: (done) => console.log(done) });
  await psplit.whole;
  const load = async (source: string, scene: { name: string }) => ({ meshes: [source, scene.name] });
  const { meshes } = await loadIntoBabylon(load, '/a.glb', { name: 'a' }, { signal, onPart: (part, { faceCount }) => console.log(part.patches, faceCount) });
  return meshes.length + scene.children.length + primitives[0]!.faceCount + mesh.faceCount + json.meshes.length;
}

export async function io(pool: Pool): Promise<void> {
  const io = new NodeIO().registerExtensions([PsplitMeshDracoPatches]).registerDependencies({ 'psplit.decoder': await createDecoder(),
    'draco3d.decoder': await createDecoderModule({ draco3d: 'https://example.com/draco3d/' }) });
  const json = await io.readAsJSON('a.glb');
  await decodeAhead(json, pool);
  const document = await io.readJSON(json);
  document.createExtension(PsplitMeshDracoPatches).setRequired(false);
  registerPsplit(() => {}, { pool });
  // @ts-expect-error: requests of containers need a type
  await decodeContainer(new Uint8Array(4), { attributes: [{ name: 'POSITION', uniqueId: 0, componentCount: 3 }] });
}
