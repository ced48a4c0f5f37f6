// Counts and sizes of a patch container: the rows of `inspect`, `encode --report` and `compare`.
#pragma once

#include "gltf_ext/primitive/read_primitives.h"
#include "psplit/decode.h"
#include "src/container/patch_container.h"

namespace psplit {

struct PatchSummary {
  uint64_t patches = 0;  // without the residue
  uint64_t faces = 0, points = 0, references = 0;
  uint64_t largest_patch_faces = 0, patch_faces = 0;  // the residue's faces are in no patch
  uint64_t condensed_patches = 0;                     // patches whose streams are condensed
  uint64_t payload_bytes = 0, directory_bytes = 0, head_bytes = 0, stitch_bytes = 0, total_bytes = 0;

  // (sum over patches of their points) / points - 1
  double replication() const {
    return points == 0 ? 0 : static_cast<double>(references) / static_cast<double>(points);
  }
  // faces of the largest patch / mean faces
  double balance() const {
    return patch_faces == 0 ? 1
                            : static_cast<double>(largest_patch_faces) * static_cast<double>(patches) /
                                  static_cast<double>(patch_faces);
  }
  double bits_per_point() const {
    return points == 0 ? 0 : 8 * static_cast<double>(total_bytes) / static_cast<double>(points);
  }
  // The summary of several primitives together.
  PatchSummary& operator+=(const PatchSummary& other);
};

// Summarizes the rows of a directory. Of `total_bytes`, all bytes outside the head, the streams and the stitch
// maps are the directory's.
PatchSummary summarize_streams(std::span<const StreamEntry> streams, bool has_residue, uint64_t head_bytes,
                               uint64_t total_bytes);
// Summarizes a stock Draco stream of `stream_bytes` bytes as one patch.
PatchSummary summarize_stream(const StreamDescription& description, size_t stream_bytes);

// A number of a PatchSummary: in JSON it is the member `name` of the object `group`, or of the row itself if
// `group` is null.
struct SummaryNumber {
  const char *group, *name;
  uint64_t PatchSummary::*number;
};
inline constexpr SummaryNumber kSummaryNumbers[] = {
    {nullptr, "patches", &PatchSummary::patches},
    {nullptr, "condensed_patches", &PatchSummary::condensed_patches},
    {nullptr, "faces", &PatchSummary::faces},
    {nullptr, "points", &PatchSummary::points},
    {nullptr, "references", &PatchSummary::references},
    {nullptr, "largest_patch_faces", &PatchSummary::largest_patch_faces},
    {nullptr, "patch_faces", &PatchSummary::patch_faces},
    {"bytes", "payload", &PatchSummary::payload_bytes},
    {"bytes", "directory", &PatchSummary::directory_bytes},
    {"bytes", "head", &PatchSummary::head_bytes},
    {"bytes", "stitch", &PatchSummary::stitch_bytes},
    {"bytes", "total", &PatchSummary::total_bytes}};

// Appends these numbers, "replication", "balance" and "bits_per_point" to an object.
void append_summary(Json& object, const PatchSummary& summary);

}  // namespace psplit
