#include "gltf_ext/convert/patch_counts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace psplit {

uint64_t default_patch_count(uint64_t faces, uint64_t min_faces) {
  constexpr double kPatchFaces = 30000;
  if (faces < min_faces) return 1;
  const double patches = static_cast<double>(faces) / kPatchFaces;
  if (patches < 24)
    return std::clamp<uint64_t>(std::bit_ceil(static_cast<uint64_t>(patches / std::sqrt(2.0)) + 1), 2, 16);
  return 16 * static_cast<uint64_t>(std::lround(patches / 16));
}

std::vector<uint32_t> patch_counts(std::span<const uint64_t> faces, const EncodeDocumentOptions& options) {
  std::vector<uint32_t> distributed;
  if (options.patches > 0) {
    const uint64_t total = std::accumulate(faces.begin(), faces.end(), uint64_t{0});
    const uint64_t most = std::max<uint64_t>(1, total / std::max<uint64_t>(1, options.least_patch_faces));
    distributed = distribute_patches(faces, std::min(options.patches, most));
  }
  const uint64_t size = options.patch_faces;
  const uint64_t most = options.most_patches > 0         ? options.most_patches
                        : options.compat == Compat::kKhr ? kMostPatchPrimitives
                                                         : UINT64_MAX;
  const auto count_of = [&](size_t i) -> uint64_t {
    if (faces[i] < options.min_faces) return 1;
    if (options.patches > 0) return distributed[i];
    if (size > 0) return std::max<uint64_t>(1, (faces[i] + size / 2) / size);
    return std::min(most, default_patch_count(faces[i], options.min_faces > 0 ? options.min_faces : kMinFaces));
  };
  std::vector<uint32_t> counts;
  for (size_t i = 0; i < faces.size(); ++i) counts.push_back(static_cast<uint32_t>(count_of(i)));
  return counts;
}

std::vector<uint32_t> patch_counts(std::span<const EncodeJob> jobs, const EncodeDocumentOptions& options) {
  std::vector<uint64_t> faces;
  for (const EncodeJob& job : jobs) faces.push_back(job.mesh.faces.size());
  return patch_counts(faces, options);
}

}  // namespace psplit
