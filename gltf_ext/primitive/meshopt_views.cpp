#include "gltf_ext/primitive/meshopt_views.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <string_view>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/meshopt_codec.h"
#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/document/meshopt_filters.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/document/store_meshopt.h"
#include "gltf_ext/document/unknown_references.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {

// Values that a compressed view has, or had.
struct MeshoptViews::Slot {
  ElementsPlace place;
  bool is_new = false;  // the values are in another view
  uint64_t offset = 0;  // in the compressed view
  int64_t from_view = -1;
  uint64_t from = 0, from_stride = 0;  // where the values are
  uint64_t count = 0;
  size_t width = 0;  // the bytes of one
};

void MeshoptViews::lose(const Document& document, int64_t accessor) {
  const Json& json = document.json();
  const Json* views = array_field(json, "bufferViews");
  for (const ElementsRole role : kElementsRoles) {
    const ElementsPlace place{accessor, role};
    const Json* const found = views == nullptr ? nullptr : elements_json(json["accessors"], place);
    const int64_t view = found == nullptr ? -1 : integer_field(*found, "bufferView").value_or(-1);
    const Json* const compressed = view < 0 ? nullptr : element(*views, view);
    if (compressed == nullptr || meshopt_extension(*compressed) == nullptr) continue;
    const auto offset = static_cast<uint64_t>(integer_field(*found, "byteOffset").value_or(0));
    touched_.insert(view);
    origins_[place] = {view, offset};
  }
}

// The slots of each view that lost values.
std::map<int64_t, std::vector<MeshoptViews::Slot>> MeshoptViews::slots(const Document& document,
                                                                       const std::set<int64_t>& gone) const {
  const AssetRecords& records = document.records();
  std::map<int64_t, std::vector<Slot>> slots;
  std::set<int64_t> touched = touched_;
  const auto visit = [&](ElementsPlace place, const ElementsRecord& at, uint64_t count, size_t width,
                         uint64_t stride) {
    const ViewRecord& view = records.view(at.view);
    Slot slot{place, false, at.offset, at.view, at.offset, stride > 0 ? stride : width, count, width};
    if (gone.contains(place.first)) {
      touched.insert(at.view);
    } else if (view.meshopt) {
      slots[at.view].push_back(slot);
    } else if (const auto origin = origins_.find(place); origin != origins_.end()) {
      slot.is_new = true;
      slot.offset = origin->second.offset;
      slots[origin->second.view].push_back(slot);
    }
  };
  for (size_t i = 0; i < records.accessors.size(); ++i) {
    const AccessorRecord& accessor = records.accessors[i];
    const auto index = static_cast<int64_t>(i);
    const size_t bytes = accessor.layout.stored_bytes();
    if (accessor.has_view())
      visit({index, ElementsRole::kElements}, accessor.elements, accessor.count, bytes,
            records.view(accessor.elements.view).stride);
    if (!accessor.sparse) continue;
    const SparseRecord& sparse = *accessor.sparse;
    visit({index, ElementsRole::kSparseIndices}, sparse.indices, sparse.count,
          component_bytes(sparse.index_type), 0);
    visit({index, ElementsRole::kSparseValues}, sparse.values, sparse.count, bytes, 0);
  }
  std::erase_if(slots, [&](const auto& entry) { return !touched.contains(entry.first); });
  return slots;
}

// The rows of a view, composed anew.
class MeshoptViews::Rebuilt {
 public:
  Rebuilt(Document& document, const std::vector<ViewRecord>& views, int64_t view)
      : document_(document), views_(views), view_(view), meshopt_(*views[static_cast<size_t>(view)].meshopt) {}

  // `is_shared`: others need the view as it is, so that new values get another one.
  void run(std::vector<Slot> slots, bool is_shared) {
    if (!open()) return;
    const auto fits = [&](const Slot& slot) {
      const bool is_strided = slot.place.second == ElementsRole::kElements && has_stride_;
      return is_strided ? slot.offset % stride_ + slot.width <= stride_ : slot.width == stride_;
    };
    std::erase_if(slots, [&](const Slot& slot) { return slot.is_new && (!fits(slot) || slot.count == 0); });
    if (is_shared) std::erase_if(slots, [](const Slot& slot) { return !slot.is_new; });
    const bool has_new = std::ranges::any_of(slots, &Slot::is_new);
    if (slots.empty() || (is_shared && !has_new)) return;
    const bool all_are_rows = std::ranges::all_of(slots, [&](const Slot& slot) {
      return fits(slot) && (slot.is_new || (slot.from_stride == stride_ &&
                                            slot.offset / stride_ + slot.count <= meshopt_.count));
    });
    if (!all_are_rows) return;
    group(slots);
    if (count_ == 0) return;
    compose();
    const std::vector<uint8_t> bytes = encode();
    // What only lost values may still be smaller as it is.
    if (bytes.empty() || bytes.size() >= (has_new ? plain_.size() : meshopt_.range.bytes)) return;
    store(bytes, is_shared);
  }

