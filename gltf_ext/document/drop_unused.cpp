#include "gltf_ext/document/drop_unused.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <set>

#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/byte_runs.h"
#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/document/unknown_references.h"

namespace psplit {
namespace {

using Flags = std::vector<bool>;

void mark(Flags& flags, int64_t index) {
  if (index >= 0 && static_cast<uint64_t>(index) < flags.size()) flags[static_cast<size_t>(index)] = true;
}
void mark(Flags& flags, const Json& index) { mark(flags, integer_value(index).value_or(-1)); }

// Removes the elements that are not kept from json[name]; returns the new index of each kept one.
std::vector<int64_t> compact(Json& json, const char* name, const Flags& keep) {
  std::vector<int64_t> new_index(keep.size(), -1);
  Json* array = array_field(json, name);
  if (array == nullptr) return new_index;
  Json kept = Json::array();
  for (size_t i = 0; i < keep.size(); ++i) {
    if (!keep[i]) continue;
    new_index[i] = static_cast<int64_t>(kept.size());
    kept.push_back(std::move((*array)[i]));
  }
  *array = std::move(kept);
  if (array->empty()) json.erase(name);  // glTF forbids empty arrays
  return new_index;
}

void renumber(Json& index, const std::vector<int64_t>& new_index) {
  const auto old = integer_value(index);
  if (old && *old >= 0 && static_cast<uint64_t>(*old) < new_index.size())
    index = new_index[static_cast<size_t>(*old)];
}

// Visits all ranges of buffers: views, and the compressed bytes of views.
template <typename Visit>
void for_each_range(Json& json, Visit&& visit) {
  for_each_element(json, "bufferViews", [&](Json& view) {
    visit(view);
    if (Json* meshopt = meshopt_extension(view)) visit(*meshopt);
  });
}

// Moves the runs together in place; runs of a mapped file are copied.
void keep_runs(Buffer& buffer, const ByteRuns& covered) {
  const bool is_mapped = buffer.is_shared();
  const auto size = static_cast<size_t>(covered.packed_bytes());
  std::vector<uint8_t> copied(is_mapped ? size : 0);
  const std::span<const uint8_t> from = buffer;
  uint8_t* const to = is_mapped ? copied.data() : buffer.own().data();
  for (const ByteRuns::Run& run : covered.runs())
    std::memmove(to + run.packed, from.data() + run.begin, static_cast<size_t>(run.end - run.begin));
  if (is_mapped) buffer = std::move(copied);
  buffer.own().resize(size);
  buffer.own().shrink_to_fit();
}

// A range of a buffer, and where the JSON has it.
struct RangeInMemory {
  Json* json;
  BufferRange range;
};

// The ranges of each buffer.
std::vector<std::vector<RangeInMemory>> ranges_of_buffers(Document& document) {
  std::vector<std::vector<RangeInMemory>> ranges(document.buffers.size());
  for_each_range(document.json(), [&](Json& json) {
    if (const std::optional<BufferRange> range = range_in_memory(document, json))
      ranges[static_cast<size_t>(range->buffer)].push_back({&json, *range});
  });
  return ranges;
}

// Closes the gaps that no view covers, and shortens the buffer.
void pack_buffer(Document& document, size_t buffer, std::span<const RangeInMemory> ranges) {
  Buffer& packed = document.buffers[buffer];
  const std::span<const uint8_t> bytes = packed;
  if (bytes.empty()) return;
  ByteRuns covered(bytes.size());
  for (const auto& [json, range] : ranges) covered.keep(range.offset, range.offset + range.bytes);
  covered.close();
  for (const auto& [json, range] : ranges)
    if (field(*json, "byteOffset") != nullptr)
      (*json)["byteOffset"] = range.bytes == 0 ? 0 : covered.packed(range.offset);
  if (covered.packed_bytes() != bytes.size()) keep_runs(packed, covered);
  document.json()["buffers"][buffer]["byteLength"] = packed.size();
}

}  // namespace

void drop_unused(Document& document, const std::vector<int64_t>& freed_accessors) {
  Json& json = document.json();
  const UnknownReferences unknown = find_unknown_references(json);
  const bool fixed_numbers = unknown.has_unknown_extensions;
  // Elements before the last one that may be named keep their numbers.
  const auto fixed_count = [&](const char* name, const std::set<int64_t>& named) -> size_t {
    const size_t size = array_size(json, name);
    if (fixed_numbers || named.empty()) return fixed_numbers ? size : 0;
    const auto last = static_cast<uint64_t>(*named.rbegin());
    return last < size ? static_cast<size_t>(last) + 1 : size;
  };

  Flags keep_accessor(array_size(json, "accessors"), true);
  for (const int64_t freed : freed_accessors)
    if (freed >= 0 && static_cast<uint64_t>(freed) < keep_accessor.size())
      keep_accessor[static_cast<size_t>(freed)] = unknown.accessors.contains(freed);
  for_each_accessor_reference(json, [&](const Json& index) { mark(keep_accessor, index); });
  // An accessor that must keep its index but not its data becomes a single zero.
  for (size_t i = 0; i < fixed_count("accessors", unknown.accessors); ++i) {
    if (keep_accessor[i]) continue;
    json["accessors"][i] = {{"componentType", 5121}, {"count", 1}, {"type", "SCALAR"}};
    keep_accessor[i] = true;
  }
  if (!fixed_numbers) {
    const auto new_index = compact(json, "accessors", keep_accessor);
    for_each_accessor_reference(json, [&](Json& index) { renumber(index, new_index); });
  }

  Flags keep_view(array_size(json, "bufferViews"), false);
  for (const int64_t named : unknown.views) mark(keep_view, named);
  for_each_buffer_view_reference(json, [&](const Json& index) { mark(keep_view, index); });
  for (size_t i = 0; i < fixed_count("bufferViews", unknown.views); ++i) {
    if (keep_view[i]) continue;
    const auto buffer = integer_field(json["bufferViews"][i], "buffer").value_or(0);
    const auto length = integer_field(json["bufferViews"][i], "byteLength").value_or(0);
    json["bufferViews"][i] = {
        {"buffer", buffer}, {"byteOffset", 0}, {"byteLength", std::min<int64_t>(length, 1)}};
    keep_view[i] = true;
  }
  if (!fixed_numbers) {
    const auto new_index = compact(json, "bufferViews", keep_view);
    for_each_buffer_view_reference(json, [&](Json& index) { renumber(index, new_index); });
  }

  Flags keep_buffer(array_size(json, "buffers"), false);
  for (size_t i = 0; i < fixed_count("buffers", unknown.buffers); ++i) keep_buffer[i] = true;
  keep_buffer.resize(document.buffers.size(), fixed_numbers);
  for_each_range(json, [&](Json& range) { mark(keep_buffer, integer_field(range, "buffer").value_or(-1)); });
  const auto new_index = compact(json, "buffers", keep_buffer);
  std::vector<Buffer> kept;
  for (size_t i = 0; i < document.buffers.size(); ++i)
    if (keep_buffer[i]) kept.push_back(std::move(document.buffers[i]));
  document.buffers = std::move(kept);
  for_each_range(json, [&](Json& range) {
    if (Json* buffer = field(range, "buffer")) renumber(*buffer, new_index);
  });
  const std::vector<std::vector<RangeInMemory>> ranges = ranges_of_buffers(document);
  for (size_t i = 0; i < document.buffers.size(); ++i)
    if (!unknown.buffers.contains(static_cast<int64_t>(i))) pack_buffer(document, i, ranges[i]);
}

}  // namespace psplit
