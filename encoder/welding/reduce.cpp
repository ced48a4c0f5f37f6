#include "encoder/welding/reduce.h"

#include <cstring>

#include "encoder/welding/weld.h"

namespace psplit {
namespace {

constexpr uint32_t kDropped = 0xffffffffu;

Attribute select_points(const Attribute& attribute, std::span<const uint32_t> points) {
  Attribute selected{
      attribute.semantic, attribute.component_type, attribute.component_count, attribute.normalized, {}};
  const size_t stride = attribute.stride();
  selected.values.resize(stride * points.size());
  for (size_t i = 0; i < points.size(); ++i)
    std::memcpy(selected.values.data() + i * stride, attribute.values.data() + points[i] * stride, stride);
  return selected;
}

}  // namespace

ReducedMesh reduce(const Mesh& input, const ReduceOptions& options, std::span<const std::byte> extra,
                   size_t extra_stride) {
  std::vector<uint32_t> lowest;
  if (!options.keep_duplicates) lowest = find_duplicates(input, extra, extra_stride);
  const auto representative = [&](uint32_t point) { return lowest.empty() ? point : lowest[point]; };

  ReducedMesh reduced;
  reduced.mesh.faces.reserve(input.faces.size());
  std::vector<uint8_t> used(input.point_count, options.drop_unused ? 0 : 1);
  for (const auto& face : input.faces) {
    const std::array<uint32_t, 3> merged = {representative(face[0]), representative(face[1]),
                                            representative(face[2])};
    if (options.drop_degenerate && repeats_a_point(merged)) {
      ++reduced.dropped_faces;
      continue;
    }
    for (const uint32_t point : merged) used[point] = 1;
    reduced.mesh.faces.push_back(merged);
  }

  std::vector<uint32_t> number(input.point_count, kDropped);
  for (uint32_t point = 0; point < input.point_count; ++point) {
    if (representative(point) != point) {
      ++reduced.merged_points;
    } else if (!used[point]) {
      ++reduced.dropped_points;
    } else {
      number[point] = static_cast<uint32_t>(reduced.source_point.size());
      reduced.source_point.push_back(point);
    }
  }
  for (auto& face : reduced.mesh.faces)
    for (uint32_t& point : face) point = number[point];
  reduced.mesh.point_count = static_cast<uint32_t>(reduced.source_point.size());
  for (const Attribute& attribute : input.attributes)
    reduced.mesh.attributes.push_back(select_points(attribute, reduced.source_point));
  return reduced;
}

}  // namespace psplit
