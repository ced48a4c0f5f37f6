#include "bindings/python/native/encode.h"

#include <pybind11/stl.h>

#include <cstring>

#include "bindings/python/native/arrays.h"
#include "bindings/python/native/pools.h"
#include "encoder/coding/choose_codings.h"
#include "encoder/encode_mesh.h"
#include "encoder/encode_streams.h"
#include "encoder/stock_stream.h"

namespace psplit::python {
namespace {

using Indices = py::array_t<uint32_t, py::array::c_style | py::array::forcecast>;
// (semantic, C-contiguous values of (points, components), normalized)
using Given = std::tuple<std::string, py::array, bool>;

ComponentType component_type(const py::dtype& type) {
  const std::string code = type.kind() + std::to_string(type.itemsize());
  for (const ComponentType candidate :
       {ComponentType::kInt8, ComponentType::kUint8, ComponentType::kInt16, ComponentType::kUint16,
        ComponentType::kUint32, ComponentType::kFloat32})
    if (code == type_code(candidate)) return candidate;
  throw py::type_error("glTF has no attributes of the type " + code);
}

Attribute attribute_of(const Given& given) {
  const auto& [semantic, values, normalized] = given;
  Attribute attribute{
      semantic, component_type(values.dtype()), static_cast<uint8_t>(values.shape(1)), normalized, {}};
  attribute.values.resize(static_cast<size_t>(values.nbytes()));
  if (!attribute.values.empty()) std::memcpy(attribute.values.data(), values.data(), attribute.values.size());
  return attribute;
}

Mesh mesh_of(const Indices& faces, const std::vector<Given>& attributes) {
  Mesh mesh;
  mesh.point_count = static_cast<uint32_t>(std::get<1>(attributes.at(0)).shape(0));
  mesh.faces.resize(static_cast<size_t>(faces.shape(0)));
  if (!mesh.faces.empty())
    std::memcpy(mesh.faces[0].data(), faces.data(), mesh.faces.size() * sizeof(mesh.faces[0]));
  for (const Given& given : attributes) mesh.attributes.push_back(attribute_of(given));
  return mesh;
}

// A grid that the caller chose. libdraco takes the grid from the extremes of the values, so none may be
// outside.
Expected<AttributeCoding> chosen_grid(const Attribute& positions, int bits, const std::vector<float>& origin,
                                      float range) {
  AttributeCoding grid{bits, false, origin, range};
  const auto* const values = reinterpret_cast<const float*>(positions.values.data());
  for (size_t i = 0; i < positions.values.size() / sizeof(float); ++i) {
    const float low = origin[i % origin.size()];
    if (!(values[i] >= low && values[i] - low <= range))
      return invalid_input("point " + std::to_string(i / origin.size()) + " is outside of the grid");
  }
  return grid;
}

struct Encoding {
  CodingOptions bits;
  std::vector<float> origin;  // of the grid of positions; empty: it is fitted to them
  float range = 0;
  int speed = 9;
};

Expected<std::vector<AttributeCoding>> codings_of(Mesh& mesh, const Encoding& encoding) {
  std::vector<AttributeCoding> codings = choose_codings(mesh, encoding.bits);
  // Positions are the first attribute. choose_codings keeps values that have no grid; here that is an error.
  if (const int bits = encoding.bits.position_bits; bits > 0) {
    Expected<AttributeCoding> grid =
        encoding.origin.empty() ? fit_grid(mesh.attributes[0], bits)
                                : chosen_grid(mesh.attributes[0], bits, encoding.origin, encoding.range);
    if (!grid) return grid.status();
    codings[0] = std::move(*grid);
  }
  if (Status status = check_mesh(mesh, codings); !status.ok()) return status;
  if (mesh.faces.empty()) return invalid_input("the mesh has no triangles");
  return codings;
}

// One ordinary Draco stream. Sequential streams keep the order of points and faces.
Expected<std::vector<uint8_t>> encode_stream(Mesh mesh, const Encoding& encoding, bool sequential) {
  const Expected<std::vector<AttributeCoding>> codings = codings_of(mesh, encoding);
  if (!codings) return codings.status();
  Expected<StockStream> stream = sequential ? encode_stock_sequential(mesh, *codings, encoding.speed)
                                            : encode_stock_stream(mesh, *codings, encoding.speed);
  if (!stream) return stream.status();
  return std::move(stream->bytes);
}

Expected<EncodedMesh> encode_patches(Mesh mesh, const Encoding& encoding, uint32_t patch_count,
                                     const ThreadPool& pool) {
  const Expected<std::vector<AttributeCoding>> codings = codings_of(mesh, encoding);
  if (!codings) return codings.status();
  EncodeOptions options;
  options.patch_count = patch_count;
  options.encode_speed = encoding.speed;
  return encode_mesh(mesh, *codings, options, pool);
}

py::bytes bytes_of(const std::vector<uint8_t>& bytes) {
  return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

Encoding encoding_of(int position_bits, int normal_bits, int texcoord_bits, std::vector<float> origin,
                     float range, int speed) {
  Encoding encoding;
  encoding.bits.position_bits = position_bits;
  encoding.bits.normal_bits = normal_bits;
  encoding.bits.texcoord_bits = texcoord_bits;
  encoding.bits.give_changed_bits();
  encoding.bits.given.position = true;  // the stream's metadata repeat them
  encoding.origin = std::move(origin);
  encoding.range = range;
  encoding.speed = speed;
  return encoding;
}

py::bytes encode(const Indices& faces, const std::vector<Given>& attributes, int position_bits, int normal_bits,
                 int texcoord_bits, const std::vector<float>& origin, float range, int speed, bool sequential) {
  Mesh mesh = mesh_of(faces, attributes);
  const Encoding encoding = encoding_of(position_bits, normal_bits, texcoord_bits, origin, range, speed);
  std::optional<Expected<std::vector<uint8_t>>> bytes;
  {
    const py::gil_scoped_release release;
    bytes.emplace(encode_stream(std::move(mesh), encoding, sequential));
  }
  return bytes_of(value_or_throw(std::move(*bytes)));
}

// (bytes, [(semantic, unique id, component type, components, normalized)], point count, face count)
py::tuple encode_container(const Indices& faces, const std::vector<Given>& attributes, int position_bits,
                           int normal_bits, int texcoord_bits, const std::vector<float>& origin, float range,
                           int speed, uint32_t patch_count, int thread_count) {
  Mesh mesh = mesh_of(faces, attributes);
  const Encoding encoding = encoding_of(position_bits, normal_bits, texcoord_bits, origin, range, speed);
  const EncodedMesh done = value_or_throw(with_pool(thread_count, [&](const ThreadPool& pool) {
    const py::gil_scoped_release release;
    return encode_patches(std::move(mesh), encoding, patch_count, pool);
  }));
  py::list requests;
  for (const AttributeRequest& request : done.requests)
    requests.append(py::make_tuple(request.semantic, request.unique_id, int{uint16_t(request.component_type)},
                                   int{request.component_count}, request.normalized));
  return py::make_tuple(bytes_of(done.container), requests, done.decoded.point_count,
                        done.decoded.faces.size());
}

}  // namespace

void add_encode(py::module_& module) {
  module.def("encode", &encode);
  module.def("encode_container", &encode_container);
}

}  // namespace psplit::python
