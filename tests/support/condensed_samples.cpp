#include "tests/support/condensed_samples.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "encoder/condensing/condense.h"
#include "src/container/patch_container.h"

namespace psplit {

std::vector<uint8_t> as_version_3(const PatchContainer& container, bool smallest, const ThreadPool& pool) {
  std::vector<std::vector<uint8_t>> streams, stitch;
  std::vector<DecodedCounts> counts;
  std::vector<StreamEntry> entries = container.entries;
  for (size_t i = 0; i < entries.size(); ++i) {
    streams.emplace_back(container.streams[i].begin(), container.streams[i].end());
    stitch.emplace_back(container.stitch[i].begin(), container.stitch[i].end());
    counts.push_back(
        {entries[i].face_count, entries[i].point_count, entries[i].reference_count, container.stitch[i]});
  }
  const CondensedStreams condensed = condense(streams, counts, smallest, pool);
  if (std::ranges::count(condensed.is_condensed, 1) == 0) return {};
  for (size_t i = 0; i < entries.size(); ++i) {
    entries[i].stream_bytes = static_cast<uint32_t>(condensed.bytes[i].size());
    entries[i].is_condensed = condensed.is_condensed[i] != 0;
    entries[i].skeleton = condensed.skeleton[i];
  }
  auto written =
      write_condensed_container(entries, container.has_residue, condensed.head, stitch, condensed.bytes);
  if (!written) {
    std::fprintf(stderr, "a small container does not fit into version 3\n");
    std::abort();
  }
  return std::move(*written);
}

std::vector<CondensedSample> condensed_samples(const ThreadPool& pool) {
  std::vector<CondensedSample> samples;
  bool smallest = false;
  for (PatchedSample& original : patched_samples(pool)) {
    // Version 1 has other stitch maps.
    if (original.encoded.container[4] != kContainerVersion) continue;
    std::vector<uint8_t> container = as_version_3(*original.encoded.opened, smallest, pool);
    if (container.empty()) continue;
    samples.push_back({std::move(original), std::move(container)});
    smallest = !smallest;
  }
  return samples;
}

}  // namespace psplit
