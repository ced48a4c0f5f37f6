// Views that meshoptimizer compressed, after edits: values in another order, and the remainder of views that
// lost values, are compressed again as they were.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "gltf_ext/document/document.h"
#include "gltf_ext/primitive/elements_place.h"

namespace psplit {

class MeshoptViews {
 public:
  // Call before an accessor loses its views.
  void lose(const Document& document, int64_t accessor);

  // Compresses again the views that lose() named, and the views of accessors of `freed` that nothing refers to.
  // Call when the new values are stored, and before unused data is dropped, which includes the old views.
  void compress_again(Document& document, const std::vector<int64_t>& freed);

 private:
  struct Origin {
    int64_t view;
    uint64_t offset;
  };
  struct Slot;
  class Rebuilt;

  std::map<int64_t, std::vector<Slot>> slots(const Document& document, const std::set<int64_t>& gone) const;

  std::map<ElementsPlace, Origin> origins_;  // where values were that are stored elsewhere now
  std::set<int64_t> touched_;                // views that lost values
};

}  // namespace psplit
