// How far the values of two groups of primitives may differ.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/gltf_psplit/diff/compare_assets.h"
#include "tools/gltf_psplit/diff/elements.h"
#include "tools/gltf_psplit/diff/read_asset_meshes.h"

namespace psplit {

using AssetPrimitives = std::span<const AssetPrimitive* const>;

// The semantic without its morph target: POSITION for "targets/0/POSITION".
std::string kind_of(const std::string& attribute);

// How one attribute is compared: a limit for each primitive of either side.
struct ColumnLimits {
  bool direction = false;
  bool stated = false;  // the user states the limit, so it is unknown which side was quantized
  std::vector<ColumnLimit> limits[2];
};

// The limits of all attributes of two sides. All primitives must have each attribute.
class ColumnLimiter {
 public:
  ColumnLimiter(AssetPrimitives a, AssetPrimitives b, const CompareRules& rules)
      : sides_{a, b}, rules_(rules) {}

  ColumnLimits limits_of(const std::string& attribute);

 private:
  std::optional<double> stated_share(const std::string& attribute, const std::string& kind) const;
  ColumnLimit limit_of_grid(const DeclaredGrid& grid, const std::string& kind);
  ColumnLimit limit_of_type(const ValuesView& values, const std::string& kind);
  int32_t number(const std::string& identity);

  AssetPrimitives sides_[2];
  const CompareRules& rules_;
  std::map<std::string, int32_t> numbers_;  // of grids, by their identity
};

}  // namespace psplit
