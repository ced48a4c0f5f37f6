// What the skeleton of a stream says: how its connectivity and its attributes are coded.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/core/attributes.h"
#include "src/core/prediction_data.h"
#include "src/status.h"

namespace psplit {

// In the head of a container.
inline constexpr size_t kMostSkeletonBytes = 4096, kMostSkeletons = 255;

struct SkeletonAttribute {
  bool is_raw = false;
  uint32_t components = 0;       // as they are coded: two for normals
  uint32_t component_bytes = 0;  // of an attribute that is stored raw
  core::Scheme scheme = core::Scheme::kNone;
  core::Transform transform = core::Transform::kWrap;  // unless the scheme is kNone
  bool is_normal = false;                              // on an octahedral grid
  uint32_t grid_max = 0;  // the largest number of the grid, if its corrections have an octahedral transform
  uint32_t group = 0;     // in Skeleton::groups
  size_t scheme_at = 0;   // the place of the scheme's byte, unless it is raw

  bool has_wrap_range() const { return !is_raw && !is_normal && scheme != core::Scheme::kNone; }
  // Whether its values can be stored in the order of creation, with predictions of our own.
  bool allows_creation_order() const {
    return !is_raw && (scheme == core::Scheme::kNone || scheme == core::Scheme::kDifference ||
                       (scheme == core::Scheme::kParallelogram && !is_normal));
  }
};

struct Skeleton {
  bool is_valence = false;
  uint32_t data_count = 0;                    // attribute data, which may have seams
  std::vector<core::Group<uint32_t>> groups;  // without tables and sequences
  std::vector<SkeletonAttribute> attributes;  // in the order of the stream
};

// Reads the literal bytes of DracoFields::skeleton, which may be anything.
Expected<Skeleton> read_skeleton(std::span<const uint8_t> literals);

}  // namespace psplit
