// Streams that the core decodes, as meshes to compare.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "encoder/stitching/stitch_map.h"
#include "src/core/workspace.h"
#include "tests/support/draco_streams.h"
#include "tests/support/emulated_warp.h"

namespace psplit::core {

template <typename Index>
std::vector<std::array<uint32_t, 3>> faces_of(const Patch<Index>& patch) {
  std::vector<std::array<uint32_t, 3>> faces;
  for (uint32_t face = 0; face < patch.face_count; ++face)
    faces.push_back({patch.point_at[4 * face], patch.point_at[4 * face + 1], patch.point_at[4 * face + 2]});
  return faces;
}

// `run(body)` calls body(lanes) on all lanes.
inline constexpr auto kOneLane = [](auto body) { body(SerialLanes()); };

template <typename Index, typename Run>
RawMesh raw_mesh(const Patch<Index>& patch, Run run) {
  RawMesh mesh;
  mesh.point_count = patch.point_count;
  mesh.faces = faces_of(patch);
  for (uint32_t i = 0; i < patch.attributes.size(); ++i) {
    const Attribute<Index>& attribute = patch.attributes[i];
    RawAttribute raw{attribute.unique_id,  attribute.semantic,   static_cast<int>(attribute.type),
                     attribute.components, attribute.normalized, {}};
    raw.point_values.resize(size_t{patch.point_count} * attribute.stride());
    const auto place_of = [&](uint32_t point) { return &raw.point_values[size_t{point} * attribute.stride()]; };
    run([&](auto lanes) { patch.write_values(lanes, attribute, attribute.type, place_of); });
    mesh.attributes.push_back(std::move(raw));
  }
  return mesh;
}

template <typename Index>
RawMesh raw_mesh(const Patch<Index>& patch) {
  return raw_mesh(patch, kOneLane);
}

// Decodes with memory that grows until it is enough: decode_with(arena, patch).
template <typename Index, typename DecodeWith, typename Run>
Fault decode(DecodeWith decode_with, Run run, RawMesh& out) {
  for (size_t size = size_t{1} << 16;; size *= 2) {
    std::vector<uint8_t> memory(size);
    Arena arena(memory.data(), memory.size());
    const auto patch = std::make_unique<Patch<Index>>();
    const Fault fault = decode_with(arena, *patch);
    if (fault == Fault::kWorkspace && size < size_t{1} << 32) continue;
    if (fault == Fault::kNone) out = raw_mesh(*patch, run);
    return fault;
  }
}

// The walk over the border must be the one that the specification defines, which knows faces and points only.
template <typename Index>
Fault expect_walk_by_definition(const Patch<Index>& patch, Arena& arena) {
  View<Index> walk;
  const Fault fault = walk_border(patch, arena, walk);
  if (fault != Fault::kNone) return fault;
  std::vector<uint32_t> expected;
  if (!patch.mesh.table.opposite.empty()) expected = border_walk(faces_of(patch), patch.point_count);
  EXPECT_TRUE(std::equal(walk.data(), walk.data() + walk.size(), expected.begin(), expected.end()));
  return fault;
}

// What follows is compiled once (decode_mesh.cpp), for uint16_t and uint32_t: all of the core takes the
// compiler long.

template <typename Index>
Fault decode(const StreamHeader& header, RawMesh& out);

template <typename Index>
Fault decode_by_warp(const StreamHeader& header, LaneOrder order, RawMesh& out);

// Decodes in exactly the memory that the counts ask for, and walks the border in it.
template <typename Index>
Fault decode_in_workspace(const StreamHeader& header, size_t stream_bytes, const RawMesh& expected,
                          RawMesh& out);

// Decodes streams in step, and each alone: they do not disturb each other, even if they have little in common
// or are broken.
class InStep {
 public:
  static constexpr uint32_t kCount = 3;
  size_t whole = 0, broken = 0;

  void expect_as_alone(const StreamHeader (&headers)[kCount]);

 private:
  static constexpr size_t kMemory = size_t{1} << 24;
  std::vector<uint8_t> memory_ = std::vector<uint8_t>(kCount * kMemory);
  std::unique_ptr<Patch<uint16_t>[]> patches_ = std::make_unique<Patch<uint16_t>[]>(kCount);
};

}  // namespace psplit::core
