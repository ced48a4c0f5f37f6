// Decodes streams with libdraco. Our own decoder must give the same bits.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace psplit {

// A mesh as libdraco decodes it, with faces, points and attributes in libdraco's order.
struct RawAttribute {
  uint32_t unique_id = 0;
  int type = 0;       // draco::GeometryAttribute::Type
  int data_type = 0;  // draco::DataType
  int component_count = 0;
  bool normalized = false;
  std::vector<uint8_t> point_values;  // one value per point, tightly packed

  bool operator==(const RawAttribute&) const = default;
};
struct RawMesh {
  uint32_t point_count = 0;
  std::vector<std::array<uint32_t, 3>> faces;
  std::vector<RawAttribute> attributes;

  bool operator==(const RawMesh&) const = default;
};

enum class AttributeTransforms {
  kApply,  // floats, as a loader gets them
  kSkip,   // the coded integers: grid steps, pairs of octahedral coordinates; always 32 bits
  // Floats that the oracle itself calculates from the coded integers, rounded after each operation. A libdraco
  // for a machine that fuses multiply-adds gives other bits, so there kApply is this.
  kApplyUnfused,
};

// Nothing if libdraco rejects the stream.
std::optional<RawMesh> decode_with_libdraco(std::span<const uint8_t> stream,
                                            AttributeTransforms transforms = AttributeTransforms::kApply);
// Decodes a point cloud, to a mesh without faces.
std::optional<RawMesh> decode_cloud_with_libdraco(std::span<const uint8_t> stream,
                                                  AttributeTransforms transforms = AttributeTransforms::kApply);

}  // namespace psplit
