#include "gltf_ext/convert/replace_streams.h"

#include <algorithm>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/primitive/primitive_edit.h"

namespace psplit {
namespace {

// A range of a buffer, which a buffer view or its compressed bytes have.
struct Range {
  Json* json;
  uint64_t begin, end;
  std::span<const uint8_t> replacement{};  // empty: the bytes stay
  bool is_aligned_to_4 = false;
  uint64_t new_begin = 0;

  uint64_t new_bytes() const { return replacement.empty() ? end - begin : replacement.size(); }
};

// The buffer views of all containers and Draco streams.
std::set<int64_t> stream_views(const Document& document) {
  std::set<int64_t> views;
  for (const std::vector<PrimitiveRecord>& mesh : document.records().meshes)
    for (const PrimitiveRecord& primitive : mesh)
      for (const auto* draco : {&primitive.patches, &primitive.stock})
        if (*draco) views.insert((*draco)->view);
  return views;
}

// The ranges of each buffer, sorted by their beginnings. Ranges that reach past their buffer are left out.
std::vector<std::vector<Range>> ranges_of(Document& document, const StreamReplacements& replacements) {
  std::vector<std::vector<Range>> ranges(document.buffers.size());
  const auto add = [&](Json& json) -> Range* {
    const std::optional<BufferRange> range = range_in_memory(document, json);
    if (!range) return nullptr;
    return &ranges[static_cast<size_t>(range->buffer)].emplace_back(
        Range{&json, range->offset, range->offset + range->bytes});
  };
  const std::set<int64_t> streams = stream_views(document);
  Json& views = document.json()["bufferViews"];
  for (size_t i = 0; i < views.size(); ++i) {
    const auto found = replacements.find(static_cast<int64_t>(i));
    if (Range* const range = add(views[i])) {
      // The writer of accessors and streams aligns them to 4. Others may need 8 (EXT_structural_metadata).
      range->is_aligned_to_4 =
          streams.contains(static_cast<int64_t>(i)) || field(views[i], "target") != nullptr;
      if (found != replacements.end()) range->replacement = found->second;
    }
    if (Json* meshopt = meshopt_extension(views[i])) add(*meshopt);
  }
  for (std::vector<Range>& of_buffer : ranges) std::ranges::stable_sort(of_buffer, {}, &Range::begin);
  return ranges;
}

constexpr uint64_t kAlignment = 8;

// Containers that share bytes with other ranges lose their replacements. Returns copies of these ranges.
std::vector<Range> take_overlapping(std::vector<Range>& ranges) {
  std::vector<Range> taken;
  uint64_t end = 0;
  for (size_t i = 0; i < ranges.size(); ++i) {
    const bool overlaps =
        ranges[i].begin < end || (i + 1 < ranges.size() && ranges[i + 1].begin < ranges[i].end);
    end = std::max(end, ranges[i].end);
    if (!overlaps || ranges[i].replacement.empty()) continue;
    taken.push_back(ranges[i]);
    ranges[i].replacement = {};
  }
  return taken;
}

// Chooses the new places. Returns the size of the new buffer.
uint64_t place(std::vector<Range>& ranges) {
  uint64_t size = 0, end = 0;  // of all ranges before, in the new and in the old buffer
  for (Range& range : ranges) {
    uint64_t at = size;
    if (range.begin < end)
      at -= end - range.begin;
    else if (range.is_aligned_to_4 && range.begin == aligned_for_stream(end))
      at = aligned_for_stream(at);
    else
      at += (range.begin - at) % kAlignment;
    range.new_begin = at;
    size = std::max(size, at + range.new_bytes());
    end = std::max(end, range.end);
  }
  return size;
}

bool has_replacements(std::span<const Range> ranges) {
  return std::ranges::any_of(ranges, [](const Range& range) { return !range.replacement.empty(); });
}

void replace_in_buffer(Document& document, size_t buffer, std::vector<Range>& ranges) {
  if (!has_replacements(ranges)) return;
  const std::vector<Range> overlapping = take_overlapping(ranges);
  const std::span<const uint8_t> from = document.buffers[buffer];
  std::vector<uint8_t> bytes(static_cast<size_t>(place(ranges)));
  const auto copy = [&](std::span<const uint8_t> content, uint64_t at) {
    std::ranges::copy(content, bytes.begin() + static_cast<std::ptrdiff_t>(at));
  };
  const auto store = [&](const Range& range, uint64_t at, std::span<const uint8_t> content) {
    if (at != 0 || field(*range.json, "byteOffset") != nullptr) (*range.json)["byteOffset"] = at;
    (*range.json)["byteLength"] = content.size();
    bytes.resize(std::max<size_t>(bytes.size(), at + content.size()));
    copy(content, at);
  };
  uint64_t size = 0, end = 0;  // as above
  for (const Range& range : ranges) {
    if (range.begin > end) {  // some of the unused bytes before it stay, for its alignment
      const uint64_t unused = std::min(range.begin - end, range.new_begin - size);
      copy(from.subspan(range.begin - unused, unused), range.new_begin - unused);
    }
    store(range, range.new_begin,
          range.replacement.empty() ? from.subspan(range.begin, range.end - range.begin) : range.replacement);
    size = std::max(size, range.new_begin + range.new_bytes());
    end = std::max(end, range.end);
  }
  for (const Range& range : overlapping) store(range, aligned_for_stream(bytes.size()), range.replacement);
  document.json()["buffers"][buffer]["byteLength"] = bytes.size();
  document.buffers[buffer] = std::move(bytes);
}

}  // namespace

void replace_streams(Document& document, const StreamReplacements& replacements) {
  if (replacements.empty()) return;  // the document may have no buffer views
  std::vector<std::vector<Range>> ranges = ranges_of(document, replacements);
  for (size_t i = 0; i < ranges.size(); ++i) replace_in_buffer(document, i, ranges[i]);
}

uint64_t bytes_saved(Document& document, const StreamReplacements& replacements) {
  uint64_t saved = 0;
  for (std::vector<Range>& ranges : ranges_of(document, replacements)) {
    if (!has_replacements(ranges)) continue;
    const uint64_t after = place(ranges);
    for (Range& range : ranges) range.replacement = {};
    saved += (place(ranges) - after) / kAlignment * kAlignment;
  }
  return saved;
}

std::set<int64_t> replaceable_views(const Document& document) {
  using Placed = std::tuple<int64_t, uint64_t, uint64_t, int64_t>;  // buffer, begin, end, view or -1
  std::vector<Placed> places;
  const auto add = [&](const BufferRange& range, int64_t view) {
    if (range.bytes > 0) places.emplace_back(range.buffer, range.offset, range.offset + range.bytes, view);
  };
  const std::vector<ViewRecord>& views = document.records().views;
  for (size_t i = 0; i < views.size(); ++i) {
    add(views[i].range, static_cast<int64_t>(i));
    if (views[i].meshopt) add(views[i].meshopt->range, -1);
  }
  std::ranges::sort(places);
  std::set<int64_t> replaceable;
  uint64_t end_before = 0;
  for (size_t i = 0; i < places.size(); ++i) {
    const auto& [buffer, begin, end, view] = places[i];
    if (i > 0 && std::get<0>(places[i - 1]) != buffer) end_before = 0;
    const bool is_free_behind =
        i + 1 == places.size() || std::get<0>(places[i + 1]) != buffer || std::get<1>(places[i + 1]) >= end;
    if (view >= 0 && begin >= end_before && is_free_behind) replaceable.insert(view);
    end_before = std::max(end_before, end);
  }
  return replaceable;
}

}  // namespace psplit
