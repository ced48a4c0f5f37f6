// Into how many patches meshes are cut.
#pragma once

#include <cstdint>
#include <vector>

#include "src/export.h"
#include "src/span.h"

namespace psplit {

// Primitives of at least this many faces are split if the caller states no limit. Two patches then cost about
// 2 % of the primitive's bytes (docs/benchmarks.md).
inline constexpr uint64_t kMinFaces = 20000;
// Faces of a patch if decoding is to take the least time. On one thread and on several, patches of this size
// decode fastest (docs/benchmarks.md).
inline constexpr uint64_t kSpeedPatchFaces = 4800;
// The most patches if bytes count more. Four patches keep four threads busy, at less than a third of the cost
// of 16 patches.
inline constexpr uint64_t kMostPatchesForSize = 4;

// Into how many patches primitives are cut: by `count`, otherwise by `faces`. If both are 0, a primitive of
// kMinFaces or more is cut into 2, 4, 8, 16 or a multiple of 16 patches of about 30,000 faces.
struct PatchTarget {
  uint64_t count = 0;        // of all primitives together
  uint64_t least_faces = 0;  // `count` is reduced until each patch has at least this many faces
  uint64_t faces = 0;        // of a patch: a primitive of F faces gets round(F / faces) patches, at least 1
  uint64_t most = 0;         // of a primitive, if count and faces are 0; 0 means no bound
  // Smaller primitives stay whole. 0 means kMinFaces if count and faces are 0, and no bound otherwise.
  uint64_t min_faces = 0;
  bool always = false;  // store meshes that stay whole as one patch, too, and patches whatever they cost

  // Whether the caller asks for patches, and does not leave it to the size of each primitive.
  bool is_given() const { return count > 0 || faces > 0 || always; }
};

// 2, 4, 8, 16 or a multiple of 16 patches of about 30,000 faces, and one patch below `min_faces`. Threads then
// get equal work, and the bytes beyond those of a single stream are about 2 % (docs/benchmarks.md).
PSPLIT_EXPORT uint64_t default_patch_count(uint64_t faces, uint64_t min_faces = kMinFaces);

// The number of patches of each primitive, given its number of faces.
PSPLIT_EXPORT std::vector<uint32_t> patch_counts(Span<const uint64_t> faces, const PatchTarget& target);

}  // namespace psplit
