#include "gltf_ext/compare/declared_grids.h"

#include <algorithm>
#include <cmath>

#include "encoder/coding/quantization.h"
#include "src/condensed/expand_container.h"

namespace psplit {
namespace {

DeclaredGrid grid_of(const StreamAttribute& attribute) {
  DeclaredGrid grid;
  grid.coding = {attribute.bits, attribute.origin.empty(), attribute.origin, attribute.range};
  for (const double bound : error_bounds(grid.coding))
    if (std::isfinite(bound)) grid.within = std::max(grid.within, bound);
  grid.identity = std::to_string(attribute.bits);
  if (grid.coding.octahedral) return grid;
  for (const float number : attribute.origin)
    grid.identity.append(reinterpret_cast<const char*>(&number), sizeof number);
  grid.identity.append(reinterpret_cast<const char*>(&attribute.range), sizeof attribute.range);
  return grid;
}

}  // namespace

Expected<std::map<std::string, DeclaredGrid>> declared_grids(const Document& document, PrimitiveId id,
                                                             const DescribeStream& describe,
                                                             const ThreadPool& pool) {
  std::map<std::string, DeclaredGrid> grids;
  const PrimitiveStorage storage = document.records().primitive(id).storage();
  if (storage == PrimitiveStorage::kPlain) return grids;
  const bool patched = storage == PrimitiveStorage::kPatches;
  const auto stored = stored_primitive(document, id);
  if (!stored) return stored.status();
  std::vector<std::span<const uint8_t>> streams{stored->bytes};
  Expected<PatchContainer> container = PatchContainer();
  if (patched) {
    container = open_container(stored->bytes);
    if (!container) return container.status();
    streams = container->streams;
  }

  // The patches that psplit writes share their grids. Those of other encoders may not.
  std::vector<Expected<StreamDescription>> descriptions(streams.size(), StreamDescription{});
  pool.for_each(streams.size(), [&](size_t i) {
    if (!patched || !container->entries[i].is_condensed) {
      descriptions[i] = describe(streams[i]);
      return;
    }
    const auto expanded = expand_patch(*container, static_cast<uint32_t>(i));
    descriptions[i] = expanded ? describe(*expanded) : expanded.status();
  });
  for (size_t i = 0; i < streams.size(); ++i) {
    if (!descriptions[i]) return descriptions[i].status().at({.patch = patched ? static_cast<int64_t>(i) : -1});
    for (const AttributeRequest& request : stored->requests) {
      const auto& attributes = descriptions[i]->attributes;
      const auto found = std::ranges::find(attributes, request.unique_id, &StreamAttribute::unique_id);
      if (found == attributes.end() || found->bits == 0) continue;
      DeclaredGrid grid = grid_of(*found);
      const auto [first, is_new] = grids.emplace(request.semantic, grid);
      if (is_new) continue;
      first->second.within = std::max(first->second.within, grid.within);
      first->second.coding.octahedral |= grid.coding.octahedral;
      if (first->second.identity != grid.identity) first->second.identity.clear();
    }
  }
  return grids;
}

}  // namespace psplit
