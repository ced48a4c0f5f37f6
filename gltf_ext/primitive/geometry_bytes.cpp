#include "gltf_ext/primitive/geometry_bytes.h"

#include <algorithm>
#include <numeric>
#include <set>
namespace psplit {
namespace {

// Calls visit(view) for the buffer views of a primitive's streams.
template <typename Visit>
void for_each_stream(const PrimitiveRecord& primitive, Visit&& visit) {
  for (const auto* draco : {&primitive.patches, &primitive.stock})
    if (*draco && (*draco)->view >= 0) visit((*draco)->view);
}

// Counts each accessor and each buffer view once.
class ByteCounter {
 public:
  explicit ByteCounter(const AssetRecords& records) : records_(records) {}

  uint64_t primitive(PrimitiveId id) {
    const PrimitiveRecord& primitive = records_.primitive(id);
    uint64_t bytes = 0;
    for_each_stream(primitive, [&](int64_t view) {
      if (views_.insert(view).second) bytes += records_.view(view).file_bytes();
    });
    for (const AttributeRecord& attribute : primitive.attributes) bytes += accessor(attribute.accessor);
    return bytes + (primitive.indices < 0 ? 0 : accessor(primitive.indices));
  }

 private:
  uint64_t accessor(int64_t index) {
    return accessors_.insert(index).second ? records_.file_bytes(records_.accessor(index)) : 0;
  }

  const AssetRecords& records_;
  std::set<int64_t> accessors_, views_;
};

// Calls visit(index) for the accessors of a primitive: attributes, indices and morph targets.
template <typename Visit>
void for_each_accessor(const PrimitiveRecord& primitive, Visit&& visit) {
  for (const AttributeRecord& attribute : primitive.attributes) visit(attribute.accessor);
  if (primitive.indices >= 0) visit(primitive.indices);
  for (const AttributeRecords& target : primitive.targets)
    for (const AttributeRecord& attribute : target) visit(attribute.accessor);
}

}  // namespace

std::map<PrimitiveId, uint64_t> geometry_bytes(const Document& document) {
  std::map<PrimitiveId, uint64_t> bytes;
  ByteCounter counter(document.records());
  for (const PrimitiveId id : all_primitives(document)) bytes[id] = counter.primitive(id);
  return bytes;
}

uint64_t geometry_bytes(const Document& document, std::span<const PrimitiveId> primitives) {
  uint64_t bytes = 0;
  ByteCounter counter(document.records());
  for (const PrimitiveId id : primitives) bytes += counter.primitive(id);
  return bytes;
}

std::vector<std::vector<size_t>> GeometryOwners::sharing_sets(const Groups& groups) const {
  std::vector<size_t> parent(groups.size());
  std::iota(parent.begin(), parent.end(), size_t{0});
  const auto root = [&](size_t group) {
    while (parent[group] != group) group = parent[group] = parent[parent[group]];
    return group;
  };
  std::map<int64_t, size_t> first_user;
  const AssetRecords& records = document_.records();
  for (size_t i = 0; i < groups.size(); ++i) {
    const auto join = [&](int64_t view) {
      const size_t other = root(first_user.try_emplace(view, i).first->second), own = root(i);
      parent[std::max(own, other)] = std::min(own, other);
    };
    const PrimitiveRecord& primitive = records.primitive(groups[i]->ids.front());
    for_each_stream(primitive, join);
    for_each_accessor(primitive,
                      [&](int64_t index) { std::ranges::for_each(records.accessor(index).views(), join); });
  }
  std::map<size_t, std::vector<size_t>> sets;
  for (size_t i = 0; i < groups.size(); ++i) sets[root(i)].push_back(i);
  std::vector<std::vector<size_t>> result;
  for (auto& [first, set] : sets) result.push_back(std::move(set));
  return result;
}

GeometryOwners::Freed GeometryOwners::freed_by(const Groups& groups) const {
  const AssetRecords& records = document_.records();
  DataUsers::Counts accessor_uses, view_uses;
  for (const PrimitiveGroup* group : groups) {
    const PrimitiveRecord& primitive = records.primitive(group->ids.front());
    for_each_accessor(primitive, [&](int64_t index) { accessor_uses[index] += group->ids.size(); });
    for_each_stream(primitive, [&](int64_t view) { view_uses[view] += group->ids.size(); });
  }
  const DataUsers::Counts streams = view_uses;
  Freed freed;
  std::vector<const AccessorRecord*> accessors;
  for (const auto& [index, uses] : accessor_uses) {
    if (!DataUsers::has(users_.accessors, index, uses)) continue;
    accessors.push_back(&records.accessor(index));
    freed.accessors.insert(index);
    for (const int64_t view : accessors.back()->views()) ++view_uses[view];
  }
  for (const auto& [view, uses] : view_uses)
    if (DataUsers::has(users_.views, view, uses)) freed.views.insert(view);
  for (const AccessorRecord* accessor : accessors) {
    if (std::ranges::all_of(accessor->views(), [&](int64_t view) { return freed.views.contains(view); }))
      freed.bytes += records.file_bytes(*accessor);
  }
  for (const auto& [view, uses] : streams)
    if (freed.views.contains(view)) freed.bytes += records.view(view).file_bytes();
  return freed;
}

}  // namespace psplit
