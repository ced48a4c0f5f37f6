// What the package's types let a project write. types_test.mjs compiles it; it never runs.
import { NodeIO } from '@gltf-transform/core';
import { type ChoosePatches, type DecodedContainer, type DecodedMesh, type DecodedPart, type Pool, PsplitError, configure, createPool, decodeContainer, decodeDraco, ready } from 'psplit';
import { loadStreaming as loadIntoBabylon, patchesOf, registerPsplit } from 'psplit/babylon';
import createEncoderModule from 'psplit/draco/draco_encoder.js';
import createDecoderModule from 'psplit/draco/draco_wasm_wrapper.js';
import wasm from 'psplit/psplit.wasm';
import { type DecodedAsset, decodeGlb, decodeGltf } from 'psplit/gltf';
import { type EncodedMesh, createEncoder, encodeMesh, encodeMeshes } from 'psplit/encode';
import { MeshoptDecoder } from 'meshoptimizer';
import { PsplitMeshDracoPatches, createDecoder, decodeAhead, psplit as patches } from 'psplit/gltf-transform';
import * as inline from 'psplit/inline';
import { PsplitDracoLoader, PsplitPlugin, loadStreaming } from 'psplit/three';
import { createGpuDecoder } from 'psplit/webgpu';
import { BufferAttribute, BufferGeometry } from 'three';
import { DRACOLoader } from 'three/addons/loaders/DRACOLoader.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

export async function decode(bytes: Uint8Array, signal: AbortSignal): Promise<number> {
  await ready();
  const mesh: DecodedMesh = await decodeDraco(bytes, { attributes: [{ uniqueId: 0, type: 'float32' }, { semantic: 'NORMAL' }] });
  const container: DecodedContainer = await decodeContainer(bytes, { attributes: [
    { name: 'POSITION', uniqueId: 0, type: 'float32', componentCount: 3 }] });
  configure({ wasm: await WebAssembly.compile(bytes as BufferSource), worker: () => new Worker('/worker.js', { type: 'module' }) });
  const pool: Pool = createPool({ workers: 2, wasm: new URL('https://example.com/psplit.wasm'), worker: '/worker.js', idleMs: 100, shared: false,
    mainThread: false });
  await pool.decodePatches(bytes, { signal, onProgress: (done, total) => console.log(done / total),
    onPart: (part: DecodedPart) => console.log(part.patches[0], part.indices.length) });
  pool.dispose();
  const same: typeof createPool = inline.createPool;
  return mesh.indices.length + container.patchCount + container.attributes[0]!.array.length + same().workerCount;
}

export async function assets(bytes: ArrayBuffer, pool: Pool, signal: AbortSignal): Promise<BufferGeometry[]> {
  const assets: DecodedAsset[] = [await decodeGlb(bytes), await decodeGltf('a.gltf', { pool, signal, meshoptDecoder: MeshoptDecoder })];
  return assets.flatMap(({ primitives }) => primitives).map(({ indices, attributes, targets = [] }) => {
    console.log(targets.map(({ POSITION }) => POSITION?.array.length));
    const { array, componentCount, normalized } = attributes['POSITION']!;
    return new BufferGeometry().setIndex(indices && new BufferAttribute(indices, 1)).setAttribute('position', new BufferAttribute(array, componentCount, normalized));
  });
}

export function code_of(error: unknown): string {
  if (!(error instanceof PsplitError)) return 'another error';
  // @ts-expect-error: not a code
  if (error.code === 'no such code') return '';
  return `${error.code} ${error.patch ?? ''}`;
}

export function loaders(pool: Pool, signal: AbortSignal): GLTFLoader {
  const loader = new GLTFLoader().setDRACOLoader(new PsplitDracoLoader({ pool, fallback: new DRACOLoader() }));
  return loader.register((parser) => new PsplitPlugin(parser, { pool, signal, patchByPatch: true, onProgress(done, total, { mesh, primitive }) {
    console.log(done, total, mesh, primitive);
  } }));
}

export async function shown(loader: GLTFLoader): Promise<number> {
  const { psplit, scene } = await loader.loadAsync('/model.glb');
  await psplit.whole;
  return psplit.patchesOf(scene.children[0]!)?.patchCount ?? 0;
}

export async function geometry(bytes: Uint8Array): Promise<BufferGeometry> {
  const { attributes, indices } = await decodeDraco(bytes), made = new BufferGeometry().setIndex(new BufferAttribute(indices, 1));
  for (const { name, array, componentCount, normalized } of attributes)
    made.setAttribute(name, new BufferAttribute(array, componentCount, normalized));
  return made;
}

