// Everything that a page can ask of a decoded mesh or point cloud, by the calls of draco3d.
import assert from 'node:assert/strict';

// A mesh, or a point cloud, that a decoder of its own decodes.
export function decoded(draco, bytes, skipped = [], mesh = new draco.Mesh()) {
  const decoder = new draco.Decoder(), decode = mesh instanceof draco.Mesh ? 'DecodeArrayToMesh' : 'DecodeArrayToPointCloud';
  for (const semantic of skipped) decoder.SkipAttributeTransform(draco[semantic]);
  const status = decoder[decode](new Int8Array(bytes), bytes.length, mesh);
  return { decoder, mesh, status };
}

export function ask(draco, bytes, skipped = []) {
  const decoder = new draco.Decoder(), buffer = new draco.DecoderBuffer();
  const is_cloud = decoder.GetEncodedGeometryType(new Int8Array(bytes)) === draco.POINT_CLOUD;
  const mesh = is_cloud ? new draco.PointCloud() : new draco.Mesh();
  const answers = {};
  try {
    for (const semantic of skipped) decoder.SkipAttributeTransform(draco[semantic]);
    buffer.Init(new Int8Array(bytes), bytes.length);
    answers.kinds = [decoder.GetEncodedGeometryType(buffer), decoder.GetEncodedGeometryType(new Int8Array(bytes))];
    const status = is_cloud ? decoder.DecodeBufferToPointCloud(buffer, mesh) : decoder.DecodeBufferToMesh(buffer, mesh);
    answers.ok = [status.ok(), status.code() === draco.OK];
    if (!status.ok()) return answers;
    answers.counts = [is_cloud ? 0 : mesh.num_faces(), mesh.num_points(), mesh.num_attributes()];
    const [faces, points] = answers.counts;
    const memory = (size, write) => {
      const at = draco._malloc(size);
      const written = write(size, at);
      const result = written === false ? false : draco.HEAPU8.slice(at, at + size);
      draco._free(at);
      return result;
    };
    if (!is_cloud) {
      answers.triangles = memory(12 * faces, (size, at) => void decoder.GetTrianglesUInt32Array(mesh, size, at));
      answers.triangles_16 = memory(6 * faces, (size, at) => void decoder.GetTrianglesUInt16Array(mesh, size, at));
      answers.wrong_size = decoder.GetTrianglesUInt32Array(mesh, 12 * faces - 4, 0);
      const face = new draco.DracoInt32Array();
      answers.face = [decoder.GetFaceFromMesh(mesh, faces - 1, face), face.GetValue(0), face.GetValue(1), face.GetValue(2)];
    }
    answers.ids = ['POSITION', 'NORMAL', 'COLOR', 'TEX_COORD', 'GENERIC'].map((name) => decoder.GetAttributeId(mesh, draco[name]));
    answers.attributes = Array.from({ length: mesh.num_attributes() }, (_, i) => {
      const attribute = decoder.GetAttribute(mesh, i);
      const facts = [attribute.attribute_type(), attribute.data_type(), attribute.num_components(), attribute.normalized(),
        attribute.unique_id(), attribute.byte_stride()];
      assert.equal(decoder.GetAttributeByUniqueId(mesh, attribute.unique_id()).unique_id(), attribute.unique_id());
      const arrays = {};
      for (const [type, bytes_each] of [['INT8', 1], ['UINT8', 1], ['INT16', 2], ['UINT16', 2], ['INT32', 4], ['UINT32', 4], ['FLOAT32', 4]])
        arrays[type] = memory(points * attribute.num_components() * bytes_each, (size, at) =>
          decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, draco[`DT_${type}`], size, at));
      const floats = new draco.DracoFloat32Array(), integers = new draco.DracoInt32Array();
      const values = [decoder.GetAttributeFloatForAllPoints(mesh, attribute, floats), floats.size(), floats.GetValue(floats.size() - 1)];
      if (attribute.data_type() !== draco.DT_FLOAT32)
        values.push(decoder.GetAttributeInt32ForAllPoints(mesh, attribute, integers), integers.size(), integers.GetValue(0));
      const quantization = new draco.AttributeQuantizationTransform(), octahedron = new draco.AttributeOctahedronTransform();
      const transforms = [quantization.InitFromAttribute(attribute), octahedron.InitFromAttribute(attribute)];
      if (transforms[0]) transforms.push(quantization.quantization_bits(), quantization.range(), ...[0, 1, 2].slice(0, attribute.num_components()).map((axis) => quantization.min_value(axis)));
      if (transforms[1]) transforms.push(octahedron.quantization_bits());
      return { facts, arrays, values, transforms };
    });
    return answers;
  } finally {
    for (const object of [buffer, mesh, decoder]) draco.destroy(object);
  }
}

export const values_of = (array) => Array.from({ length: array.size() }, (_, i) => array.GetValue(i));

// Everything that can be read of an attribute, in every type.
export function read_all({ decoder, mesh }, draco) {
  const arrays = [...['Int8', 'UInt8', 'Int16', 'UInt16', 'Int32', 'UInt32', 'Int'].map((name) => [name, /UInt/.test(name) ? name : name === 'Int' ? 'Int32' : name]), ['Float', 'Float32']];
  return Array.from({ length: mesh.num_attributes() }, (_, i) => {
    const attribute = decoder.GetAttribute(mesh, i), components = attribute.num_components(), data = attribute.GetAttributeTransformData();
    const facts = [attribute.attribute_type(), attribute.data_type(), components, attribute.normalized(), attribute.unique_id(),
      attribute.byte_stride(), draco.getPointer(data) !== 0 && data.transform_type()];
    const read = arrays.filter(([name]) => name !== 'Float' || components <= 4).map(([name, of]) => {
      const out = new draco[`Draco${of}Array`]();
      return [name, decoder[`GetAttribute${name}ForAllPoints`](mesh, attribute, out) && values_of(out)];
    });
    // Stored values, by their numbers.
    const stored = [attribute.size()], value = new draco.DracoFloat32Array();
    for (const number of new Set([0, 1, attribute.size() >> 1, attribute.size() - 1]))
      if (components <= 4) stored.push(decoder.GetAttributeFloat(attribute, number, value) && values_of(value));
    const written = [];
    for (let type = 0; type <= draco.DT_TYPES_COUNT; ++type) {
      const bytes = [0, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8, 1, 4][type], size = bytes * mesh.num_points() * components, at = draco._malloc(size);
      written.push(decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, type, size, at) && draco.HEAPU8.slice(at, at + size));
      draco._free(at);
    }
    return { facts, stored, read, written };
  });
}
