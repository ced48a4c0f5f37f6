#include "encoder/kept_grids.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "encoder/coding/grid_places.h"
#include "encoder/coding/quantization.h"

namespace psplit {
namespace {

// Whether the encoder can write the grid, whatever a stream states.
bool is_usable(const Attribute& attribute, const AttributeCoding& grid) {
  const bool is_direction = attribute.semantic == "NORMAL" && attribute.component_count == 3;
  if (grid.octahedral) return is_direction && grid.bits >= 2 && grid.bits <= kMostGridBits;
  if (is_direction || grid.bits < 1 || grid.bits > kMostGridBits ||
      grid.origin.size() != attribute.component_count)
    return false;
  const float step = grid.range / static_cast<float>((1u << grid.bits) - 1);
  return std::isnormal(step) && std::isnormal(1 / step) && grid_extremes(grid);
}

bool may_have_grid(const Attribute& attribute, const AttributeCoding& grid, const CodingOptions& options) {
  const int wanted = wanted_bits(attribute, options);
  return wanted > 0 && is_usable(attribute, grid) && (!are_given(attribute, options) || grid.bits == wanted);
}

// Whether the values do not widen the grid. The last place of a grid may be decoded as a value a little beyond
// the range; a stream with that value states a larger range.
bool holds(const AttributeCoding& grid, const CodingBounds& bounds) {
  if (!bounds.is_finite || grid.octahedral || grid.origin.size() != bounds.low.size()) return false;
  for (size_t c = 0; c < bounds.low.size(); ++c)
    if (bounds.low[c] < grid.origin[c] || double{bounds.high[c]} - double{grid.origin[c]} > double{grid.range})
      return false;
  return true;
}

// Weights of a point are rounded together, so they are kept together.
bool keeps_only_some_weights(const Mesh& mesh, const std::vector<bool>& is_final) {
  size_t sets = 0, kept = 0;
  for (size_t i = 0; i < mesh.attributes.size(); ++i) {
    if (!mesh.attributes[i].semantic.starts_with("WEIGHTS_")) continue;
    ++sets;
    kept += is_final[i];
  }
  return kept > 0 && kept < sets;
}

using GridOrder = std::tuple<int, std::vector<float>, float>;
GridOrder order_of(const AttributeCoding& grid) { return {grid.bits, grid.origin, grid.range}; }

// The positions of a group.
struct Group {
  std::map<GridOrder, AttributeCoding> grids;
  std::vector<std::pair<size_t, size_t>> kept, others;  // mesh and attribute
};

}  // namespace

std::vector<std::vector<bool>> keep_grids(std::span<MeshToEncode* const> meshes, std::span<const KeptMesh> kept,
                                          const EncodeOptions& options,
                                          std::span<const std::vector<CodingBounds>> bounds,
                                          std::span<const StoredFlags> stored,
                                          std::span<std::vector<AttributeCoding>> codings,
                                          const ThreadPool& pool) {
  std::vector<std::vector<bool>> is_final(meshes.size());
  const std::vector<std::vector<AttributeCoding>> chosen(codings.begin(), codings.end());
  pool.for_each(meshes.size(), [&](size_t k) {
    const Mesh& mesh = meshes[k]->mesh;
    is_final[k].resize(mesh.attributes.size(), false);
    for (size_t i = 0; i < meshes[k]->stated.size(); ++i) {
      const AttributeCoding& grid = meshes[k]->stated[i];
      if (codings[k][i].exact || !may_have_grid(mesh.attributes[i], grid, options)) continue;
      if (!grid.octahedral && !holds(grid, bounds[k][i])) continue;
      if (!is_on_grid(mesh.attributes[i], grid, stored[k])) continue;
      codings[k][i] = grid;
      codings[k][i].exact = true;
      is_final[k][i] = true;
    }
    if (!keeps_only_some_weights(mesh, is_final[k])) return;
    for (size_t i = 0; i < mesh.attributes.size(); ++i)
      if (is_final[k][i] && mesh.attributes[i].semantic.starts_with("WEIGHTS_")) {
        codings[k][i] = chosen[k][i];
        is_final[k][i] = false;
      }
  });
  std::map<size_t, Group> groups;
  for (size_t k = 0; k < meshes.size(); ++k)
    for (size_t i = 0; i < codings[k].size(); ++i) {
      const AttributeCoding& coding = codings[k][i];
      if (meshes[k]->mesh.attributes[i].semantic != "POSITION" || coding.bits == 0) continue;
      Group& group = groups[meshes[k]->group];
      (is_final[k][i] ? group.kept : group.others).emplace_back(k, i);
      if (is_final[k][i]) group.grids.emplace(order_of(coding), coding);
    }
  for (const KeptMesh& mesh : kept)
    if (const auto found = groups.find(mesh.group); found != groups.end())
      found->second.grids.emplace(order_of(mesh.positions), mesh.positions);
  for (auto& [number, group] : groups) {
    if (group.grids.empty() || group.others.empty()) continue;
    AttributeCoding grid = group.grids.begin()->second;
    grid.exact = false;
    const bool serves_all =
        group.grids.size() == 1 && std::ranges::all_of(group.others, [&](const auto& at) {
          const auto& [k, i] = at;
          return holds(grid, bounds[k][i]) && may_have_grid(meshes[k]->mesh.attributes[i], grid, options);
        });
    for (const auto& [k, i] : serves_all ? group.others : group.kept) {
      codings[k][i] = serves_all ? grid : chosen[k][i];
      is_final[k][i] = serves_all;
    }
  }
  return is_final;
}

}  // namespace psplit
