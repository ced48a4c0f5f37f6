#include "tests/support/draco_oracle.h"

#include <draco/compression/decode.h>
#include <draco/point_cloud/point_cloud.h>

#include <memory>
#include <utility>

#include "encoder/libdraco/patch_stream.h"
#include "encoder/libdraco/unfused_values.h"
#include "psplit/decode.h"

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

std::unique_ptr<draco::Mesh> decode(std::span<const uint8_t> stream, bool keep_quantized) {
  auto decoded = decode_unfused(stream, keep_quantized);
  return decoded.ok() ? std::move(decoded).value() : nullptr;
}

bool decode_cloud(std::span<const uint8_t> stream, bool keep_quantized, draco::PointCloud& cloud) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
  draco::Decoder decoder;
  if (keep_quantized) keep_integers(decoder);
  return decoder.DecodeBufferToGeometry(&buffer, &cloud).ok();
}

// libdraco keeps the grids of a kD-tree to itself.
void set_unfused_values_of_tree(const StreamDescription& description, const draco::PointCloud& coded,
                                draco::PointCloud& decoded) {
  for (size_t i = 0; i < description.attributes.size(); ++i) {
    const StreamAttribute& grid = description.attributes[i];
    const draco::PointAttribute& steps = *coded.attribute(static_cast<int>(i));
    draco::PointAttribute& attribute = *decoded.attribute(static_cast<int>(i));
    if (grid.bits == 0 || attribute.data_type() != draco::DT_FLOAT32) continue;
    const float step = grid.range / static_cast<float>((1u << grid.bits) - 1);
    std::vector<uint32_t> in(grid.components);
    std::vector<float> out(grid.components);
    for (uint32_t n = 0; n < attribute.size(); ++n) {
      steps.GetValue(draco::AttributeValueIndex(n), in.data());
      for (size_t k = 0; k < in.size(); ++k)
        out[k] = static_cast<float>(static_cast<int32_t>(in[k])) * step + grid.origin[k];
      attribute.SetAttributeValue(draco::AttributeValueIndex(n), out.data());
    }
  }
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

std::optional<RawMesh> decode_cloud_with_libdraco(std::span<const uint8_t> stream,
                                                  AttributeTransforms transforms) {
  const bool keep_quantized = transforms == AttributeTransforms::kSkip;
  draco::PointCloud cloud, coded;
  if (!decode_cloud(stream, keep_quantized, cloud)) return std::nullopt;
  if (keep_quantized || (!kLibdracoFuses && transforms == AttributeTransforms::kApply)) return points_of(cloud);
  const Expected<StreamDescription> description = describe_stream(stream);
  if (!description || !decode_cloud(stream, true, coded)) return std::nullopt;
  if (description->coding == StreamCoding::kCloudKdTree)
    set_unfused_values_of_tree(*description, coded, cloud);
  else
    set_unfused_values(coded, cloud);
  return points_of(cloud);
}

}  // namespace psplit
