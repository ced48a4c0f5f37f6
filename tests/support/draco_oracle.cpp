#include "tests/support/draco_oracle.h"

#include <draco/attributes/attribute_octahedron_transform.h>
#include <draco/attributes/attribute_quantization_transform.h>
#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>
#include <draco/point_cloud/point_cloud.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <utility>

namespace psplit {

namespace {

RawMesh points_of(const draco::PointCloud& source) {
  RawMesh mesh;
  mesh.point_count = source.num_points();
  for (int i = 0; i < source.num_attributes(); ++i) {
    const draco::PointAttribute& attribute = *source.attribute(i);
    RawAttribute raw{attribute.unique_id(),      attribute.attribute_type(), attribute.data_type(),
                     attribute.num_components(), attribute.normalized(),     {}};
    const auto stride = static_cast<size_t>(attribute.byte_stride());
    raw.point_values.resize(mesh.point_count * stride);
    for (uint32_t point = 0; point < mesh.point_count; ++point)
      attribute.GetMappedValue(draco::PointIndex(point), raw.point_values.data() + point * stride);
    mesh.attributes.push_back(std::move(raw));
  }
  return mesh;
}

#if defined(__aarch64__)
constexpr bool kLibdracoFuses = true;
#else
constexpr bool kLibdracoFuses = false;
#endif

// The unit vector of a place on an octahedron that is unfolded to a square.
std::array<float, 3> unit_vector(const int32_t* place, int bits) {
  const float scale = 2.0f / static_cast<float>((1 << bits) - 2);
  float y = static_cast<float>(place[0]) * scale - 1.0f, z = static_cast<float>(place[1]) * scale - 1.0f;
  const float x = 1.0f - std::fabs(y) - std::fabs(z), fold = std::max(-x, 0.0f);
  y += y < 0 ? fold : -fold;
  z += z < 0 ? fold : -fold;
  const float square = x * x + y * y + z * z;
  if (static_cast<double>(square) < 1e-6) return {};
  const float inverse = 1.0f / std::sqrt(square);
  return {x * inverse, y * inverse, z * inverse};
}

// Turns coded integers into floats. Returns false for an attribute that is not coded so. The tests are compiled
// with -ffp-contract=off, so nothing is fused here.
bool apply_transform(const draco::PointAttribute& attribute, RawAttribute& raw) {
  const draco::AttributeTransformData* data = attribute.GetAttributeTransformData();
  if (data == nullptr || data->transform_type() == draco::ATTRIBUTE_NO_TRANSFORM) return false;
  const bool is_normal = data->transform_type() == draco::ATTRIBUTE_OCTAHEDRON_TRANSFORM;
  draco::AttributeQuantizationTransform grid;
  draco::AttributeOctahedronTransform octahedron;
  if (!(is_normal ? octahedron.InitFromAttribute(attribute) : grid.InitFromAttribute(attribute))) return false;
  const auto components = static_cast<size_t>(raw.component_count);
  const size_t count = raw.point_values.size() / (components * sizeof(int32_t));
  const size_t written = is_normal ? 3 : components;
  std::vector<uint8_t> values(count * written * sizeof(float));
  for (size_t point = 0; point < count; ++point) {
    std::vector<int32_t> in(components);
    std::memcpy(in.data(), &raw.point_values[point * components * sizeof(int32_t)],
                components * sizeof(int32_t));
    std::vector<float> out;
    if (is_normal) {
      const std::array<float, 3> vector = unit_vector(in.data(), octahedron.quantization_bits());
      out.assign(vector.begin(), vector.end());
    } else {
      const float step = grid.range() / static_cast<float>((1u << grid.quantization_bits()) - 1);
      for (size_t k = 0; k < components; ++k)
        out.push_back(static_cast<float>(in[k]) * step + grid.min_value(static_cast<int>(k)));
    }
    std::memcpy(&values[point * written * sizeof(float)], out.data(), written * sizeof(float));
  }
  raw.component_count = static_cast<int>(written);
  raw.data_type = draco::DT_FLOAT32;
  raw.point_values = std::move(values);
  return true;
}

std::unique_ptr<draco::Mesh> decode(std::span<const uint8_t> stream, bool skip_transforms) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
  draco::Decoder decoder;
  if (skip_transforms)
    for (int type = 0; type < draco::GeometryAttribute::NAMED_ATTRIBUTES_COUNT; ++type)
      decoder.SetSkipAttributeTransform(static_cast<draco::GeometryAttribute::Type>(type));
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  return decoded.ok() ? std::move(decoded).value() : nullptr;
}

}  // namespace

std::optional<RawMesh> decode_with_libdraco(std::span<const uint8_t> stream, AttributeTransforms transforms) {
  if (kLibdracoFuses && transforms == AttributeTransforms::kApply)
    transforms = AttributeTransforms::kApplyUnfused;
  const std::unique_ptr<draco::Mesh> source = decode(stream, transforms == AttributeTransforms::kSkip);
  if (source == nullptr) return std::nullopt;
  RawMesh mesh = points_of(*source);
  if (transforms == AttributeTransforms::kApplyUnfused) {
    const std::unique_ptr<draco::Mesh> coded = decode(stream, true);
    if (coded == nullptr) return std::nullopt;
    RawMesh integers = points_of(*coded);
    for (int i = 0; i < coded->num_attributes(); ++i)
      if (apply_transform(*coded->attribute(i), integers.attributes[static_cast<size_t>(i)]))
        mesh.attributes[static_cast<size_t>(i)] = std::move(integers.attributes[static_cast<size_t>(i)]);
  }
  mesh.faces.reserve(source->num_faces());
  for (uint32_t i = 0; i < source->num_faces(); ++i) {
    const draco::Mesh::Face& face = source->face(draco::FaceIndex(i));
    mesh.faces.push_back({face[0].value(), face[1].value(), face[2].value()});
  }
  return mesh;
}

std::optional<RawMesh> decode_cloud_with_libdraco(std::span<const uint8_t> stream) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
  draco::PointCloud cloud;
  draco::Decoder decoder;
  if (!decoder.DecodeBufferToGeometry(&buffer, &cloud).ok()) return std::nullopt;
  return points_of(cloud);
}

}  // namespace psplit
