#include "gltf_ext/convert/memory_model.h"

#include <algorithm>

namespace psplit {
namespace {

// Bytes for each byte of the file, each face, each byte of attributes.
struct Factors {
  uint64_t byte, face, value;
};

Factors factors_of(MemoryUse use) {
  // Includes 40 bytes for meshes that are encoded both as patches and as one stream.
  constexpr uint64_t kEncodedFace = 140;
  constexpr uint64_t kCoarseFace = 50;  // of the simplifier, beyond the memory that is free again by then
  switch (use) {
    case MemoryUse::kEncode: return {2, kEncodedFace, 5};
    case MemoryUse::kEncodeWithCoarse: return {2, kEncodedFace + kCoarseFace, 5};
    case MemoryUse::kDecode: return {2, 45, 7};
    case MemoryUse::kValidate: return {2, 20, 6};
    case MemoryUse::kDiff: break;
  }
  return {2, 65, 7};
}

}  // namespace

uint64_t bytes_in_memory(MemoryUse use, const AssetCounts& counts) {
  constexpr uint64_t kLeast = uint64_t{1} << 20;
  const auto [byte, face, value] = factors_of(use);
  return kLeast + (byte * counts.bytes + face * counts.faces + value * counts.values) / 5 * 6;
}

MemoryPlan::MemoryPlan(const OutOfCoreOptions& limits, size_t record_bytes, int most_threads,
                       uint64_t patch_faces) {
  constexpr uint64_t kFace = 100, kPoint = 40, kValueByte = 5, kPatchFace = 680;  // of a part
  constexpr uint64_t kLeftPoint = 64, kLeftValueByte = 4;                         // of the residue
  constexpr uint64_t kCondensedPoint = 160, kCondensedValueByte = 8;
  constexpr uint64_t kMostBuffers = uint64_t{64} << 20, kZeroNormal = 64;
  all = std::max(limits.memory, kLeastMemory) - kProcessOfParts;
  buffer_bytes = std::min(all / 8, kMostBuffers);
  most_zero_normals = all / 8 / kZeroNormal;
  const uint64_t thread_bytes = std::max<uint64_t>(1, patch_faces * kPatchFace);
  thread_count = static_cast<int>(
      std::clamp<uint64_t>(all / 2 / thread_bytes, 1, static_cast<uint64_t>(std::max(1, most_threads))));
  most_patch_faces = all / 2 / kPatchFace;
  most_residue_points = all / 4 / (kLeftPoint + kLeftValueByte * record_bytes);
  condensed_points = all / 3 / (kCondensedPoint + kCondensedValueByte * record_bytes);
  // The other half is for the part. It must not depend on the threads, because parts change the output.
  cost = {kFace, kPoint + kValueByte * record_bytes, all - all / 2};
  if (limits.most_part_faces > 0) cost = {1, 0, limits.most_part_faces};
}

}  // namespace psplit
