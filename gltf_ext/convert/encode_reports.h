// The reports of all primitives of a document while it is encoded.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "gltf_ext/convert/read_jobs.h"

namespace psplit {

class EncodeReports {
 public:
  // `input` is the document before it is encoded, and `read` what read_jobs returned for it.
  EncodeReports(const Document& input, const EncodeJobs& read);

  PrimitiveReport& operator[](PrimitiveId id) { return reports_.at({id.mesh, id.primitive}); }

  // The reports in the order of the primitives.
  std::vector<PrimitiveReport> list() &&;

 private:
  std::map<std::pair<size_t, size_t>, PrimitiveReport> reports_;
};

}  // namespace psplit
