#include "src/container/border_values.h"

#include <algorithm>
#include <numeric>

#include "src/container/claims.h"
#include "src/core/in_step.h"
#include "src/core/workspace.h"

namespace psplit {
namespace {

using core::Fault;

// Parts that one thread decodes in step: some hundred values each.
constexpr size_t kTogether = 16;

// A patch alone has its values already.
bool needs_values(const PatchContainer& container) {
  return core::kReadsCondensed && !container.is_stock && container.has_borders();
}

// Upper bounds of a patch's border walk: its places, and the numbers of their values.
struct WalkSize {
  uint64_t places = 0, numbers = 0;

  uint64_t bytes() const { return numbers * sizeof(int32_t) + places; }
};

WalkSize most_of(const PatchContainer& container, uint32_t patch) {
  const core::CondensedStream& stream = container.headers[patch].condensed;
  const uint64_t places = core::most_places(stream, container.entries[patch].reference_count);
  return {places, places * stream.border_components};
}

Status first_failure(std::vector<Status>& statuses) {
  for (Status& status : statuses)
    if (!status.ok()) return std::move(status);
  return {};
}

}  // namespace

Expected<BorderValues> BorderValues::decode(const PatchContainer& container, const ThreadPool& pool) {
  if (!needs_values(container)) return BorderValues();
  const size_t count = container.patch_count();
  std::vector<uint32_t> patches(count);
  std::iota(patches.begin(), patches.end(), 0u);
  BorderValues result(std::move(patches));
  if (Status status = result.allocate(container); !status.ok()) return status;
  std::vector<Status> statuses(count);
  const size_t ranges = 4 * static_cast<size_t>(pool.thread_count());
  const size_t grain = std::clamp<size_t>(count / ranges, 1, kTogether);
  pool.for_ranges(count, grain, [&](size_t begin, size_t end) {
    result.decode_parts(container, begin, end, std::span(statuses).subspan(begin, end - begin));
  });
  if (Status status = first_failure(statuses); !status.ok()) return status;
  pool.for_ranges(count, grain, [&](size_t begin, size_t end) {
    for (size_t slot = begin; slot < end; ++slot) {
      const Fault fault = result.share_values(container, slot);
      statuses[slot] = status_of(fault).at({.patch = static_cast<int64_t>(slot)});
    }
  });
  if (Status status = first_failure(statuses); !status.ok()) return status;
  return result;
}

Expected<BorderValues> BorderValues::decode(const PatchContainer& container, uint32_t patch) {
  if (patch >= container.patch_count()) return BorderValues();
  return decode(container, std::span(&patch, 1));
}

Expected<BorderValues> BorderValues::decode(const PatchContainer& container, uint32_t first, uint32_t end,
                                            const ThreadPool& pool) {
  const uint32_t count = container.patch_count();
  end = std::min(end, count);
  if (!needs_values(container) || (first == 0 && end == count)) return decode(container, pool);
  // Of a container that arrives, some patches have no header yet.
  const auto known = static_cast<uint32_t>(std::min<size_t>(count, container.headers.size()));
  uint64_t bytes = 0;
  for (uint32_t patch = 0; patch < known; ++patch) bytes += most_of(container, patch).bytes();
  if (bytes > core::justified_bytes(container.stream_bytes())) return status_of(Fault::kWorkspace);
  if (first >= end) return BorderValues();
  std::vector<uint32_t> patches(end - first);
  std::iota(patches.begin(), patches.end(), first);
  Expected<BorderValues> some = decode(container, patches);
  // If it failed, decode() of all patches names the first of all failures.
  return some || known < count ? std::move(some) : decode(container, pool);
}

Expected<BorderValues> BorderValues::decode(const PatchContainer& container, std::span<const uint32_t> some) {
  if (!needs_values(container)) return BorderValues();
  std::vector<uint32_t> patches(some.begin(), some.end());
  for (const uint32_t patch : some) append_owners(container, patch, patches);
  // As a heap: other sorts have much more code, which web pages load.
  std::make_heap(patches.begin(), patches.end());
  std::sort_heap(patches.begin(), patches.end());
  patches.erase(std::unique(patches.begin(), patches.end()), patches.end());
  BorderValues result(std::move(patches));
  if (Status status = result.allocate(container); !status.ok()) return status;
  const size_t count = result.patches_.size();
  std::vector<Status> statuses(count);
  for (size_t slot = 0; slot < count; slot += kTogether) {
    const size_t together = std::min(kTogether, count - slot);
    result.decode_parts(container, slot, slot + together, std::span(statuses).subspan(slot, together));
  }
  if (Status status = first_failure(statuses); !status.ok()) return status;
  for (const uint32_t patch : some) {
    const Fault fault = result.share_values(container, result.slot_of(patch));
    if (fault != Fault::kNone) return status_of(fault).at({.patch = patch});
  }
  return result;
}

void BorderValues::append_owners(const PatchContainer& container, uint32_t patch,
                                 std::vector<uint32_t>& owners) {
  core::StitchReader reader(container.stitch_row(patch));
  for (core::StitchReader::Run run; reader.next_run(run);)
    if (owners.empty() || owners.back() != run.owner) owners.push_back(run.owner);
}

void BorderValues::complete(uint32_t patch, core::StreamHeader& header) const {
  if (patches_.empty() || !header.is_condensed()) return;
  const core::WalkValues& walk = walks_[slot_of(patch)];
  header.condensed.known = walk.values.first(walk.length * size_t{header.condensed.border_components});
  header.condensed.behind_border = behind_parts_[slot_of(patch)];
}

// Takes memory for all walks.
Status BorderValues::allocate(const PatchContainer& container) {
  WalkSize all;
  for (const uint32_t patch : patches_) {
    const WalkSize most = most_of(container, patch);
    all = {all.places + most.places, all.numbers + most.numbers};
  }
  if (all.bytes() > core::justified_bytes(container.stream_bytes())) return status_of(Fault::kWorkspace);
  values_.reset(new int32_t[static_cast<size_t>(all.numbers)]);
  is_own_.reset(new uint8_t[static_cast<size_t>(all.places)]);
  walks_.resize(patches_.size());
  behind_parts_.resize(patches_.size());
  int32_t* values = values_.get();
  uint8_t* is_own = is_own_.get();
  for (size_t slot = 0; slot < patches_.size(); ++slot) {
    const WalkSize most = most_of(container, patches_[slot]);
    walks_[slot].values = {values, static_cast<size_t>(most.numbers)};
    walks_[slot].is_own = {is_own, static_cast<size_t>(most.places)};
    values += most.numbers;
    is_own += most.places;
  }
  return {};
}

// Decodes the parts of slots [begin, end), at most kTogether, and puts their values to their places.
void BorderValues::decode_parts(const PatchContainer& container, size_t begin, size_t end,
                                std::span<Status> statuses) {
  core::TokenSequence tokens[kTogether];
  core::TokenSequence* started[kTogether] = {};
  Fault faults[kTogether] = {};
  uint32_t count = 0;
  for (size_t slot = begin; slot < end; ++slot) {
    const core::StreamHeader& header = container.headers[patches_[slot]];
    const core::WalkValues& walk = walks_[slot];
    const size_t size = size_t{header.condensed.border_count} * header.condensed.border_components;
    // They take the place of the values.
    auto* const symbols = reinterpret_cast<uint32_t*>(walk.values.data() + walk.values.size() - size);
    core::TokenSequence& sequence = tokens[slot - begin];
    faults[slot - begin] = core::start_border_part(header.condensed, walk.is_own, {symbols, size}, sequence);
    if (faults[slot - begin] == Fault::kNone) started[count++] = &sequence;
  }
  core::step_tokens<core::kInStep>(started, count);
  for (size_t slot = begin; slot < end; ++slot) {
    const uint32_t patch = patches_[slot];
    Fault& fault = faults[slot - begin];
    if (fault == Fault::kNone)
      fault =
          core::place_own_values(container.stitch_row(patch), container.headers[patch].condensed, walks_[slot]);
    behind_parts_[slot] = tokens[slot - begin].section();
    statuses[slot - begin] = status_of(fault).at({.patch = patch});
  }
}

core::Fault BorderValues::share_values(const PatchContainer& container, size_t slot) const {
  const uint32_t patch = patches_[slot];
  return core::copy_shared_values(
      core::SerialLanes(), container.stitch_row(patch), container.headers[patch].condensed,
      [&](uint32_t owner) { return walks_[slot_of(owner)]; }, walks_[slot]);
}

size_t BorderValues::slot_of(uint32_t patch) const {
  // All patches have the slots of their numbers.
  if (patch < patches_.size() && patches_[patch] == patch) return patch;
  return static_cast<size_t>(std::lower_bound(patches_.begin(), patches_.end(), patch) - patches_.begin());
}

}  // namespace psplit
