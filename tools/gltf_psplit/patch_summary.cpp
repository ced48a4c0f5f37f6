#include "tools/gltf_psplit/patch_summary.h"

#include <algorithm>

namespace psplit {

PatchSummary& PatchSummary::operator+=(const PatchSummary& other) {
  patches += other.patches;
  faces += other.faces;
  points += other.points;
  references += other.references;
  largest_patch_faces = std::max(largest_patch_faces, other.largest_patch_faces);
  patch_faces += other.patch_faces;
  payload_bytes += other.payload_bytes;
  directory_bytes += other.directory_bytes;
  stitch_bytes += other.stitch_bytes;
  total_bytes += other.total_bytes;
  return *this;
}

Expected<PatchSummary> summarize_container(std::span<const uint8_t> container) {
  const Expected<Container> parsed = parse_container(container);
  if (!parsed) return parsed.status();
  PatchSummary summary;
  summary.patches = parsed->patch_count();
  summary.faces = parsed->face_count();
  summary.points = parsed->point_count();
  summary.references = parsed->reference_count();
  for (uint32_t patch = 0; patch < parsed->patch_count(); ++patch) {
    const uint64_t faces = parsed->entries[patch].face_count;
    summary.largest_patch_faces = std::max(summary.largest_patch_faces, faces);
    summary.patch_faces += faces;
  }
  summary.payload_bytes = parsed->stream_bytes();
  summary.directory_bytes = parsed->header_bytes;
  summary.stitch_bytes = parsed->stitch_bytes();
  summary.total_bytes = container.size();
  return summary;
}

PatchSummary summarize_stream(const StreamDescription& description, size_t stream_bytes) {
  PatchSummary summary;
  summary.patches = 1;
  summary.faces = summary.largest_patch_faces = summary.patch_faces = description.face_count;
  summary.points = description.point_count;
  summary.payload_bytes = summary.total_bytes = stream_bytes;
  return summary;
}

void append_summary(Json& object, const PatchSummary& summary) {
  object["patches"] = summary.patches;
  object["faces"] = summary.faces;
  object["points"] = summary.points;
  object["references"] = summary.references;
  object["replication"] = summary.replication();
  object["balance"] = summary.balance();
  object["bytes"] = {{"payload", summary.payload_bytes},
                     {"directory", summary.directory_bytes},
                     {"stitch", summary.stitch_bytes},
                     {"total", summary.total_bytes}};
  object["bits_per_point"] = summary.bits_per_point();
}

}  // namespace psplit
