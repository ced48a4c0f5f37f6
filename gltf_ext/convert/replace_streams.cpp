#include "gltf_ext/convert/replace_streams.h"

#include <algorithm>
#include <optional>
#include <set>
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

// The ranges of each buffer, in the order of their beginnings. Those that reach past their buffer are left out.
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

constexpr uint64_t kStreamAlignment = 4, kAlignment = 8;

uint64_t aligned(uint64_t at) { return (at + kStreamAlignment - 1) / kStreamAlignment * kStreamAlignment; }

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

void replace_in_buffer(Document& document, size_t buffer, std::vector<Range>& ranges) {
  if (std::ranges::none_of(ranges, [](const Range& range) { return !range.replacement.empty(); })) return;
  const std::vector<Range> overlapping = take_overlapping(ranges);
  const std::span<const uint8_t> from = document.buffers[buffer];
  std::vector<uint8_t> bytes;
  const auto store = [&](const Range& range, uint64_t at, std::span<const uint8_t> content) {
    if (at != 0 || field(*range.json, "byteOffset") != nullptr) (*range.json)["byteOffset"] = at;
    (*range.json)["byteLength"] = content.size();
    bytes.resize(std::max<size_t>(bytes.size(), at + content.size()));
    std::ranges::copy(content, bytes.begin() + static_cast<std::ptrdiff_t>(at));
  };
  uint64_t end = 0;  // of all ranges before, in the old buffer
  for (const Range& range : ranges) {
    uint64_t at = bytes.size();
    if (range.begin < end)
      at -= end - range.begin;
    else if (range.is_aligned_to_4 && range.begin == aligned(end))
      at = aligned(at);
    else
      at += (range.begin - at) % kAlignment;
    if (range.begin > end) {  // some of the unused bytes before it stay, for its alignment
      const uint64_t unused = std::min(range.begin - end, at - bytes.size());
      bytes.resize(static_cast<size_t>(at));
      std::ranges::copy(from.subspan(range.begin - unused, unused),
                        bytes.end() - static_cast<std::ptrdiff_t>(unused));
    }
    store(range, at,
          !range.replacement.empty() ? range.replacement : from.subspan(range.begin, range.end - range.begin));
    end = std::max(end, range.end);
  }
  for (const Range& range : overlapping) store(range, aligned(bytes.size()), range.replacement);
  document.json()["buffers"][buffer]["byteLength"] = bytes.size();
  document.buffers[buffer] = std::move(bytes);
}

}  // namespace

void replace_streams(Document& document, const StreamReplacements& replacements) {
  if (replacements.empty()) return;  // the document may have no buffer views
  std::vector<std::vector<Range>> ranges = ranges_of(document, replacements);
  for (size_t i = 0; i < ranges.size(); ++i) replace_in_buffer(document, i, ranges[i]);
}

}  // namespace psplit
