#include "src/condensed/expand_container.h"

#include "src/condensed/expand.h"

namespace psplit {

Expected<std::vector<uint8_t>> expand_patch(const PatchContainer& container, uint32_t patch) {
  const StreamEntry& entry = container.entries[patch];
  const std::span<const uint8_t> stream = container.streams[patch];
  if (!entry.is_condensed) return std::vector<uint8_t>(stream.begin(), stream.end());
  Expected<std::vector<uint8_t>> expanded =
      expand_stream(*container.head, {stream, entry.skeleton, entry.face_count, entry.point_count});
  if (!expanded) return expanded.status().at({.patch = patch});
  if (expanded->size() > 0xffffffffu) return unsupported("a stream of more than 4 GiB", {.patch = patch});
  return expanded;
}

Expected<std::vector<uint8_t>> expand_container(const PatchContainer& container, const ThreadPool& pool) {
  const size_t count = container.entries.size();
  std::vector<StreamEntry> entries = container.entries;
  std::vector<std::vector<uint8_t>> stitch, streams(count);
  std::vector<Status> statuses(count);
  pool.for_each(count, [&](size_t i) {
    Expected<std::vector<uint8_t>> stream = expand_patch(container, static_cast<uint32_t>(i));
    statuses[i] = stream.status();
    if (stream) streams[i] = std::move(*stream);
  });
  for (size_t i = 0; i < count; ++i) {
    if (!statuses[i].ok()) return statuses[i];
    entries[i].stream_bytes = static_cast<uint32_t>(streams[i].size());
    stitch.emplace_back(container.stitch[i].begin(), container.stitch[i].end());
  }
  return write_container(entries, container.has_residue, stitch, streams);
}

}  // namespace psplit
