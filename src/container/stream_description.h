// The contents of a Draco stream, and the glTF attributes that they become.
#pragma once

#include <cstdint>
#include <functional>
#include <tuple>
#include <vector>

#include "src/container/decode_backend.h"
#include "src/core/data_type.h"
#include "src/span.h"

namespace psplit {

// Draco's attribute types, with the numbers that Draco gives them.
enum class DracoSemantic : uint8_t { kPosition, kNormal, kColor, kTexCoord, kGeneric };

// Draco's type for the components of an accessor.
constexpr core::DataType stored_type(ComponentType type) {
  switch (type) {
    case ComponentType::kInt8: return core::DataType::kInt8;
    case ComponentType::kUint8: return core::DataType::kUint8;
    case ComponentType::kInt16: return core::DataType::kInt16;
    case ComponentType::kUint16: return core::DataType::kUint16;
    case ComponentType::kUint32: return core::DataType::kUint32;
    case ComponentType::kFloat32: break;
  }
  return core::DataType::kFloat32;
}

struct StreamAttribute {
  uint32_t unique_id = 0;
  DracoSemantic semantic = DracoSemantic::kGeneric;
  core::DataType type = core::DataType::kFloat32;  // of the decoded values
  uint8_t components = 0;
  bool normalized = false;
  uint8_t bits = 0;  // of a component on its grid, or of a normal's octahedron; 0 if values are stored exactly
  // The grid of quantized values that are not on an octahedron: origin + i * range / (2^bits - 1), with an
  // origin for each component.
  float range = 0;
  std::vector<float> origin{};

  bool is_octahedral() const { return bits > 0 && origin.empty(); }

  friend bool operator==(const StreamAttribute& a, const StreamAttribute& b) {
    const auto members = [](const StreamAttribute& of) {
      return std::tie(of.unique_id, of.semantic, of.type, of.components, of.normalized, of.bits, of.range,
                      of.origin);
    };
    return members(a) == members(b);
  }
};

enum class StreamCoding : uint8_t {
  kSequential,
  kEdgebreaker,            // the standard traversal
  kEdgebreakerPredictive,  // streams before 2.2 only
  kEdgebreakerValence,
  kCloudSequential,  // point clouds
  kCloudKdTree,
};
constexpr bool is_cloud(StreamCoding coding) {
  return coding == StreamCoding::kCloudSequential || coding == StreamCoding::kCloudKdTree;
}
// "sequential", "edgebreaker", "edgebreaker-predictive", "edgebreaker-valence", "cloud-sequential",
// "cloud-kd-tree".
PSPLIT_EXPORT const char* coding_name(StreamCoding coding);

struct StreamDescription {
  StreamCoding coding = StreamCoding::kSequential;
  uint32_t face_count = 0, point_count = 0;  // as decoded; a point cloud has no faces
  std::vector<StreamAttribute> attributes;   // in the order of the stream

  friend bool operator==(const StreamDescription& a, const StreamDescription& b) {
    return a.coding == b.coding && a.face_count == b.face_count && a.point_count == b.point_count &&
           a.attributes == b.attributes;
  }
};

// describe_stream (src/cpu/draco_stream.h), describe_draco_stream (encoder/libdraco/draco_backend.h), or one
// after the other.
using DescribeStream = std::function<Expected<StreamDescription>(Span<const uint8_t> stream)>;

// The requests that make each attribute one that glTF allows, in the same order. The names are POSITION,
// NORMAL, TEXCOORD_n and COLOR_n for data of the types that glTF gives these names, and _GENERIC_n for all
// other data. 32-bit and 64-bit integers and doubles become floats, and bools become bytes. Integer colours are
// normalized. Errors: kUnsupported (a number of components that no glTF type has), kInvalidInput (no positions,
// or two attributes with one unique id).
PSPLIT_EXPORT Expected<std::vector<AttributeRequest>> gltf_attributes(Span<const StreamAttribute> attributes);

}  // namespace psplit
