#include "encoder/condensing/condense_container.h"

#include "encoder/condensing/condense.h"

namespace psplit {

std::vector<uint8_t> condense_container(std::vector<StreamEntry> entries, bool has_residue,
                                        std::span<const std::vector<uint8_t>> stitch,
                                        std::span<const std::vector<uint8_t>> streams, bool smallest,
                                        const ThreadPool& pool) {
  std::vector<DecodedCounts> counts;
  for (size_t i = 0; i < entries.size(); ++i)
    counts.push_back({entries[i].face_count, entries[i].point_count, entries[i].reference_count, stitch[i]});
  const CondensedStreams condensed = condense(streams, counts, smallest, pool);
  for (size_t i = 0; i < entries.size(); ++i) {
    entries[i].stream_bytes = static_cast<uint32_t>(condensed.bytes[i].size());
    entries[i].is_condensed = condensed.is_condensed[i] != 0;
    entries[i].skeleton = condensed.skeleton[i];
  }
  return write_container(entries, has_residue, stitch, condensed.bytes, condensed.head);
}

std::vector<uint8_t> condense_container(const PatchContainer& container, bool smallest,
                                        const ThreadPool& pool) {
  std::vector<std::vector<uint8_t>> stitch, streams;
  for (size_t i = 0; i < container.entries.size(); ++i) {
    stitch.emplace_back(container.stitch[i].begin(), container.stitch[i].end());
    streams.emplace_back(container.streams[i].begin(), container.streams[i].end());
  }
  return condense_container(container.entries, container.has_residue, stitch, streams, smallest, pool);
}

}  // namespace psplit
