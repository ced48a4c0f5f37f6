// The grids of attributes that meshoptimizer's exponential filter rounded, as `encode --meshopt` does with
// points and lines: multiples of powers of two, whose exponents the file states.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "gltf_ext/document/document.h"
#include "tools/gltf_psplit/diff/read_asset_meshes.h"

namespace psplit {

class FilteredGrids {
 public:
  // The document must outlive it.
  explicit FilteredGrids(const Document& document) : document_(document) {}

  // The largest error is half the largest power. Nothing if the accessor does not hold floats, or if none of
  // its views has the filter.
  std::optional<DeclaredGrid> of(int64_t accessor);

 private:
  // Of a view with the filter, before that is undone; empty for all other views.
  const std::vector<uint8_t>& rows_of(int64_t view);

  const Document& document_;
  std::map<int64_t, std::vector<uint8_t>> rows_;
};

}  // namespace psplit
