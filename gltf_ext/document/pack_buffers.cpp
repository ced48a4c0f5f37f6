#include "gltf_ext/document/pack_buffers.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/byte_runs.h"
#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/document/unknown_references.h"

namespace psplit {
namespace {

using Counts = DataUsers::Counts;

// How often each accessor describes data that an extension of the same primitive stores compressed, or belongs
// to coarse primitives.
Counts fallback_uses(const Document& document) {
  Counts uses;
  for_each_coarse_reference(document.json(),
                            [&](const Json& index) { ++uses[integer_value(index).value_or(-1)]; });
  for (const std::vector<PrimitiveRecord>& mesh : document.records().meshes)
    for (const PrimitiveRecord& primitive : mesh) {
      const DracoRecord* draco = primitive.draco();
      if (draco == nullptr || !draco->status.ok()) continue;
      for (const AttributeRequest& request : draco->requests) ++uses[primitive.accessor_of(request.semantic)];
      if (primitive.indices >= 0) ++uses[primitive.indices];
    }
  return uses;
}

// The views that only a fallback reads: also the plain bytes that a file has of what meshoptimizer compressed.
std::set<int64_t> fallback_views(const Document& document) {
  const AssetRecords& records = document.records();
  const DataUsers users(document.json());
  Counts uses_of_views;
  for (const auto& [index, uses] : fallback_uses(document))
    if (records.accessor(index).has_view() && DataUsers::has(users.accessors, index, uses))
      ++uses_of_views[records.accessor(index).elements.view];
  std::set<int64_t> views;
  for (const auto& [index, uses] : uses_of_views) {
    const ViewRecord& view = records.view(index);
    if (DataUsers::has(users.views, index, uses) && !view.meshopt && view.range.bytes > 0) views.insert(index);
  }
  for (size_t i = 0; i < records.views.size(); ++i) {
    const ViewRecord& view = records.views[i];
    const auto index = static_cast<int64_t>(i);
    if (view.meshopt && view.range.bytes > 0 && buffer_view_bytes(document, index) &&
        !is_placeholder(document, static_cast<size_t>(view.range.buffer)))
      views.insert(index);
  }
  return views;
}

void move_to(Json& object, uint64_t buffer, uint64_t offset) {
  object["buffer"] = buffer;
  if (offset != 0 || field(object, "byteOffset") != nullptr) object["byteOffset"] = offset;
}

class Packer {
 public:
  Packer(const Document& document, bool fallback_apart) : document_(document) {
    packed_.json = document.json();
    static_cast<void>(exchange_primitives(packed_.json));  // records were read, so both lists are there
    if (fallback_apart) apart_ = fallback_views(document);
    fallback_buffer_ = apart_.empty() ? 0 : 1;
    views_of_.resize(document.buffers.size());
    const std::vector<ViewRecord>& views = document.records().views;
    for (size_t i = 0; i < views.size(); ++i) {
      const auto& [range, stride, meshopt] = views[i];
      views_of_[static_cast<size_t>(range.buffer)].push_back(i);
      if (meshopt && meshopt->range.buffer != range.buffer)
        views_of_[static_cast<size_t>(meshopt->range.buffer)].push_back(i);
    }
  }

  PackedDocument run() {
    add_fallback();
    for (size_t i = 0; i < document_.buffers.size(); ++i) add_buffer(i);
    Json* views = array_field(packed_.json, "bufferViews");
    for (size_t i = 0; views != nullptr && i < views->size(); ++i) {
      Json& view = (*views)[i];
      if (is_stranded(view))
        move_to(view, 0, packed_.bytes.add(*buffer_view_bytes(document_, static_cast<int64_t>(i))));
      else if (!apart_.contains(static_cast<int64_t>(i)))
        move(view);
      if (Json* meshopt = meshopt_extension(view)) move(*meshopt);
    }
    join_placeholders();
    return std::move(packed_);
  }

