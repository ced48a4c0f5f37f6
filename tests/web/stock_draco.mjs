// Stock Draco (draco3d of npm): the reference decoder, and an encoder of small meshes with every coding.
import { stock } from './load.mjs';

const decoders = await stock.createDecoderModule({}), encoders = await stock.createEncoderModule({});

const kArrays = { 1: Int8Array, 2: Uint8Array, 3: Int16Array, 4: Uint16Array, 5: Int32Array, 6: Uint32Array, 9: Float32Array };

// Decodes as draco3d does: faces, and the attributes in the types that the stream stores. Throws what draco3d says.
export function decode(bytes) {
  const decoder = new decoders.Decoder(), mesh = new decoders.Mesh(), buffer = new decoders.DecoderBuffer();
  try {
    buffer.Init(new Int8Array(bytes.buffer, bytes.byteOffset, bytes.length), bytes.length);
    if (decoder.GetEncodedGeometryType(buffer) !== decoders.TRIANGULAR_MESH) throw new Error('not a mesh');
    const status = decoder.DecodeBufferToMesh(buffer, mesh);
    if (!status.ok()) throw new Error(status.error_msg());
    const copied = (Type, length, write) => {
      const at = decoders._malloc(length * Type.BYTES_PER_ELEMENT);
      write(length * Type.BYTES_PER_ELEMENT, at);
      const array = new Type(decoders.HEAPU8.buffer, at, length).slice();
      decoders._free(at);
      return array;
    };
    const indices = copied(Uint32Array, 3 * mesh.num_faces(), (size, at) => decoder.GetTrianglesUInt32Array(mesh, size, at));
    const attributes = Array.from({ length: mesh.num_attributes() }, (_, i) => {
      const attribute = decoder.GetAttribute(mesh, i), type = attribute.data_type();
      const array = copied(kArrays[type], mesh.num_points() * attribute.num_components(), (size, at) =>
        decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, type, size, at));
      return { uniqueId: attribute.unique_id(), componentCount: attribute.num_components(), array };
    });
    return { faceCount: mesh.num_faces(), pointCount: mesh.num_points(), indices, attributes };
  } finally {
    for (const object of [buffer, mesh, decoder]) decoders.destroy(object);
  }
}

// A wavy grid with a hole, with normals and colours, and with texture coordinates that have a seam.
export function grid(size) {
  const points = [], faces = [];
  for (let y = 0; y <= size; ++y)
    for (let x = 0; x <= size; ++x) points.push([x / size, y / size, 0.1 * Math.sin(5 * x / size) * Math.cos(7 * y / size)]);
  for (let y = 0; y < size; ++y)
    for (let x = 0; x < size; ++x) {
      if (Math.hypot(x - size / 3, y - size / 2) < size / 8) continue;
      const at = y * (size + 1) + x;
      faces.push([at, at + 1, at + size + 1], [at + 1, at + size + 2, at + size + 1]);
    }
  return { points, faces };
}

// Streams of all codings that draco3d's encoder writes, as [name, bytes].
export function* streams() {
  for (const method of ['edgebreaker', 'sequential'])
    for (const speed of [0, 3, 5, 8, 10])
      for (const bits of [0, 11])
        for (const extra of [false, true])
          yield [`${method}, speed ${speed}, ${bits} bits${extra ? ', more attributes' : ''}`,
            encode(grid(extra ? 20 : 31), { method, speed, bits, extra })];
}

