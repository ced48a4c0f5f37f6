// The values of one accessor as rows for meshoptimizer.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gltf_ext/convert/rest_uses.h"
#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/document.h"
#include "gltf_ext/primitive/elements_place.h"
#include "psplit/gltf.h"
#include "psplit/parallel.h"

namespace psplit {

// The rows of a filter, and what they become when it is undone.
struct FilteredRows {
  std::string filter;
  std::vector<uint8_t> rows, values;
  std::vector<uint8_t> lifted{};  // other rows of the same values; empty if there are none
  bool are_shorts =
      false;  // the values are normalized 16-bit integers; otherwise they have the accessor's type
};

struct RestColumn {
  ElementsPlace place;
  int64_t view = -1;  // in which the values are
  RestView needs = RestView::kPacked;
  bool is_of_vertices = false;  // also of sparse values
  size_t width = 0;             // the bytes of an element, with the padding of a view of vertices
  size_t row = 0;               // the bytes of a row
  RestPrecision precision{};
  std::vector<uint8_t> values{};  // whole elements, without gaps
  // Empty if the values must stay exact, or if the filter's error exceeds the allowed one: half a step for
  // multiples, and 3 half steps for each component of a rotation.
  std::optional<FilteredRows> filtered{};
  int64_t indices_view = -1;  // of elements that are sparse in the document
  Json extras{};              // of the view, which then has no other values
};

// The values of all accessors that have a use, from views that nothing else needs.
std::vector<RestColumn> rest_columns(const Document& document, const EncodeDocumentOptions& options,
                                     const ThreadPool& pool);

// All elements of an accessor of vertices, from its sparse indices and values. The others are zero.
RestColumn dense_column(const AccessorRecord& accessor, const RestColumn& indices, const RestColumn& values);

}  // namespace psplit