 private:
  // Slots whose values are beside each other in the same rows.
  struct Group {
    uint64_t old_first = 0, first = 0, count = 0;
    bool is_new = false;
    std::vector<Slot> slots;
  };

  std::span<const uint8_t> bytes_of(const BufferRange& range) const {
    const std::span<const uint8_t> bytes = document_.buffers[static_cast<size_t>(range.buffer)];
    if (range.offset > bytes.size() || range.bytes > bytes.size() - range.offset) return {};
    return bytes.subspan(static_cast<size_t>(range.offset), static_cast<size_t>(range.bytes));
  }

  // Takes the rows that the view has, as they are and as its filter made them.
  bool open() {
    const ViewRecord& view = views_[static_cast<size_t>(view_)];
    const std::span<const uint8_t> decoded = bytes_of(view.range), bytes = bytes_of(meshopt_.range);
    stride_ = meshopt_.stride;
    has_stride_ = view.stride > 0;
    if (decoded.empty() || bytes.empty() || (has_stride_ && view.stride != stride_)) return false;
    if (!is_readable_meshopt(meshopt_, bytes) || !is_legal_meshopt(meshopt_)) return false;
    old_.assign(decoded.begin(), decoded.end());
    old_.resize(meshopt_.decoded_bytes());
    if (meshopt_.filter == "NONE") return true;
    old_filtered_.resize(old_.size());
    return decode_meshopt_rows(meshopt_, bytes, old_filtered_.data());
  }

  void group(const std::vector<Slot>& slots) {
    std::map<std::tuple<uint64_t, bool, uint64_t>, std::vector<Group>> groups;
    const auto has_room = [&](const Group& group, const Slot& slot) {
      return !slot.is_new || std::ranges::none_of(group.slots, [&](const Slot& other) {
        const uint64_t at = slot.offset % stride_, of_other = other.offset % stride_;
        return at < of_other + other.width && of_other < at + slot.width;
      });
    };
    for (const Slot& slot : slots) {
      const uint64_t first = slot.offset / stride_;
      std::vector<Group>& same = groups[{first, slot.is_new, slot.count}];
      auto found = std::ranges::find_if(same, [&](const Group& group) { return has_room(group, slot); });
      if (found == same.end()) found = same.insert(same.end(), {first, 0, slot.count, slot.is_new, {}});
      found->slots.push_back(slot);
    }
    for (auto& [key, same] : groups)
      for (Group& group : same) {
        group.first = count_;
        count_ += group.count;
        groups_.push_back(std::move(group));
      }
  }

  void compose() {
    plain_.assign(count_ * stride_, 0);
    if (meshopt_.filter != "NONE") filtered_.assign(plain_.size(), 0);
    for (const Group& group : groups_) {
      const size_t bytes = group.count * stride_, to = group.first * stride_, from = group.old_first * stride_;
      if (group.is_new) {
        for (const Slot& slot : group.slots) compose_new(group, slot);
        continue;
      }
      std::memcpy(plain_.data() + to, old_.data() + from, bytes);
      if (!filtered_.empty()) std::memcpy(filtered_.data() + to, old_filtered_.data() + from, bytes);
    }
  }

  // A filter cannot make every value. But values that only moved were made by it before: their rows move too.
  void compose_new(const Group& group, const Slot& slot) {
    const size_t column = slot.offset % stride_;
    const std::span<const uint8_t> bytes = bytes_of(views_[static_cast<size_t>(slot.from_view)].range);
    const auto value = [&](uint64_t i) { return bytes.data() + slot.from + i * slot.from_stride; };
    const auto row = [&](uint64_t i) { return (group.first + i) * stride_; };
    for (uint64_t i = 0; i < slot.count; ++i) std::memcpy(&plain_[row(i) + column], value(i), slot.width);
    if (filtered_.empty()) return;
    const auto key = [&](const uint8_t* at) {
      return std::string_view(reinterpret_cast<const char*>(at), slot.width);
    };
    std::unordered_map<std::string_view, size_t>& rows = rows_[{column, slot.width}];
    if (rows.empty())
      for (size_t at = 0; at < old_.size(); at += stride_) rows.emplace(key(&old_[at + column]), at);
    const bool is_whole = group.slots.size() == 1;  // data beside the values come with them
    const size_t begin = is_whole ? 0 : column, width = is_whole ? stride_ : slot.width;
    for (uint64_t i = 0; i < slot.count; ++i) {
      const auto found = rows.find(key(value(i)));
      if (found == rows.end()) {
        filtered_.clear();
        return;
      }
      std::memcpy(&plain_[row(i) + begin], &old_[found->second + begin], width);
      std::memcpy(&filtered_[row(i) + begin], &old_filtered_[found->second + begin], width);
    }
  }

