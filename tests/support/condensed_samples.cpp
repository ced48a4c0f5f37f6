#include "tests/support/condensed_samples.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "encoder/condensing/condense_container.h"
#include "src/container/patch_container.h"

namespace psplit {

std::vector<uint8_t> as_version_3(const PatchContainer& container, bool smallest, const ThreadPool& pool) {
  auto written = condense_container(container, smallest, pool);
  if (!written) {
    std::fprintf(stderr, "a small container does not fit into version 3\n");
    std::abort();
  }
  constexpr size_t kHeadBytesAt = 16;
  const bool is_condensed = std::any_of(written->begin() + kHeadBytesAt, written->begin() + kHeadBytesAt + 4,
                                        [](uint8_t byte) { return byte != 0; });
  return is_condensed ? std::move(*written) : std::vector<uint8_t>();
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

std::vector<PatchedSample> samples_of_all_versions(const ThreadPool& pool) {
  std::vector<PatchedSample> samples = patched_samples(pool);
  for (CondensedSample& sample : condensed_samples(pool)) {
    sample.original.name += ", condensed";
    sample.original.encoded.container = std::move(sample.container);
    samples.push_back(std::move(sample.original));
  }
  for (PatchedSample& sample : samples) sample.encoded.opened = nullptr;
  return samples;
}

}  // namespace psplit