export async function arriving(pool: Pool, signal: AbortSignal): Promise<number> {
  const { json, primitives } = await pool.decodeUrl(new URL('https://example.com/a.glb'), { signal, workers: 1,
    onProgress: (done, total) => console.log(done / total), onPart: (part, { faceCount }, { mesh }) => console.log(part.isFinal, faceCount, mesh) });
  const choose: ChoosePatches = async ({ patchCount, boxes, byteLengths, mesh }) => (boxes && mesh === 0 ? new Set([patchCount - 1]) : [...byteLengths.keys()]);
  const { primitives: [some] } = await pool.decodeUrl('/a.glb', { choose, onPart: (part, { chosen }) => console.log(chosen?.[part.patches[0]]) });
  await pool.decodeUrl('/a.glb', { choose: ({ faceCounts }) => { console.log(faceCounts.length, some!.chosen?.length); } });
  const { body } = await fetch('/a.bin'), mesh: DecodedContainer = await pool.decodeStream(body!, { onPart: (part) => console.log(part.firstFace) });
  const { scene, psplit } = await loadStreaming(new GLTFLoader(), '/a.glb', { signal, onProgress: (done) => console.log(done) });
  await psplit.whole;
  const load = async (source: string, scene: { name: string }) => ({ meshes: [source, scene.name] });
  const { meshes, psplit: { whole } } = await loadIntoBabylon(load, '/a.glb', { name: 'a' }, { signal, patchByPatch: true,
    onPart: (part, { faceCount }) => console.log(part.patches, faceCount) });
  await whole;
  return meshes.length + scene.children.length + primitives[0]!.faceCount + mesh.faceCount + json.meshes.length;
}

export async function io(pool: Pool): Promise<void> {
  const io = new NodeIO().registerExtensions([PsplitMeshDracoPatches]).registerDependencies({ 'psplit.decoder': await createDecoder(),
    'draco3d.encoder': await createEncoderModule({ locateFile: (file) => `/psplit/${file}` }),
    'draco3d.decoder': await createDecoderModule({ draco3d: 'https://example.com/draco3d/' }) });
  const json = await io.readAsJSON('a.glb');
  await decodeAhead(json, pool);
  const document = await io.readJSON(json);
  document.createExtension(PsplitMeshDracoPatches).setRequired(false);
  registerPsplit(() => {}, { pool, gpu: true });
  console.log(patchesOf({})?.why);
  // @ts-expect-error: requests of containers need a type
  await decodeContainer(new Uint8Array(4), { attributes: [{ name: 'POSITION', uniqueId: 0, componentCount: 3 }] });
}

export async function encoded(bytes: Uint8Array, signal: AbortSignal): Promise<number> {
  const { primitives } = await decodeGlb(bytes), geometry = new BufferGeometry();
  const here: EncodedMesh = await encodeMesh(primitives[0]!, { positionBits: 'auto', condense: true, onProgress: (done, total) => console.log(done / total) });
  const several = await encodeMeshes(primitives, { grids: primitives.map(({ mesh }) => mesh), order: { near: [0, 1, 0] }, exact: ['TEXCOORD_1'] });
  const encoder = createEncoder({ workers: 2, wasm: '/psplit_encoder.wasm' });
  const { array, itemSize } = geometry.getAttribute('position') as BufferAttribute;
  const there = await encoder.encodeMesh({ attributes: { POSITION: { array: array as Float32Array, itemSize } } }, { signal, transfer: true });
  // @ts-expect-error: not a profile
  await encoder.encodeMesh(primitives[0]!, { profile: 'fast' });
  const document = await new NodeIO().registerExtensions([PsplitMeshDracoPatches]).readBinary(bytes);
  await document.transform(patches({ encoder, quantizationVolume: 'scene', patchFaces: 4800 }), patches());
  encoder.dispose();
  return here.container.length + several.length + there.patchCount;
}

export async function stock_decoder(bytes: Uint8Array): Promise<[number, Float32Array, Int8Array[]]> {
  configure({ wasm });
  const draco: createDecoderModule.DecoderModule = await createDecoderModule(), decoder = new draco.Decoder(), mesh = new draco.Mesh();
  const status = decoder.DecodeArrayToMesh(bytes, bytes.length, mesh);
  if (!status.ok()) throw new Error(status.error_msg());
  const attribute = decoder.GetAttribute(mesh, decoder.GetAttributeId(mesh, draco.POSITION)), size = 4 * attribute.num_components() * mesh.num_points();
  const at = draco._malloc(size);
  decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, draco.DT_FLOAT32, size, at);
  const array = new Float32Array(draco.HEAPF32.buffer, at, size / 4).slice();
  draco._free(at);
  for (const object of [mesh, decoder]) draco.destroy(object);
  const encoders = await createEncoderModule(), builder = new encoders.MeshBuilder(), other = new encoders.Mesh(), encoder = new encoders.Encoder();
  builder.AddFloatAttributeToMesh(other, encoders.POSITION, array.length / 3, 3, array);
  encoder.SetEncodingMethod(encoders.MESH_EDGEBREAKER_ENCODING);
  const out = new encoders.DracoInt8Array(), length = encoder.EncodeMeshToDracoBuffer(other, out);
  // @ts-expect-error: draco3d has no such call
  decoder.DecodeMesh(bytes);
  return [mesh.num_faces(), array, [Int8Array.from({ length }, (_, i) => out.GetValue(i))]];
}

export async function on_a_gpu(device: unknown, bytes: Uint8Array): Promise<number> {
  const decoder = await createGpuDecoder(device, { fallback: 'wasm', memory: 1 << 26 });
  const mesh = await decoder.decode(bytes, { as: 'quantized', signal: new AbortController().signal });
  const [, other] = await decoder.decode([bytes, { buffer: mesh.indices.buffer, byteLength: 4 }]);
  if (other instanceof Error) throw other;
  const { indices }: DecodedMesh = await mesh.read(), scale: number | undefined = other?.attributes[0]?.scale;
  // @ts-expect-error: not a way to write values
  await decoder.decode(bytes, { as: 'float16' });
  mesh.destroy();
  return indices.length + mesh.indices.count + (scale ?? 1);
}
