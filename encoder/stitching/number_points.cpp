#include <utility>

#include "encoder/stitching/stitch_map.h"

namespace psplit {
namespace {

constexpr uint32_t kReference = 0xffffffffu;

Status broken(size_t patch, const char* what) {
  return invalid_input(std::string("stitch map: ") + what, {.patch = static_cast<int64_t>(patch)});
}

struct Patches {
  std::vector<StitchMap> maps;
  std::vector<std::vector<uint32_t>> walks;    // of the patches that runs need
  std::vector<std::vector<uint32_t>> numbers;  // of the decoded points of each patch

  explicit Patches(size_t count) : maps(count), walks(count), numbers(count) {}
};

// Numbers the points that a patch owns; the others become kReference. Needs the patch's own map and walk only.
Status number_owned(const PatchContainer& container, size_t patch, Patches& patches) {
  const uint32_t point_count = container.entries[patch].point_count;
  const StitchMap& map = patches.maps[patch];
  const std::vector<uint32_t>& walk = patches.walks[patch];
  std::vector<uint8_t> is_reference(point_count, 0);
  const auto mark = [&](uint32_t point) { return std::exchange(is_reference[point], uint8_t{1}) == 0; };
  for (const StitchRun& run : map.runs)
    for (uint32_t k = 0; k < run.length; ++k)
      if (run.begin + k >= walk.size() || !mark(walk[run.begin + k]))
        return broken(patch, "a run leaves the border, or crosses itself");
  bool is_twice = false, is_unowned = false;
  for (const StitchRepeat& repeat : map.repeats) is_twice |= !mark(repeat.point);
  for (const StitchPair& pair : map.pairs) is_twice |= !mark(pair.point);
  for (const StitchRepeat& repeat : map.repeats) is_unowned |= is_reference[repeat.target] != 0;
  if (is_twice) return broken(patch, "a point has two references");
  if (is_unowned) return broken(patch, "a point repeats a reference");
  std::vector<uint32_t>& numbers = patches.numbers[patch];
  numbers.resize(point_count);
  uint32_t next = container.owned_base[patch];
  for (uint32_t point = 0; point < point_count; ++point)
    numbers[point] = is_reference[point] ? kReference : next++;
  return {};
}

// Appends the numbers of the points of a patch's runs. Only reads what number_owned wrote: a reference must
// lead to an owned point, so there are no chains of references.
Status resolve_runs(size_t patch, const Patches& patches, std::vector<uint32_t>& resolved) {
  for (const StitchRun& run : patches.maps[patch].runs)
    for (uint32_t k = 0; k < run.length; ++k) {
      const uint32_t at = run.forward ? run.start + k : run.start - k;
      const std::vector<uint32_t>& walk = patches.walks[run.owner];
      const uint32_t number = at < walk.size() ? patches.numbers[run.owner][walk[at]] : kReference;
      if (number == kReference) return broken(patch, "a run names a point that its owner does not own");
      resolved.push_back(number);
    }
  return {};
}

// Gives the references of a patch their numbers.
void set_references(const PatchContainer& container, size_t patch, std::span<const uint32_t> resolved,
                    Patches& patches) {
  const StitchMap& map = patches.maps[patch];
  std::vector<uint32_t>& numbers = patches.numbers[patch];
  size_t next = 0;
  for (const StitchRun& run : map.runs)
    for (uint32_t k = 0; k < run.length; ++k) numbers[patches.walks[patch][run.begin + k]] = resolved[next++];
  for (const StitchRepeat& repeat : map.repeats) numbers[repeat.point] = numbers[repeat.target];
  for (const StitchPair& pair : map.pairs) numbers[pair.point] = container.owned_base[pair.owner] + pair.rank;
}

}  // namespace

Expected<std::vector<std::vector<uint32_t>>> number_points(const PatchContainer& container,
                                                           std::span<const std::span<const Face>> faces,
                                                           const ThreadPool& pool) {
  const size_t count = container.entries.size();
  Patches patches(count);
  std::vector<uint8_t> needs_walk(count, 0);
  for (uint32_t patch = 0; patch < count; ++patch) {
    Expected<StitchMap> map = parse_stitch_map(container, patch);
    if (!map) return map.status();
    patches.maps[patch] = std::move(*map);
    for (const StitchRun& run : patches.maps[patch].runs) needs_walk[patch] = needs_walk[run.owner] = 1;
  }
  // Each step needs the one before it to be finished for all patches.
  std::vector<Status> statuses(count);
  const auto first_error = [&]() -> Status {
    for (Status& status : statuses)
      if (!status.ok()) return std::move(status);
    return {};
  };
  pool.for_each(count, [&](size_t i) {
    if (needs_walk[i]) patches.walks[i] = border_walk(faces[i], container.entries[i].point_count);
    statuses[i] = number_owned(container, i, patches);
  });
  if (Status status = first_error(); !status.ok()) return status;
  std::vector<std::vector<uint32_t>> resolved(count);
  pool.for_each(count, [&](size_t i) { statuses[i] = resolve_runs(i, patches, resolved[i]); });
  if (Status status = first_error(); !status.ok()) return status;
  pool.for_each(count, [&](size_t i) { set_references(container, i, resolved[i], patches); });
  return std::move(patches.numbers);
}

}  // namespace psplit