  // Returns nothing if no way gives exactly the same bytes back.
  std::vector<uint8_t> encode() {
    meshopt_.count = static_cast<size_t>(count_);
    if (!filtered_.empty()) {
      std::vector<uint8_t> undone = filtered_;
      undo_meshopt_filter(meshopt_, undone.data());
      if (undone != plain_) filtered_.clear();
    }
    if (filtered_.empty()) meshopt_.filter = "NONE";
    const std::vector<uint8_t>& rows = filtered_.empty() ? plain_ : filtered_;
    std::vector<uint8_t> bytes;
    if (is_legal_meshopt(meshopt_)) bytes = encode_meshopt_rows(meshopt_, rows);
    if (!bytes.empty() || meshopt_.mode != "TRIANGLES") return bytes;
    // Lists of triangles may come back with other corners first. A sequence does not.
    meshopt_.mode = "INDICES";
    return encode_meshopt_rows(meshopt_, rows);
  }

  void store(std::span<const uint8_t> bytes, bool is_shared) {
    Json& json = document_.json();
    Json& views = json["bufferViews"];
    const auto target = is_shared ? static_cast<int64_t>(views.size()) : view_;
    if (is_shared) views.push_back(Json(views[static_cast<size_t>(view_)]));
    store_meshopt_rows(document_, static_cast<size_t>(target), meshopt_, bytes, plain_);
    for (const Group& group : groups_)
      for (const Slot& slot : group.slots) {
        Json& place = *elements_json(json["accessors"], slot.place);
        const uint64_t offset = group.first * stride_ + slot.offset % stride_;
        place["bufferView"] = target;
        if (offset != 0 || field(place, "byteOffset") != nullptr) place["byteOffset"] = offset;
      }
  }

  Document& document_;
  const std::vector<ViewRecord>& views_;
  const int64_t view_;
  MeshoptRecord meshopt_;
  size_t stride_ = 0;
  bool has_stride_ = false;
  std::vector<uint8_t> old_, old_filtered_;  // the rows that the view has; without a filter only the first
  std::vector<Group> groups_;
  uint64_t count_ = 0;
  std::vector<uint8_t> plain_, filtered_;  // the new rows. If the second is empty, no filter makes them
  // For each column of values: the rows that have them.
  std::map<std::pair<size_t, size_t>, std::unordered_map<std::string_view, size_t>> rows_;
};

void MeshoptViews::compress_again(Document& document, const std::vector<int64_t>& freed) {
  if (touched_.empty() && freed.empty()) return;
  const Json& json = std::as_const(document).json();
  const UnknownReferences unknown = find_unknown_references(json);
  std::set<int64_t> gone(freed.begin(), freed.end());
  for_each_accessor_reference(json, [&](const Json& index) { gone.erase(integer_value(index).value_or(-1)); });
  for (const int64_t named : unknown.accessors) gone.erase(named);
  std::map<int64_t, size_t> uses;
  for_each_buffer_view_reference(json, [&](const Json& index) { ++uses[integer_value(index).value_or(-1)]; });
  const AssetRecords& records = document.records();
  for (const int64_t index : gone) {
    if (index < 0 || static_cast<uint64_t>(index) >= records.accessors.size()) continue;
    const AccessorRecord& accessor = records.accessor(index);
    if (accessor.has_view()) --uses[accessor.elements.view];
    if (!accessor.sparse) continue;
    --uses[accessor.sparse->indices.view];
    --uses[accessor.sparse->values.view];
  }
  const std::vector<ViewRecord> views = records.views;
  for (auto& [view, of_view] : slots(document, gone)) {
    const auto old_slots =
        static_cast<size_t>(std::ranges::count_if(of_view, [](const Slot& slot) { return !slot.is_new; }));
    const bool is_shared = unknown.views.contains(view) || uses[view] != old_slots;
    Rebuilt(document, views, view).run(std::move(of_view), is_shared);
  }
}

}  // namespace psplit
