// libdraco for Python, as the module draco_reference: what the package gltf_psplit is compared with in tests,
// and measured against in bindings/python/benchmark.py.
#include <draco/compression/decode.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "psplit/decode.h"

namespace {

namespace py = pybind11;

std::unique_ptr<draco::PointCloud> decoded_of(const std::string_view stream, bool integers) {
  draco::DecoderBuffer buffer;
  buffer.Init(stream.data(), stream.size());
  draco::Decoder decoder;
  if (integers)
    for (int type = 0; type < draco::GeometryAttribute::NAMED_ATTRIBUTES_COUNT; ++type)
      decoder.SetSkipAttributeTransform(static_cast<draco::GeometryAttribute::Type>(type));
  auto decoded = decoder.DecodePointCloudFromBuffer(&buffer);
  if (!decoded.ok()) throw py::value_error(decoded.status().error_msg_string());
  return std::move(decoded).value();
}

const char* type_code(draco::DataType type) {
  constexpr const char* kCodes[] = {"", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8", "u1"};
  return kCodes[type];
}

const draco::Mesh* mesh_of(const draco::PointCloud& cloud) { return dynamic_cast<const draco::Mesh*>(&cloud); }

// (faces, [(semantic, unique id, values)]), every value as libdraco has it.
py::tuple decode(const py::bytes& stream, bool integers) {
  const std::unique_ptr<draco::PointCloud> cloud = decoded_of(std::string_view(stream), integers);
  const draco::Mesh* const mesh = mesh_of(*cloud);
  py::array_t<uint32_t> faces({mesh == nullptr ? size_t{0} : size_t{mesh->num_faces()}, size_t{3}});
  for (uint32_t f = 0; f < static_cast<uint32_t>(faces.shape(0)); ++f)
    for (uint32_t k = 0; k < 3; ++k) faces.mutable_at(f, k) = mesh->face(draco::FaceIndex(f))[k].value();
  py::list attributes;
  for (int i = 0; i < cloud->num_attributes(); ++i) {
    const draco::PointAttribute& attribute = *cloud->attribute(i);
    py::array values(py::dtype(type_code(attribute.data_type())),
                     std::vector<size_t>{cloud->num_points(), size_t{attribute.num_components()}});
    auto* to = static_cast<char*>(values.mutable_data());
    for (draco::PointIndex point(0); point < cloud->num_points(); ++point) {
      attribute.GetMappedValue(point, to);
      to += attribute.byte_stride();
    }
    attributes.append(
        py::make_tuple(static_cast<int>(attribute.attribute_type()), attribute.unique_id(), values));
  }
  return py::make_tuple(faces, attributes);
}

// Positions and faces in vectors, as bindings take them out of libdraco: value by value, positions as floats.
struct Vectors {
  std::vector<float> points;
  std::vector<unsigned> faces;
};

Vectors vectors_of(const py::bytes& stream) {
  const std::unique_ptr<draco::PointCloud> cloud = decoded_of(std::string_view(stream), false);
  const draco::PointAttribute* const positions = cloud->GetNamedAttribute(draco::GeometryAttribute::POSITION);
  if (positions == nullptr) throw py::value_error("no positions");
  Vectors vectors;
  vectors.points.reserve(3 * size_t{cloud->num_points()});
  for (draco::PointIndex point(0); point < cloud->num_points(); ++point) {
    std::array<float, 3> value{};
    if (!positions->ConvertValue<float, 3>(positions->mapped_index(point), value.data()))
      throw py::value_error("positions are no floats");
    for (const float x : value) vectors.points.push_back(x);
  }
  if (const draco::Mesh* const mesh = mesh_of(*cloud)) {
    vectors.faces.reserve(3 * size_t{mesh->num_faces()});
    for (draco::FaceIndex face(0); face < mesh->num_faces(); ++face)
      for (size_t k = 0; k < 3; ++k) vectors.faces.push_back(mesh->face(face)[k].value());
  }
  return vectors;
}

// (faces, points) as arrays, which are copies of the vectors.
py::tuple decode_to_arrays(const py::bytes& stream) {
  const Vectors vectors = vectors_of(stream);
  return py::make_tuple(
      py::array_t<unsigned>(std::vector<size_t>{vectors.faces.size() / 3, 3}, vectors.faces.data()),
      py::array_t<float>(std::vector<size_t>{vectors.points.size() / 3, 3}, vectors.points.data()));
}

// psplit's decoder in C++, without arrays. The caller frees the result.
py::capsule decode_in_cpp(const py::bytes& stream) {
  const std::string_view bytes(stream);
  const std::span<const uint8_t> span(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
  auto geometry = psplit::decode_geometry(span);
  if (!geometry) throw py::value_error(geometry.status().to_string());
  return py::capsule(new psplit::DracoGeometry(std::move(*geometry)),
                     [](void* at) { delete static_cast<psplit::DracoGeometry*>(at); });
}

}  // namespace

PYBIND11_MODULE(draco_reference, module) {
  module.def("decode", &decode, py::arg("stream"), py::arg("integers") = false);
  module.def("decode_to_arrays", &decode_to_arrays, py::arg("stream"));
  module.def("decode_in_cpp", &decode_in_cpp, py::arg("stream"));
}
