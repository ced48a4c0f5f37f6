#include "tools/gltf_psplit/diff/column_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace psplit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool starts_with_any(const std::string& text, std::initializer_list<const char*> prefixes) {
  return std::ranges::any_of(prefixes, [&](const char* prefix) { return text.starts_with(prefix); });
}

// The extent of an attribute; 1 for attributes with a fixed range.
double extent(AssetPrimitives primitives, const std::string& attribute) {
  if (starts_with_any(kind_of(attribute), {"NORMAL", "TANGENT", "COLOR_", "WEIGHTS_"})) return 1;
  std::array<double, 16> low, high;
  low.fill(kInfinity);
  high.fill(-kInfinity);
  for (const AssetPrimitive* primitive : primitives) {
    const ValuesView& values = *primitive->view.find(attribute);
    for_each_step(values, [&](size_t first, size_t end) {
      for (size_t point = first; point < end; ++point)
        for (size_t c = 0; c < values.component_count; ++c) {
          double value = number_at(values, point, c);
          if (attribute == "POSITION" && c < primitive->origin.size()) value += primitive->origin[c];
          if (!std::isfinite(value)) continue;
          low[c] = std::min(low[c], value);
          high[c] = std::max(high[c], value);
        }
      return true;
    });
  }
  double most = 0;
  for (size_t c = 0; c < low.size(); ++c) most = std::max(most, high[c] - low[c]);
  return std::isfinite(most) ? most : 0;
}

}  // namespace

std::string kind_of(const std::string& attribute) {
  const std::optional<MorphTarget> target = target_of(attribute);
  return target ? target->semantic : attribute;
}

ColumnLimits ColumnLimiter::limits_of(const std::string& attribute) {
  ColumnLimits limits;
  for (const size_t side : {0u, 1u}) limits.limits[side].resize(sides_[side].size());
  const std::string kind = kind_of(attribute);
  if (const std::optional<double> share = stated_share(attribute, kind)) {
    limits.stated = true;
    for (ColumnLimit& limit : limits.limits[0]) limit.within = *share * extent(sides_[0], attribute);
    return limits;
  }
  for (const size_t side : {0u, 1u})
    for (size_t i = 0; i < sides_[side].size(); ++i) {
      const auto grid = sides_[side][i]->grids.find(attribute), base = sides_[side][i]->grids.find(kind);
      const ValuesView& values = *sides_[side][i]->view.find(attribute);
      if (grid == sides_[side][i]->grids.end()) {
        limits.limits[side][i] = limit_of_type(values, kind);
        // Deltas outside streams may be as exact as the values that they change.
        if (base != sides_[side][i]->grids.end() && values.component_type == ComponentType::kFloat32)
          limits.limits[side][i].within = base->second.within;
      } else
        limits.limits[side][i] = limit_of_grid(grid->second, kind);
      limits.direction |= grid != sides_[side][i]->grids.end() && grid->second.coding.octahedral;
    }
  // One side stores directions, the other side numbers: the corners of a cell of numbers are further away.
  if (limits.direction)
    for (const size_t side : {0u, 1u})
      for (size_t i = 0; i < sides_[side].size(); ++i)
        if (!sides_[side][i]->grids.contains(attribute)) limits.limits[side][i].within *= std::sqrt(3.0);
  return limits;
}

// The share of the extent that the user states. Nothing if the grids of the files decide, as they always do for
// integers that name things.
std::optional<double> ColumnLimiter::stated_share(const std::string& attribute, const std::string& kind) const {
  auto found = rules_.tolerances.find(attribute);
  if (found == rules_.tolerances.end()) found = rules_.tolerances.find(kind);
  if (found == rules_.tolerances.end()) found = rules_.tolerances.find("");
  if (found == rules_.tolerances.end() || kind.starts_with("JOINTS_")) return std::nullopt;
  if (!starts_with_any(kind, {"POSITION", "NORMAL", "TANGENT", "TEXCOORD_", "COLOR_", "WEIGHTS_"}))
    for (const AssetPrimitives& side : sides_)
      for (const AssetPrimitive* primitive : side) {
        const ValuesView& values = *primitive->view.find(attribute);
        if (values.component_type != ComponentType::kFloat32 && !values.normalized) return std::nullopt;
      }
  return found->second;
}

ColumnLimit ColumnLimiter::limit_of_grid(const DeclaredGrid& grid, const std::string& kind) {
  constexpr double kNoise = 1e-5;  // encoders cut off values that exceed glTF's limits by less
  ColumnLimit limit{grid.within, grid.identity.empty() ? -1 : number("grid " + grid.identity)};
  if (kind.starts_with("WEIGHTS_")) limit.within *= 3;  // weights are rounded together, so that their sum is 1
  if (starts_with_any(kind, {"COLOR_", "WEIGHTS_", "TANGENT"})) limit.within += kNoise;
  return limit;
}

// Integers of the same type must be equal. Compared with another type, they may differ by their rounding.
ColumnLimit ColumnLimiter::limit_of_type(const ValuesView& values, const std::string& kind) {
  if (values.component_type == ComponentType::kFloat32) return {};
  ColumnLimit limit;
  limit.grid = number("type " + std::to_string(static_cast<int>(values.component_type)) +
                      (values.normalized ? " normalized" : ""));
  const size_t bits = 8 * component_bytes(values.component_type);
  const bool is_signed =
      values.component_type == ComponentType::kInt8 || values.component_type == ComponentType::kInt16;
  if (values.normalized)
    limit.within = 0.5 / (std::ldexp(1.0, static_cast<int>(bits) - (is_signed ? 1 : 0)) - 1) + 1e-7;
  else if (starts_with_any(kind, {"POSITION", "TEXCOORD_"}))
    limit.within = 0.5;
  return limit;
}

int32_t ColumnLimiter::number(const std::string& identity) {
  return numbers_.emplace(identity, static_cast<int32_t>(numbers_.size())).first->second;
}

}  // namespace psplit
