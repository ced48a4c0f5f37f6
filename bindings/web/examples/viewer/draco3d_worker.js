// Decodes Draco streams by draco3d, as three's DRACOLoader does in its workers.
importScripts('three/draco/draco_wasm_wrapper.js');

const ready = DracoDecoderModule({ locateFile: () => 'three/draco/draco_decoder.wasm' });
const kArrays = { int8: Int8Array, uint8: Uint8Array, int16: Int16Array, uint16: Uint16Array, uint32: Uint32Array, float32: Float32Array };

function decode(draco, { bytes, attributes }) {
  const decoder = new draco.Decoder(), mesh = new draco.Mesh(), data = new Int8Array(bytes.buffer, bytes.byteOffset, bytes.length);
  const status = decoder.DecodeArrayToMesh(data, data.length, mesh);
  if (!status.ok()) throw new Error(status.error_msg());
  const copied = (Type, length, write) => {
    const size = length * Type.BYTES_PER_ELEMENT, at = draco._malloc(size);
    write(size, at);
    const array = new Type(draco.HEAPF32.buffer, at, length).slice();
    draco._free(at);
    return array;
  };
  const arrays = [copied(Uint32Array, 3 * mesh.num_faces(), (size, at) => decoder.GetTrianglesUInt32Array(mesh, size, at))];
  for (const { uniqueId, type } of attributes) {
    const attribute = decoder.GetAttributeByUniqueId(mesh, uniqueId), length = mesh.num_points() * attribute.num_components();
    arrays.push(copied(kArrays[type], length, (size, at) =>
      decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, draco[`DT_${type.toUpperCase()}`], size, at)));
  }
  draco.destroy(mesh);
  draco.destroy(decoder);
  return arrays;
}

onmessage = async ({ data }) => {
  try {
    const arrays = decode(await ready, data);
    postMessage({ arrays }, arrays.map(({ buffer }) => buffer));
  } catch (error) {
    postMessage({ error: String(error.message ?? error) });
  }
};
onerror = () => postMessage({ error: 'the worker failed' });