 private:
  void add_fallback() {
    std::set<std::string> names;  // of meshoptimizer's extension, or "" for a view without it
    for (const int64_t index : apart_) {
      const Json& view = document_.json()["bufferViews"][static_cast<size_t>(index)];
      names.insert(name_of_meshopt(view));
    }
    if (names.size() == 1 && !names.begin()->empty())
      packed_.second["extensions"][*names.begin()] = {{"fallback", true}};
    for (const int64_t index : apart_) {
      Json& view = packed_.json["bufferViews"][static_cast<size_t>(index)];
      const auto bytes = buffer_view_bytes(document_, index);
      if (bytes) move_to(view, fallback_buffer_, packed_.fallback.add(*bytes));
    }
  }

  // Whether a view that is not compressed itself lies in bytes that meshoptimizer decoded, which no file has.
  bool is_stranded(const Json& view) const {
    if (meshopt_extension(view) != nullptr) return false;
    const std::optional<BufferRange> range = range_in_memory(document_, view);
    if (!range) return false;
    const auto buffer = static_cast<size_t>(range->buffer);
    return is_placeholder(document_, buffer) && !document_.buffers[buffer].empty();
  }

  // The bytes of buffer `index` that go into the first buffer: all except bytes that only fallback views cover.
  ByteRuns bytes_that_stay(size_t index) const {
    const uint64_t size = document_.buffers[index].size();
    ByteRuns stays(size), leaves(size);
    const std::vector<ViewRecord>& views = document_.records().views;
    const auto has_range = [&](const BufferRange& range) {
      return range.buffer == static_cast<int64_t>(index) && range.offset + range.bytes <= size;
    };
    for (const size_t i : views_of_[index]) {
      const auto& [range, stride, meshopt] = views[i];
      if (meshopt && has_range(meshopt->range))
        stays.keep(meshopt->range.offset, meshopt->range.offset + meshopt->range.bytes);
      if (!has_range(range)) continue;
      const uint64_t end = range.offset + range.bytes;
      if (apart_.contains(static_cast<int64_t>(i))) {
        // Blocks that other views may share stay too.
        const uint64_t begin = (range.offset + ByteRuns::kBlock - 1) / ByteRuns::kBlock * ByteRuns::kBlock;
        leaves.keep(begin, end / ByteRuns::kBlock * ByteRuns::kBlock);
      } else {
        stays.keep(range.offset, end);
      }
    }
    leaves.close();
    uint64_t at = 0;
    for (const ByteRuns::Run& run : leaves.runs()) {
      stays.keep(at, run.begin);
      at = run.end;
    }
    stays.keep(at, size);
    stays.close();
    return stays;
  }

  void add_buffer(size_t index) {
    const Json& buffer = document_.json()["buffers"][index];
    const std::span<const uint8_t> bytes(document_.buffers[index]);
    Placed placed{0, 0, ByteRuns(bytes.size())};
    if (is_placeholder(document_, index) && integer_field(buffer, "byteLength").value_or(0) > 0) {
      placed.buffer = 1 + fallback_buffer_ + packed_.without_bytes.size();
      packed_.without_bytes.push_back(buffer);
      placed_.push_back(std::move(placed));
      return;
    }
    if (!any_) packed_.first = buffer;
    if (any_) warn_of_loss(index, buffer);
    any_ = true;
    placed.runs = bytes_that_stay(index);
    packed_.bytes.pad(PackedBuffer::kAlignment);
    placed.base = packed_.bytes.size();
    for (const ByteRuns::Run& run : placed.runs.runs())
      packed_.bytes.add(
          bytes.subspan(static_cast<size_t>(run.begin), static_cast<size_t>(run.end - run.begin)));
    placed_.push_back(std::move(placed));
  }

  void warn_of_loss(size_t index, const Json& buffer) {
    std::string members;
    for (const auto& [name, value] : buffer.items())
      if (name != "uri" && name != "byteLength" && meshopt_extension(buffer) == nullptr)
        members += (members.empty() ? "" : ", ") + name;
    if (!members.empty())
      packed_.warnings.push_back("buffer " + std::to_string(index) +
                                 " becomes a part of another buffer and loses its " + members);
  }

