// Points that primitives share.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "gltf_ext/convert/encode_job.h"

namespace psplit {

// Exporters write a surface of several materials as primitives with common attributes, each with indices of its
// own. Each primitive is stored with the points that its faces use. The first of them also gets the points that
// no face uses. Quantization grids are fitted after that, so that no primitive's grid holds points of another
// mesh.
class SharedPoints {
 public:
  // Call once for each job, when it has become the last of `jobs`: drops its points that others have.
  void divide(const Document& document, std::vector<EncodeJob>& jobs);
  // Call when all jobs are read: drops the first primitives' points that only others use.
  void finish(std::vector<EncodeJob>& jobs) const;

 private:
  struct Set {
    size_t first = 0;  // index into the jobs
    std::vector<uint8_t> used_by_others;
  };
  std::map<std::pair<AttributeRecords, std::vector<AttributeRecords>>, Set> sets_;  // with morph targets
};

}  // namespace psplit
