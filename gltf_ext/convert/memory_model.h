// How much memory work on meshes takes: from these numbers --memory is divided, and batch estimates assets.
//
// They were fitted to peaks of processes:
//
//   - A mesh in memory: 100,000 to 2 million faces with 12 to 48 bytes of attributes, on two threads; then a
//     fifth was added. With its default options, encode takes 0.5 to 0.7 of this: others take more. A test of
//     the batch (memory_estimate_test) holds the estimates against measured peaks.
//   - A part (encoder/encode_parts.h): 110 bytes for each face of parts of 0.3 to 5 million faces with
//     positions, 130 with normals, and 540 bytes for each face of the patch of a thread; then a quarter was
//     added.
//
// What encoding in parts takes besides a part is small. It was counted, not measured:
//
//   16 bytes for each point that parts share,
//   the points and faces of a container's residue, and 30 bytes for each of these points,
//   40 bytes for each patch of the container, twice while its arrays grow,
//   584 more for each patch while a part is verified,
//   48 for each patch with boxes, and 12 for each point of a part that earlier parts own.
#pragma once

#include <cstdint>

#include "gltf_ext/out_of_core/cell_assignment.h"
#include "psplit/gltf.h"

namespace psplit {

// The memory of a process before it reads an asset.
inline constexpr uint64_t kProcessMemory = uint64_t{24} << 20;
// Its memory beside the part that it encodes: libraries, threads, windows on files.
inline constexpr uint64_t kProcessOfParts = uint64_t{48} << 20;

// How an asset in memory is used.
enum class MemoryUse { kEncode, kEncodeWithCoarse, kDecode, kValidate, kDiff };
struct AssetCounts {
  uint64_t faces = 0;
  uint64_t values = 0;  // bytes of all attributes of all points, with 4 bytes for a number
  uint64_t bytes = 0;   // of the file that memory holds unchanged
};
// An upper bound of the bytes that the asset takes, without the memory of the process.
uint64_t bytes_in_memory(MemoryUse use, const AssetCounts& counts);

// How encoding in parts uses the memory of the process.
struct MemoryPlan {
  uint64_t buffer_bytes = 0, most_zero_normals = 0;
  int thread_count = 1;  // fewer than wanted if their patches would take more than half of the memory
  uint64_t all = 0;      // for everything except the process itself
  PartCost cost;         // of a part
  uint64_t most_patch_faces = 0;
  uint64_t most_residue_points = 0, condensed_points = 0;  // see PartsOptions

  // `record_bytes`: of a point, or 0 if that is not known yet. Each thread encodes patches of `patch_faces`.
  MemoryPlan(const OutOfCoreOptions& limits, size_t record_bytes, int most_threads = 1,
             uint64_t patch_faces = 0);
};

// The bytes of a face in a window, if a file is decoded window by window: its results, stream and references.
inline constexpr uint64_t kWindowFace = 128;

// Of a face of two assets that are compared in memory: the mesh, and the tables of the matching.
inline constexpr uint64_t kComparedFace = 96;
// Of a triangle, line or point of a window of elements that are matched.
inline constexpr uint64_t kMatchedElement = 128;

}  // namespace psplit