  // Reading gives decoded views a placeholder of their own, so that views of a newer codec stay in the other
  // placeholder. The file gets one, as it had, unless other views refer to them.
  void join_placeholders() {
    const auto differs = [](Json a, Json b) {
      a.erase("byteLength");
      b.erase("byteLength");
      return a != b;
    };
    Json& placeholders = packed_.without_bytes;
    if (placeholders.size() != 2 || !is_meshopt_fallback(placeholders[0]) ||
        differs(placeholders[0], placeholders[1]))
      return;
    const uint64_t first = 1 + fallback_buffer_;
    std::vector<Json*> views;
    bool are_compressed = true;
    for_each_element(packed_.json, "bufferViews", [&](Json& view) {
      const auto buffer = integer_field(view, "buffer");
      if (!buffer || *buffer < static_cast<int64_t>(first)) return;
      are_compressed = are_compressed && meshopt_extension(view) != nullptr;
      views.push_back(&view);
    });
    if (!are_compressed) return;
    uint64_t bytes = 0;
    for (Json* view : views) {
      move_to(*view, first, bytes);
      bytes += (static_cast<uint64_t>(integer_field(*view, "byteLength").value_or(0)) + 3) / 4 * 4;
    }
    placeholders[0]["byteLength"] = bytes;
    placeholders.erase(1);
  }

  void move(Json& range) const {
    const auto buffer = integer_field(range, "buffer");
    if (!buffer || *buffer < 0 || static_cast<uint64_t>(*buffer) >= placed_.size()) return;
    const Placed& placed = placed_[static_cast<size_t>(*buffer)];
    const auto offset = static_cast<uint64_t>(integer_field(range, "byteOffset").value_or(0));
    if (placed.buffer != 0) {
      range["buffer"] = placed.buffer;
    } else {
      const bool is_empty = integer_field(range, "byteLength") == 0;
      move_to(range, 0, placed.base + (is_empty ? 0 : placed.runs.packed(offset)));
    }
  }

  struct Placed {
    uint64_t buffer, base;
    ByteRuns runs;
  };

  const Document& document_;
  PackedDocument packed_;
  std::set<int64_t> apart_;
  std::vector<std::vector<size_t>> views_of_;  // of each buffer: views with data or compressed bytes in it
  uint64_t fallback_buffer_ = 0;               // its index, if it exists
  std::vector<Placed> placed_;                 // the new place of each buffer of the document
  bool any_ = false;
};

}  // namespace

PackedDocument pack_buffers(const Document& document, bool fallback_apart) {
  return Packer(document, fallback_apart).run();
}

void list_buffers(PackedDocument& packed) {
  packed.bytes.pad(4);
  packed.fallback.pad(4);
  Json& json = packed.json;
  if (packed.bytes.size() == 0 && array_size(json, "bufferViews") > 0) {
    static constexpr uint8_t kZeros[4] = {};
    packed.bytes.add(std::span(kZeros));  // for views of length 0
  }
  if (packed.bytes.size() == 0) {
    json.erase("buffers");
    return;
  }
  Json first = std::move(packed.first);
  first.erase("uri");
  // A fallback buffer that has its bytes becomes an ordinary buffer when other data joins it.
  if (meshopt_extension(first) != nullptr) erase_meshopt_extension(first);
  first["byteLength"] = packed.bytes.size();
  Json buffers = Json::array();
  buffers.push_back(std::move(first));
  if (packed.fallback.size() > 0) {
    packed.second["byteLength"] = packed.fallback.size();
    buffers.push_back(std::move(packed.second));
  }
  for (Json& buffer : packed.without_bytes) buffers.push_back(std::move(buffer));
  json["buffers"] = std::move(buffers);
}

}  // namespace psplit
