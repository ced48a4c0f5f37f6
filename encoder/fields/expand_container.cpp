#include "encoder/fields/expand_container.h"

#include "encoder/fields/expand.h"
#include "src/container/border_values.h"
#include "src/container/condensed_head.h"
#include "src/container/patch_boxes.h"

namespace psplit {
namespace {

CondensedPatch condensed_patch(const PatchContainer& container, const BorderValues& borders, uint32_t patch) {
  const StreamEntry& entry = container.entries[patch];
  core::StreamHeader header = container.headers[patch];
  borders.complete(patch, header);
  const core::View<const int32_t> known = header.condensed.known;
  return {container.streams[patch],
          entry.skeleton,
          entry.face_count,
          entry.point_count,
          {known.data(), known.size()}};
}

Expected<std::vector<uint8_t>> expand_patch(const PatchContainer& container, const BorderValues& borders,
                                            uint32_t patch) {
  const std::span<const uint8_t> stream = container.streams[patch];
  if (!container.entries[patch].is_condensed) return std::vector<uint8_t>(stream.begin(), stream.end());
  Expected<std::vector<uint8_t>> expanded =
      expand_stream(*container.head, condensed_patch(container, borders, patch));
  if (!expanded) return expanded.status().at({.patch = patch});
  if (expanded->size() > 0xffffffffu) return unsupported("a stream of more than 4 GiB", {.patch = patch});
  return expanded;
}

}  // namespace

Expected<std::vector<uint8_t>> expand_patch(const PatchContainer& container, uint32_t patch) {
  if (container.entries[patch].is_condensed && !container.refusal.ok()) return container.refusal;
  const Expected<BorderValues> borders = BorderValues::decode(container, patch);
  return borders ? expand_patch(container, *borders, patch) : borders.status();
}

Expected<std::vector<uint8_t>> expand_container(const PatchContainer& container, const ThreadPool& pool) {
  const size_t count = container.entries.size();
  std::vector<StreamEntry> entries = container.entries;
  std::vector<std::vector<uint8_t>> stitch, streams(count);
  std::vector<Status> statuses(count);
  const Expected<BorderValues> borders = BorderValues::decode(container, pool);
  if (!borders) return borders.status();
  pool.for_each(count, [&](size_t i) {
    Expected<std::vector<uint8_t>> stream = expand_patch(container, *borders, static_cast<uint32_t>(i));
    statuses[i] = stream.status();
    if (stream) streams[i] = std::move(*stream);
  });
  for (size_t i = 0; i < count; ++i) {
    if (!statuses[i].ok()) return statuses[i];
    entries[i].stream_bytes = static_cast<uint32_t>(streams[i].size());
    entries[i].is_condensed = false;
    stitch.emplace_back(container.stitch[i].begin(), container.stitch[i].end());
  }
  std::vector<uint8_t> head;
  if (const std::span<const uint8_t> boxes = boxes_section(container); !boxes.empty())
    append_head_section(HeadSection::kBoxes, boxes, head);
  return write_container(entries, container.has_residue, stitch, streams, head);
}

Expected<SectionBytes> measure_sections(const PatchContainer& container, const ThreadPool& pool) {
  const size_t count = container.entries.size();
  const Expected<BorderValues> borders = BorderValues::decode(container, pool);
  if (!borders) return borders.status();
  std::vector<Expected<SectionBytes>> measured(count, SectionBytes());
  pool.for_each(count, [&](size_t i) {
    if (container.entries[i].is_condensed)
      measured[i] =
          measure_stream(*container.head, condensed_patch(container, *borders, static_cast<uint32_t>(i)));
  });
  SectionBytes sum;
  for (size_t i = 0; i < count; ++i) {
    if (!measured[i]) return measured[i].status().at({.patch = static_cast<int64_t>(i)});
    sum += *measured[i];
  }
  return sum;
}

}  // namespace psplit
