#include "tests/support/draco_oracle.h"

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>
#include <draco/point_cloud/point_cloud.h>

#include <memory>
#include <utility>

#include "encoder/draco/unfused_values.h"

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
  if (transforms == AttributeTransforms::kApplyUnfused) {
    const std::unique_ptr<draco::Mesh> coded = decode(stream, true);
    if (coded == nullptr) return std::nullopt;
    set_unfused_values(*coded, *source);
  }
  RawMesh mesh = points_of(*source);
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
