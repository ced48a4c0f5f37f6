#include "gltf_ext/convert/sparse_targets.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gltf_ext/convert/join_data.h"
#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/document.h"
#include "gltf_ext/document/drop_unused.h"
#include "gltf_ext/document/unknown_references.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "gltf_ext/json/mesh_primitives.h"

namespace psplit {
namespace {

// Calls visit(index) for the accessors of all morph targets, also of coarse primitives.
template <AnyJson J, typename Visit>
void for_each_target(J& json, Visit&& visit) {
  const auto visit_list = [&](J& primitives) {
    for (J& primitive : primitives)
      if (J* targets = array_field(primitive, "targets"))
        for (J& target : *targets)
          if (target.is_object())
            for (J& index : target) visit(index);
  };
  if (J* meshes = array_field(json, "meshes"))
    for (J& mesh : *meshes) {
      if (J* primitives = array_field(mesh, "primitives")) visit_list(*primitives);
      if (J* others = other_primitives(mesh)) visit_list(*others);
    }
}

// Accessors that only morph targets use, and the views that only these use.
struct TargetData {
  std::vector<int64_t> accessors;
  std::vector<int64_t> views;
};

TargetData find_targets(const Document& document) {
  const Json& json = document.json();
  const AssetRecords& records = document.records();
  std::map<int64_t, size_t> uses;
  for_each_target(json, [&](const Json& index) { ++uses[integer_value(index).value_or(-1)]; });
  for (const std::vector<PrimitiveRecord>& mesh : records.meshes)
    for (const PrimitiveRecord& primitive : mesh)
      for (size_t r = 0; primitive.patches && r < primitive.patches->requests.size(); ++r)
        uses.erase(primitive.accessor_of(primitive.patches->requests[r].semantic));  // its data are in patches
  if (uses.empty()) return {};
  const DataUsers users(json);
  const auto has_unknown_members = [&](int64_t index) {
    const Json& accessor = json["accessors"][static_cast<size_t>(index)];
    const Json* const sparse = object_field(accessor, "sparse");
    return field(accessor, "extensions") != nullptr ||
           (sparse != nullptr && (sparse->contains("extras") || sparse->contains("extensions")));
  };
  std::erase_if(uses, [&](const auto& use) {
    const auto& [index, count] = use;
    return index < 0 || !DataUsers::has(users.accessors, index, count) || has_unknown_members(index);
  });
  std::map<int64_t, size_t> uses_of_view;
  for (const auto& [index, count] : uses)
    for (const int64_t view : records.accessor(index).views()) ++uses_of_view[view];
  // An accessor stays if one of its views does, and that view stays for the others that use it.
  const auto stays = [&](const auto& use) {
    const std::vector<int64_t> views = records.accessor(use.first).views();
    const bool is_own = std::ranges::all_of(views, [&](int64_t view) {
      return !records.view(view).meshopt && DataUsers::has(users.views, view, uses_of_view[view]);
    });
    if (!is_own)
      for (const int64_t view : views) --uses_of_view[view];
    return !is_own;
  };
  while (std::erase_if(uses, stays) > 0) {
  }
  TargetData found;
  for (const auto& [index, count] : uses) found.accessors.push_back(index);
  for (const auto& [view, count] : uses_of_view)
    if (count > 0 && DataUsers::has(users.views, view, count)) found.views.push_back(view);
  return found;
}

std::vector<uint8_t> stored_values(const ValuesView& data, int target) {
  std::vector<uint8_t> bytes(data.count * stored_stride(data, target));
  write_values(data, target, bytes.data());
  return bytes;
}

// The views and accessors that replace the targets'.
class NewTargets {
 public:
  // `first_view`: the number of views that the document has.
  explicit NewTargets(size_t first_view) : next_view_(first_view) {}