// Encodes a grid: `extra` adds normals, texture coordinates, colours and numbers.
export function encode({ points, faces }, { method, speed, bits, extra }) {
  const encoder = new encoders.Encoder(), builder = new encoders.MeshBuilder(), mesh = new encoders.Mesh();
  const out = new encoders.DracoInt8Array();
  try {
    // Two points for each position on a seam in the middle: their texture coordinates differ.
    const seam = points.flatMap(([x], i) => (extra && x === 0.5 ? [i] : []));
    const twin = new Map(seam.map((i, k) => [i, points.length + k]));
    const all = [...points, ...seam.map((i) => points[i])];
    const indices = faces.flatMap((face) =>
      face.map((i) => (twin.has(i) && face.some((j) => points[j][0] > 0.5) ? twin.get(i) : i)));
    builder.AddFacesToMesh(mesh, faces.length, Uint32Array.from(indices));
    builder.AddFloatAttributeToMesh(mesh, encoders.POSITION, all.length, 3, Float32Array.from(all.flat()));
    if (extra) {
      const normals = all.flatMap(([x, y]) => {
        const slope = [Math.cos(5 * x), Math.sin(7 * y), 2], length = Math.hypot(...slope);
        return slope.map((value) => value / length);
      });
      builder.AddFloatAttributeToMesh(mesh, encoders.NORMAL, all.length, 3, Float32Array.from(normals));
      builder.AddFloatAttributeToMesh(mesh, encoders.TEX_COORD, all.length, 2,
        Float32Array.from(all.flatMap(([x, y], i) => [i < points.length ? x : x - 0.5, y])));
      builder.AddUInt8Attribute(mesh, encoders.COLOR, all.length, 4,
        Uint8Array.from(all.flatMap(([x, y], i) => [255 * x, 255 * y, i % 7, 255])));
      builder.AddUInt16Attribute(mesh, encoders.GENERIC, all.length, 1, Uint16Array.from(all.map((_, i) => i * 13)));
    }
    encoder.SetSpeedOptions(speed, speed);
    encoder.SetEncodingMethod(method === 'edgebreaker' ? encoders.MESH_EDGEBREAKER_ENCODING : encoders.MESH_SEQUENTIAL_ENCODING);
    if (bits > 0)
      for (const attribute of [encoders.POSITION, encoders.NORMAL, encoders.TEX_COORD])
        encoder.SetAttributeQuantization(attribute, bits);
    const length = encoder.EncodeMeshToDracoBuffer(mesh, out);
    if (length === 0) throw new Error('draco3d does not encode');
    return Uint8Array.from({ length }, (_, i) => out.GetValue(i) & 255);
  } finally {
    for (const object of [out, mesh, builder, encoder]) encoders.destroy(object);
  }
}

// Encodes a point cloud. `types`: the numbers of Draco of types that it has besides positions, in several attributes. `welded`:
// points of the same values become one. `metadata` has entries of the cloud and of its first attribute.
export function encode_cloud(point_count, { method = 'kd-tree', speed = 5, bits = 11, types = [2], welded = false, metadata = false } = {}) {
  const encoder = new encoders.Encoder(), builder = new encoders.PointCloudBuilder(), cloud = new encoders.PointCloud();
  const out = new encoders.DracoInt8Array();
  try {
    const { POSITION, NORMAL, COLOR, TEX_COORD, GENERIC } = encoders, points = Float32Array.from({ length: 3 * point_count }, (_, i) => Math.sin(i % 300));
    const first = builder.AddFloatAttribute(cloud, POSITION, point_count, 3, points);
    for (const [i, type] of types.entries()) {
      const components = 1 + (type + i) % 4, Type = kArrays[type], scale = type === 9 ? 1 / 64 : 1;
      const values = Type.from({ length: components * point_count }, (_, at) => ((at * 7) % 100 - (type % 2 === 0 ? 0 : 50)) * scale);
      const add = type === 9 ? 'AddFloatAttribute' : `Add${Type.name.replace('Uint', 'UInt').replace('Array', '')}Attribute`;
      builder[add](cloud, type === 2 ? COLOR : type === 9 && components === 2 ? TEX_COORD : GENERIC, point_count, components, values);
    }
    if (types.includes(9)) builder.AddFloatAttribute(cloud, NORMAL, point_count, 3, points.map((value) => value / 2 + 0.1));
    if (metadata) {
      const of_cloud = new encoders.Metadata(), of_attribute = new encoders.Metadata(), author = new encoders.MetadataBuilder();
      author.AddStringEntry(of_cloud, 'title', 'hills');
      author.AddIntEntry(of_cloud, 'number', -7);
      author.AddIntEntryArray(of_cloud, 'some', Int32Array.of(1, -2, 3), 3);
      author.AddDoubleEntry(of_cloud, 'half', 0.5);
      author.AddStringEntry(of_attribute, 'name', 'place');
      builder.AddMetadata(cloud, of_cloud);
      builder.SetMetadataForAttribute(cloud, first, of_attribute);
      for (const object of [of_cloud, of_attribute, author]) encoders.destroy(object);
    }
    encoder.SetSpeedOptions(speed, speed);
    encoder.SetEncodingMethod(method === 'kd-tree' ? 1 : 0);
    if (bits > 0) for (const attribute of [POSITION, NORMAL, TEX_COORD, GENERIC]) encoder.SetAttributeQuantization(attribute, bits);
    const length = encoder.EncodePointCloudToDracoBuffer(cloud, welded, out);
    if (length === 0) throw new Error('draco3d does not encode');
    return Uint8Array.from({ length }, (_, i) => out.GetValue(i) & 255);
  } finally {
    for (const object of [out, cloud, builder, encoder]) encoders.destroy(object);
  }
}

