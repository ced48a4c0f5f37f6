// Draco mesh streams of every kind that libdraco's encoder writes, and libdraco's decoding of them: what our
// own decoder is measured against, bit for bit.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace psplit {

struct DracoStream {
  std::string name;  // unique in its set: mesh, then what was asked of the encoder
  std::vector<uint8_t> bytes;
};

enum class StreamSet {
  kSmall,  // hundreds of streams with every feature but the giants' ones; a second
  kAll,    // some ten thousand streams, up to two million points in one; ten seconds
};

// Calls `visit` with each stream of the set, in the same order and with the same bytes every time. libdraco
// decodes every one of them.
void for_each_draco_stream(const std::function<void(const DracoStream&)>& visit, StreamSet set);

// A mesh as libdraco decodes it, faces, points and attributes in its order.
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
  kSkip,   // the integers that were coded: grid steps, pairs of octahedral coordinates; always 32 bits
};

// Nothing where libdraco refuses the stream.
std::optional<RawMesh> decode_with_libdraco(std::span<const uint8_t> stream,
                                            AttributeTransforms transforms = AttributeTransforms::kApply);

}  // namespace psplit
