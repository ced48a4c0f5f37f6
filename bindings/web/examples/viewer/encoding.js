// Encodes an asset in patches, in a worker. glTF-Transform reads the asset and writes the GLB.
import { WebIO } from './gltf-transform/core.js';
import { ALL_EXTENSIONS } from './gltf-transform/extensions.js';
import { createEncoder } from './psplit/encode.js';
import { createDecoder, psplit, PsplitMeshDracoPatches } from './psplit/gltf-transform.js';
import { glb_of_stream } from './streams.js';
import { MeshoptDecoder } from './three/libs/meshopt_decoder.module.js';

const kExtensions = [...ALL_EXTENSIONS, PsplitMeshDracoPatches];
// Other codings of geometry, which the patches replace.
const kCodings = ['KHR_draco_mesh_compression', 'EXT_meshopt_compression', 'KHR_meshopt_compression'];

// The package's decoder of stock Draco is a classic script, which defines a function.
let draco_script;
function draco_decoder() {
  draco_script ??= new Promise((resolve, reject) => {
    const script = Object.assign(document.createElement('script'), { src: 'psplit/draco/draco_wasm_wrapper.js' });
    script.onload = resolve;
    script.onerror = () => reject(new Error(`${script.src} cannot be loaded`));
    document.head.append(script);
  });
  return draco_script.then(() => globalThis.DracoDecoderModule());
}

async function read(asset, pool, io) {
  const bytes = asset.is_stream ? await glb_of_stream(asset.bytes, pool) : asset.bytes;
  const is_glb = bytes.byteLength >= 4 && new DataView(bytes).getUint32(0, true) === 0x46546c67;
  const stored = is_glb ? await io.binaryToJSON(new Uint8Array(bytes)) : { json: JSON.parse(new TextDecoder().decode(bytes)), resources: {} };
  const { json, resources } = stored;
  for (const { uri } of [...json.buffers ?? [], ...json.images ?? []]) {
    if (uri === undefined || uri.startsWith('data:') || uri in resources) continue;
    const response = await fetch(asset.resolve(uri));
    if (!response.ok) throw new Error(`${uri}: HTTP status ${response.status}`);
    resources[uri] = new Uint8Array(await response.arrayBuffer());
  }
  const known = new Set(kExtensions.map(({ EXTENSION_NAME }) => EXTENSION_NAME));
  return { document: await io.readJSON(stored), lost: (json.extensionsUsed ?? []).filter((name) => !known.has(name)) };
}

/**
 * @param {import('./files.js').Asset} asset
 * @param {object} options of psplit(): condense, onProgress, signal
 * @returns {Promise<{ bytes: ArrayBuffer, notes: string[], ms: number }>} a GLB, what to know about it, and the time of encoding
 */
export async function encode_asset(asset, pool, options) {
  const notes = [], log = { debug() {}, info() {}, warn: (text) => notes.push(text), error: (text) => notes.push(text) };
  const io = new WebIO().setLogger(log).registerExtensions(kExtensions).registerDependencies({
    'draco3d.decoder': await draco_decoder(), 'meshopt.decoder': MeshoptDecoder, 'psplit.decoder': await createDecoder() });
  const { document, lost } = await read(asset, pool, io);
  options.signal?.throwIfAborted();
  document.setLogger(log);
  if (lost.length > 0) notes.push(`The file is written without ${lost.join(', ')}.`);
  const root = document.getRoot(), [first, ...others] = root.listBuffers();
  for (const extension of root.listExtensionsUsed()) if (kCodings.includes(extension.extensionName)) extension.dispose();
  // A GLB has one buffer.
  for (const buffer of others) {
    for (const parent of buffer.listParents()) if (parent !== root) parent.swap(buffer, first);
    buffer.dispose();
  }
  const encoder = createEncoder(), begin = performance.now();
  try {
    await document.transform(psplit({ ...options, encoder }));
    const ms = performance.now() - begin, glb = await io.writeBinary(document);
    return { bytes: glb.buffer.slice(glb.byteOffset, glb.byteOffset + glb.byteLength), notes, ms };
  } finally {
    encoder.dispose();
  }
}