// Point clouds of all codings that draco3d's encoder writes, as [name, bytes].
export function* clouds() {
  for (const method of ['kd-tree', 'sequential'])
    for (const speed of [0, 2, 4, 5, 7, 8, 9, 10])
      for (const bits of method === 'kd-tree' ? [5, 11, 16] : [0, 11])
        for (const types of [[], [2], [1, 3, 4, 5, 6], [9, 2, 9, 5]])
          for (const [count, welded] of [[1, false], [2, false], [100, true], [700, false]])
            yield [`${method}, speed ${speed}, ${bits} bits, types ${types}, ${count} points${welded ? ', welded' : ''}`,
              encode_cloud(count, { method, speed, bits, types, welded })];
}

// A GLB file of JSON and a buffer.
export function make_glb(json, buffer) {
  const padded = (bytes, filler) => Buffer.concat([bytes, Buffer.alloc(-bytes.length & 3, filler)]);
  const chunk = (kind, bytes) => [Buffer.from(Uint32Array.of(bytes.length).buffer), Buffer.from(kind), bytes];
  const rest = [...chunk('JSON', padded(Buffer.from(JSON.stringify(json)), ' ')), ...chunk('BIN\0', padded(Buffer.from(buffer), 0))];
  const length = rest.reduce((sum, part) => sum + part.length, 12);
  return new Uint8Array(Buffer.concat([Buffer.from('glTF'), Buffer.from(Uint32Array.of(2, length).buffer), ...rest]));
}

// A GLB whose one mesh is a stream with positions alone.
export function draco_glb(stream) {
  const { faceCount, pointCount } = decode(stream);
  return make_glb({
    asset: { version: '2.0' }, extensionsUsed: ['KHR_draco_mesh_compression'], extensionsRequired: ['KHR_draco_mesh_compression'],
    scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ indices: 0, attributes: { POSITION: 1 },
      extensions: { KHR_draco_mesh_compression: { bufferView: 0, attributes: { POSITION: 0 } } } }] }],
    accessors: [{ componentType: 5125, type: 'SCALAR', count: 3 * faceCount },
      { componentType: 5126, type: 'VEC3', count: pointCount, min: [0, 0, -1], max: [1, 1, 1] }],
    bufferViews: [{ buffer: 0, byteLength: stream.length }], buffers: [{ byteLength: stream.length }],
  }, stream);
}

// An asset with one more mesh and node, whose mesh is a stream with positions alone: what gltf-psplit makes of a scene of large and
// small meshes.
export function with_draco_mesh(glb, stream) {
  const bytes = Buffer.from(glb), json_bytes = bytes.readUInt32LE(12), json = JSON.parse(bytes.toString('utf8', 20, 20 + json_bytes));
  const buffer = bytes.subarray(28 + json_bytes), { faceCount, pointCount } = decode(stream), kExtension = 'KHR_draco_mesh_compression';
  for (const list of ['extensionsUsed', 'extensionsRequired']) json[list].push(kExtension);
  const bufferView = json.bufferViews.push({ buffer: 0, byteOffset: buffer.length, byteLength: stream.length }) - 1;
  const indices = json.accessors.push({ componentType: 5125, type: 'SCALAR', count: 3 * faceCount }) - 1;
  const position = json.accessors.push({ componentType: 5126, type: 'VEC3', count: pointCount, min: [0, 0, -1], max: [1, 1, 1] }) - 1;
  const mesh = json.meshes.push({ primitives: [{ indices, attributes: { POSITION: position },
    extensions: { [kExtension]: { bufferView, attributes: { POSITION: 0 } } } }] }) - 1;
  json.scenes[0].nodes.push(json.nodes.push({ mesh }) - 1);
  json.buffers[0].byteLength = buffer.length + stream.length;
  return make_glb(json, Buffer.concat([buffer, stream]));
}

// Puts metadata that draco3d's encoder would not write into its stream: a tree for the geometry, and trees by the unique ids of
// attributes.
export function with_metadata(bytes, of_attributes, of_geometry) {
  const trees = [...varint(of_attributes.length), ...of_attributes.flatMap(([unique_id, tree]) => [...varint(unique_id), ...tree]), ...of_geometry];
  return Uint8Array.from([...bytes.subarray(0, 10), bytes[10] | 0x80, ...trees, ...bytes.subarray(11)]);
}
// A tree of entries, as [name, bytes], and parts, as [name, tree].
export const metadata_tree = (entries, parts = []) => [
  ...varint(entries.length), ...entries.flatMap(([name, value]) => [...sized(name), ...varint(value.length), ...value]),
  ...varint(parts.length), ...parts.flatMap(([name, tree]) => [...sized(name), ...tree])];
const varint = (number) => (number < 128 ? [number] : [(number & 127) | 128, ...varint(number >>> 7)]);
const sized = (name) => [Buffer.byteLength(name), ...Buffer.from(name)];
