// Containers of version 3 for tests of decoders.
#pragma once

#include "tests/support/patched_samples.h"

namespace psplit {

// A container of version 2 as version 3, whether it gets smaller or not. `smallest` is that of condense. Empty
// if no stream can be condensed.
std::vector<uint8_t> as_version_3(const PatchContainer& container, bool smallest, const ThreadPool& pool);

// patched_samples as version 3, `smallest` in turn, except those without a stream that can be condensed.
// `encoded.opened` is the container of version 2 that each was made from.
struct CondensedSample {
  PatchedSample original;
  std::vector<uint8_t> container;
};
std::vector<CondensedSample> condensed_samples(const ThreadPool& pool);

// patched_samples, and then the containers of condensed_samples. `encoded.opened` is not set.
std::vector<PatchedSample> samples_of_all_versions(const ThreadPool& pool);

}  // namespace psplit
