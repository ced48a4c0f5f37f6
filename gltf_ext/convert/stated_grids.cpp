#include "gltf_ext/convert/stated_grids.h"

#include <algorithm>
#include <optional>

#include "gltf_ext/primitive/describe_primitive.h"
#include "src/cpu/draco_stream.h"

namespace psplit {
namespace {

AttributeCoding coding_of(const StreamDescription& stream, uint32_t unique_id) {
  const auto found = std::ranges::find(stream.attributes, unique_id, &StreamAttribute::unique_id);
  if (found == stream.attributes.end()) return {};
  return {found->bits, found->is_octahedral(), found->origin, found->range};
}

bool are_equal(const AttributeCoding& a, const AttributeCoding& b) {
  return a.bits == b.bits && a.octahedral == b.octahedral && a.origin == b.origin && a.range == b.range;
}

}  // namespace

std::vector<AttributeCoding> stated_grids(const Document& document, PrimitiveId id,
                                          const std::vector<Attribute>& attributes, const ThreadPool& pool) {
  std::vector<AttributeCoding> grids(attributes.size());
  if (document.records().primitive(id).storage() == PrimitiveStorage::kPlain) return grids;
  const Expected<DescribedPrimitive> described = describe_primitive(document, id, describe_stream, pool);
  if (!described || described->streams.empty()) return grids;
  for (const AttributeRequest& request : described->requests) {
    const auto found = std::ranges::find(attributes, request.semantic, &Attribute::semantic);
    if (found == attributes.end() || found->component_type != ComponentType::kFloat32) continue;
    AttributeCoding grid = coding_of(described->streams.front(), request.unique_id);
    const bool is_one = std::ranges::all_of(described->streams, [&](const StreamDescription& stream) {
      return are_equal(grid, coding_of(stream, request.unique_id));
    });
    if (is_one) grids[static_cast<size_t>(found - attributes.begin())] = std::move(grid);
  }
  return grids;
}

}  // namespace psplit