  // The accessor's JSON with new data.
  Json describe(Json accessor, const AccessorData& data, ZeroSign sign) {
    for (const char* name : {"bufferView", "byteOffset", "sparse"}) accessor.erase(name);
    if (!bool_field_or(accessor, "normalized", false)) accessor.erase("normalized");
    const std::vector<uint32_t> moved = elements_that_are_not_zero(data, sign);
    if (moved.empty()) {
      for (const char* name : {"min", "max"})
        if (const Json* bound = array_field(accessor, name)) accessor[name] = Json::array_t(bound->size(), 0);
      return accessor;
    }
    // What "sparse" takes in the JSON of a GLB beyond what "bufferView" does.
    constexpr size_t kSparseJson = 100;
    const size_t stride = stored_stride(data, kArrayBuffer);
    if (sparse_bytes(data, moved) + kSparseJson >= data.count * stride) {
      refer(accessor, dense_[stride], stored_values(data, kArrayBuffer), kArrayBuffer, stride);
      return accessor;
    }
    const SparseData kept = sparse_data(data, moved);
    Json& sparse = accessor["sparse"] = {{"count", moved.size()}};
    Json& indices = sparse["indices"] = {{"componentType", static_cast<int>(kept.index_type)}};
    refer(indices, indices_, kept.indices, 0, 0);
    refer(sparse["values"] = Json::object(), values_, kept.values, 0, 0);
    return accessor;
  }

  struct View {
    size_t number;
    int target;
    size_t stride;
    JoinedBlocks blocks{};
  };
  // The views in the order of their numbers.
  std::vector<const View*> views() const {
    std::vector<const View*> views;
    for (const auto* view : {&indices_, &values_})
      if (*view) views.push_back(&**view);
    for (const auto& [stride, view] : dense_)
      if (view) views.push_back(&*view);
    std::ranges::sort(views, {}, &View::number);
    return views;
  }

 private:
  void refer(Json& place, std::optional<View>& view, std::span<const uint8_t> block, int target,
             size_t stride) {
    if (!view) view = View{next_view_++, target, stride};
    place["bufferView"] = view->number;
    if (const size_t begin = view->blocks.add(block, 4).begin; begin > 0) place["byteOffset"] = begin;
  }

  size_t next_view_;
  std::optional<View> indices_, values_;
  std::map<size_t, std::optional<View>> dense_;  // by stride
};

}  // namespace

void make_targets_sparse(Document& document, ZeroSign sign) {
  const TargetData targets = find_targets(document);
  if (targets.accessors.empty()) return;
  const Json& json = std::as_const(document).json();
  const auto json_of = [&](const char* list, int64_t i) -> const Json& {
    return json[list][static_cast<size_t>(i)];
  };
  uint64_t before = 0, after = 0;
  for (const int64_t view : targets.views)
    before += json_line(json_of("bufferViews", view)).size() + document.records().view(view).range.bytes;

  const Json* const views = array_field(json, "bufferViews");
  NewTargets added(views == nullptr ? 0 : views->size());
  std::vector<Json> described;
  std::set<std::string> texts;  // equal accessors become one
  for (const int64_t index : targets.accessors) {
    const Expected<AccessorData> data = read_accessor(document, index);
    if (!data) return;  // its readers report the error
    Json accessor = added.describe(json_of("accessors", index), *data, sign);
    before += json_line(json_of("accessors", index)).size();
    if (const auto [text, is_new] = texts.insert(json_line(accessor)); is_new) after += text->size();
    described.push_back(std::move(accessor));
  }
  constexpr size_t kViewJson = 100;
  for (const NewTargets::View* view : added.views()) after += kViewJson + view->blocks.bytes().size();
  if (after >= before) return;

  for (const NewTargets::View* view : added.views()) {
    append_buffer_view(document, view->blocks.bytes());
    Json& object = document.json()["bufferViews"][view->number];
    if (view->stride > 0) object["byteStride"] = view->stride;
    if (view->target > 0) object["target"] = view->target;
  }
  for (size_t i = 0; i < described.size(); ++i)
    document.json()["accessors"][static_cast<size_t>(targets.accessors[i])] = std::move(described[i]);
  drop_unused(document, share_accessors(document, targets.accessors));
}

TargetCounts count_targets(const Document& document) {
  const AssetRecords& records = document.records();
  TargetCounts counts;
  std::set<int64_t> counted;
  std::set<std::pair<AttributeRecords, std::vector<AttributeRecords>>> seen;
  for (const std::vector<PrimitiveRecord>& mesh : records.meshes)
    for (const PrimitiveRecord& primitive : mesh) {
      if (!seen.emplace(primitive.attributes, primitive.targets).second) continue;
      for (size_t t = 0; t < primitive.targets.size(); ++t)
        for (const auto& [semantic, index] : primitive.targets[t]) {
          ++counts.all;
          if (primitive.patches && primitive.patches->stores(name_of_target(t, semantic)))
            ++counts.in_patches;
          else if (counted.insert(index).second)
            counts.bytes += records.file_bytes(records.accessor(index));
        }
    }
  return counts;
}

}  // namespace psplit
