#include "tools/gltf_psplit/report/patch_summary.h"

#include <algorithm>

#include "gltf_ext/json/json.h"

namespace psplit {

PatchSummary& PatchSummary::operator+=(const PatchSummary& other) {
  const uint64_t largest = std::max(largest_patch_faces, other.largest_patch_faces);
  for (const auto& [group, name, number] : kSummaryNumbers) this->*number += other.*number;
  largest_patch_faces = largest;
  return *this;
}

PatchSummary summarize_streams(std::span<const StreamEntry> streams, bool has_residue, uint64_t head_bytes,
                               uint64_t total_bytes) {
  PatchSummary summary;
  summary.patches = streams.size() - (has_residue ? 1 : 0);
  for (size_t i = 0; i < streams.size(); ++i) {
    const StreamEntry& stream = streams[i];
    summary.faces += stream.face_count;
    summary.points += stream.point_count - stream.reference_count;
    summary.references += stream.reference_count;
    summary.payload_bytes += stream.stream_bytes;
    summary.stitch_bytes += stream.stitch_bytes;
    summary.condensed_patches += stream.is_condensed ? 1 : 0;
    if (i >= summary.patches) continue;
    summary.largest_patch_faces = std::max<uint64_t>(summary.largest_patch_faces, stream.face_count);
    summary.patch_faces += stream.face_count;
  }
  summary.head_bytes = head_bytes;
  summary.directory_bytes = total_bytes - summary.payload_bytes - head_bytes - summary.stitch_bytes;
  summary.total_bytes = total_bytes;
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
  for (const auto& [group, name, number] : kSummaryNumbers)
    (group == nullptr ? object : object[group])[name] = summary.*number;
  object["replication"] = summary.replication();
  object["balance"] = summary.balance();
  object["bits_per_point"] = summary.bits_per_point();
}

}  // namespace psplit
