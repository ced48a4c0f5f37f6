// Views that meshoptimizer compressed, after edits: values that got another order, and what is left of views
// that lost some of theirs, are compressed again as they were.
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

  // Compresses again what lose() named, and what accessors of `freed` that nothing refers to had. Call when the
  // new values are stored, and before what is unused is dropped: that includes the views they were stored in.
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
