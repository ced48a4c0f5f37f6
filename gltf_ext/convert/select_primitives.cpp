#include "gltf_ext/convert/select_primitives.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <utility>

#include "gltf_ext/convert/memory_model.h"
#include "gltf_ext/document/unknown_references.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

// Whether elements are two padded columns. libdraco's values have no padding, and a VEC4 would not be a matrix.
bool is_padded_pair_of_columns(const ElementLayout& layout) {
  return layout.columns == 2 && component_bytes(layout.component_type) == 1;
}

// The reason why a primitive stays as it is; empty if it is encoded. `unknown_of_mesh`: an extension of its
// mesh that is unknown and may name accessors, or null.
Expected<std::string> reason_to_skip(const Document& document, PrimitiveId id, const char* unknown_of_mesh,
                                     const EncodeDocumentOptions& options) {
  const PrimitiveRecord& primitive = document.records().primitive(id);
  if (!primitive.status.ok()) return primitive.status;
  if (!primitive.has_triangles()) return std::string("points or lines");
  if (primitive.storage() == PrimitiveStorage::kPatches && options.compat == Compat::kNone) {
    if (options.options_of_patches.empty()) return std::string("already in patches");
    return unsupported("already in patches, which " + options.options_of_patches +
                           " cannot change: decode the asset first (gltf-psplit decode), and encode the result",
                       place_of(id));
  }
  if (const char* extension = order_dependent_extension(primitive_json(document, id)))
    return extension + std::string(" depends on the order of points or faces; --drop-extension ") + extension +
           " removes it";
  const char* unknown = unknown_extension_with_accessors(primitive_json(document, id));
  if (unknown == nullptr) unknown = unknown_of_mesh;
  if (unknown != nullptr)
    return unknown + std::string(" is unknown and may name accessors; --drop-extension ") + unknown +
           " removes it";
  for (const auto& [semantic, accessor] : primitive.attributes)
    if (is_padded_pair_of_columns(document.records().accessor(accessor).layout))
      return semantic + " is a matrix with padding";
  return std::string();
}

// Takes the largest groups out of `groups`, so that the others fit into memory together.
std::vector<PrimitiveGroup> take_large(const Document& document, std::vector<PrimitiveGroup>& groups,
                                       const OutOfCoreOptions& limits) {
  if (limits.memory == 0) return {};
  std::vector<uint64_t> costs;
  std::vector<size_t> order(groups.size());
  for (const PrimitiveGroup& group : groups) {
    const ExpectedSizes size = stated_size(document, group.ids.front());
    costs.push_back(
        MemoryPlan(limits, static_cast<size_t>(size.record_bytes)).cost.of(size.faces, size.points));
  }
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::stable_sort(order, [&](size_t a, size_t b) { return costs[a] > costs[b]; });
  uint64_t left = std::accumulate(costs.begin(), costs.end(), uint64_t{0});
  std::vector<PrimitiveGroup> large;
  for (const size_t i : order) {
    if (left <= MemoryPlan(limits, 0).cost.most) break;
    left -= costs[i];
    large.push_back(std::move(groups[i]));
  }
  std::erase_if(groups, [](const PrimitiveGroup& group) { return group.ids.empty(); });
  return large;
}

// What primitives have in common with others, of which none may be in parts: parts are encoded before the other
// primitives are read.
class SharedWithOthers {
 public:
  SharedWithOthers(const Document& document, std::span<const PrimitiveId> wanted,
                   const EncodeDocumentOptions& options)
      : document_(document), volume_(options.volume) {
    for (const PrimitiveId id : wanted) ++users_of_grids_[grid_of(id)];
    if (options.keep_unused)
      for (const PrimitiveId id : all_primitives(document)) ++users_of_points_[points_of(id)];
  }

  Status check(const PrimitiveGroup& group) const {
    std::set<size_t> grids;
    size_t users = 0;  // including the group's own
    for (const PrimitiveId id : group.ids)
      if (grids.insert(grid_of(id)).second) users += users_of_grids_.at(grid_of(id));
    if (volume_ != QuantizationVolume::kPrimitive && users != group.ids.size())
      return unsupported(
          "a primitive that does not fit into --memory cannot share the grid of others: use "
          "--quantization-volume primitive");
    // The first of them keeps the points that none of them uses.
    const auto found = users_of_points_.find(points_of(group.ids.front()));
    if (found != users_of_points_.end() && found->second > group.ids.size())
      return unsupported("--keep-unused: primitives that share their points do not fit into --memory");
    return {};
  }

 private:
  size_t grid_of(PrimitiveId id) const { return volume_ == QuantizationVolume::kScene ? 0 : id.mesh; }
  const AttributeRecords& points_of(PrimitiveId id) const {
    return document_.records().primitive(id).attributes;
  }

  const Document& document_;
  const QuantizationVolume volume_;
  std::map<size_t, size_t> users_of_grids_;             // wanted primitives
  std::map<AttributeRecords, size_t> users_of_points_;  // all primitives; empty if no points are kept for them
};

}  // namespace

const char* order_dependent_extension(const Json& primitive) {
  for (const char* name :
       {"CESIUM_primitive_outline", "EXT_mesh_primitive_edge_visibility", "FB_ngon_encoding"})
    if (extension_field(primitive, name) != nullptr) return name;
  constexpr const char* kFeatures = "EXT_mesh_features";
  const Json* features = extension_field(primitive, kFeatures);
  const Json* ids = features == nullptr ? nullptr : array_field(*features, "featureIds");
  if (ids == nullptr) return nullptr;
  const bool any_by_place = std::any_of(ids->begin(), ids->end(), [](const Json& id) {
    return field(id, "attribute") == nullptr && field(id, "texture") == nullptr;
  });
  return any_by_place ? kFeatures : nullptr;
}

ExpectedSizes stated_size(const Document& document, PrimitiveId id) {
  const AssetRecords& records = document.records();
  const PrimitiveRecord& primitive = records.primitive(id);
  ExpectedSizes size{records.points_of(primitive), records.faces_of(primitive)};
  for (const AttributeRecord& attribute : primitive.attributes)
    size.record_bytes += records.accessor(attribute.accessor).layout.packed_bytes();
  return size;
}

Expected<SelectedPrimitives> select_primitives(const Document& document, const EncodeDocumentOptions& options,
                                               const OutOfCoreOptions& limits) {
  SelectedPrimitives selected;
  std::vector<PrimitiveId> wanted;
  const char* unknown_of_mesh = nullptr;
  for (const PrimitiveId id : all_primitives(document)) {
    if (id.primitive == 0)
      unknown_of_mesh = unknown_extension_with_accessors(document.json()["meshes"][id.mesh]);
    const Expected<std::string> reason = reason_to_skip(document, id, unknown_of_mesh, options);
    if (!reason) return reason.status().at({.file = document.source.string()});
    if (reason->empty())
      wanted.push_back(id);
    else
      selected.skipped[id] = *reason;
  }
  selected.in_memory = group_equal_primitives(document, wanted);
  for (const PrimitiveGroup& group : selected.in_memory)
    selected.face_count += stated_size(document, group.ids.front()).faces;
  selected.large = take_large(document, selected.in_memory, limits);
  const SharedWithOthers shared(document, wanted, options);
  for (const PrimitiveGroup& group : selected.large) {
    Status status = shared.check(group);
    if (status.ok() && options.fallback == Fallback::kCoarse)
      status = unsupported("does not fit into memory: only a mesh in memory can be simplified");
    if (!status.ok()) return std::move(status).at(place_of(document, group.ids.front()));
  }
  return selected;
}

}  // namespace psplit
