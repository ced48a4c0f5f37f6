#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "encoder/partition/partition.h"
#include "psplit/encode.h"

namespace psplit {

uint64_t default_patch_count(uint64_t faces, uint64_t min_faces) {
  constexpr double kPatchFaces = 30000;
  if (faces < min_faces) return 1;
  const double patches = static_cast<double>(faces) / kPatchFaces;
  if (patches < 24)
    return std::clamp<uint64_t>(std::bit_ceil(static_cast<uint64_t>(patches / std::sqrt(2.0)) + 1), 2, 16);
  return 16 * static_cast<uint64_t>(std::llround(patches / 16));
}

std::vector<uint32_t> patch_counts(Span<const uint64_t> faces, const PatchTarget& target) {
  std::vector<uint32_t> distributed;
  if (target.count > 0) {
    const uint64_t total = std::accumulate(faces.begin(), faces.end(), uint64_t{0});
    const uint64_t most = std::max<uint64_t>(1, total / std::max<uint64_t>(1, target.least_faces));
    distributed = distribute_patches(faces, std::min(target.count, most));
  }
  const auto count_of = [&](size_t i) -> uint64_t {
    if (faces[i] < target.min_faces) return 1;
    if (target.count > 0) return distributed[i];
    if (target.faces > 0) return std::max<uint64_t>(1, (faces[i] + target.faces / 2) / target.faces);
    return std::min(target.most > 0 ? target.most : UINT64_MAX,
                    default_patch_count(faces[i], target.min_faces > 0 ? target.min_faces : kMinFaces));
  };
  std::vector<uint32_t> counts;
  for (size_t i = 0; i < faces.size(); ++i) counts.push_back(static_cast<uint32_t>(count_of(i)));
  return counts;
}

}  // namespace psplit
