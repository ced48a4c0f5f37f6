// The reports of all primitives of a document while it is encoded.
#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "gltf_ext/convert/read_jobs.h"

namespace psplit {

class EncodeReports {
 public:
  // `input` is the document before it is encoded; `jobs` and `large` are those in memory and in parts.
  EncodeReports(const Document& input, const SkippedPrimitives& skipped, std::span<const EncodeJob> jobs,
                std::span<const EncodeJob> large);

  PrimitiveReport& operator[](PrimitiveId id) { return reports_.at({id.mesh, id.primitive}); }

  // The reports in the order of the primitives.
  std::vector<PrimitiveReport> list() &&;

 private:
  std::map<std::pair<size_t, size_t>, PrimitiveReport> reports_;
};

}  // namespace psplit
