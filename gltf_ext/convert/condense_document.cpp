#include "gltf_ext/convert/condense_document.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "encoder/condensing/condense.h"
#include "encoder/verify.h"
#include "gltf_ext/convert/replace_streams.h"
#include "gltf_ext/document/unknown_references.h"
#include "gltf_ext/json/json_text.h"
#include "gltf_ext/primitive/mesh_view.h"
#include "gltf_ext/primitive/primitive_edit.h"
#include "psplit/decode.h"
#include "src/container/patch_container.h"
#include "src/cpu/checked_decode.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

using AccessorChanges = std::map<int64_t, Json>;  // by index

// The streams in one buffer view, and their condensed container.
struct Candidate {
  int64_t view;
  bool is_stock;
  CondensedView result{};
  std::vector<uint8_t> container{};  // empty: the streams stay
  AccessorChanges accessors{};
  Status status{};
};

std::vector<Candidate> find_candidates(const Document& document, std::span<const PrimitiveId> ids) {
  std::vector<Candidate> candidates;
  std::map<int64_t, size_t> candidate_of;  // by buffer view
  for (const PrimitiveId id : ids) {
    const PrimitiveRecord& primitive = document.records().primitive(id);
    const DracoRecord* draco = primitive.draco();
    if (draco == nullptr || !draco->status.ok()) continue;
    const auto [found, is_new] = candidate_of.try_emplace(draco->view, candidates.size());
    if (is_new) candidates.push_back({draco->view, !primitive.patches});
    candidates[found->second].result.ids.push_back(id);
  }
  return candidates;
}

// Whether the accessor holds these values; true if something else supplies them.
bool has_no_other_data(const Document& document, int64_t index, const ValuesView& values) {
  const AccessorRecord& accessor = document.records().accessor(index);
  if (accessor.sparse) return false;
  if (!accessor.has_view()) return true;
  const Expected<AccessorData> data = read_accessor(document, index);
  return data && std::ranges::equal(data->values, values.bytes);
}

// The accessors that must change if a container has this mesh, with their new JSON. Nothing if the primitives
// may not have such a container, or if other objects use such an accessor.
std::optional<AccessorChanges> exact_accessors(const Document& document, std::span<const PrimitiveId> ids,
                                               const Mesh& decoded, const DataUsers& users) {
  const AssetRecords& records = document.records();
  const PrimitiveRecord& primitive = records.primitive(ids.front());
  AccessorChanges changes;
  const auto agrees = [&](int64_t index, const ValuesView& values, bool needs_bounds) {
    if (index < 0 || records.accessor(index).count != values.count) return false;
    if (!has_no_other_data(document, index, values)) return false;
    const Json& accessor = document.json()["accessors"][static_cast<size_t>(index)];
    const Json *least = field(accessor, "min"), *most = field(accessor, "max");
    if (!needs_bounds && least == nullptr && most == nullptr) return true;
    Json exact = Json::object();
    describe_decoded(exact, values, true);
    if (is_bound(least, exact["min"]) && is_bound(most, exact["max"])) return true;
    Json changed = accessor;
    for (const char* name : {"min", "max"}) changed[name] = exact[name];
    return DataUsers::has(users.accessors, index, ids.size()) &&
           changes.emplace(index, std::move(changed)).second;
  };
  for (const auto& [semantic, values] : view_of(decoded).attributes)
    if (!agrees(primitive.accessor_of(semantic), values, semantic == "POSITION")) return std::nullopt;
  if (primitive.mode != 4 || !agrees(primitive.indices, IndexData(decoded), false)) return std::nullopt;
  const ComponentType index_type = records.accessor(primitive.indices).layout.component_type;
  if (uint64_t{decoded.point_count} >= uint64_t{1} << 8 * component_bytes(index_type)) return std::nullopt;
  return changes;
}

// Condenses a container, or a stream of stock Draco. `plain` is the decoded mesh.
Status condense(const PatchContainer& opened, const StoredPrimitive& stored, const Mesh& plain,
                const CondenseOptions& options, const ThreadPool& pool, Candidate& candidate) {
  CondensedView& result = candidate.result;
  const Stopwatch condense_time;
  std::optional<CondensedContainer> condensed =
      condense_container(opened, stored.bytes.size(), options.smallest, pool);
  result.condense_ms = condense_time.ms();
  if (!condensed) return {};
  if (options.verify) {
    const ScopedStopwatch verify_time(result.verify_ms);
    if (Status status = verify_condensed(condensed->bytes, stored.requests, plain, pool); !status.ok())
      return status;
  }
  candidate.container = std::move(condensed->bytes);
  result.entries = std::move(condensed->entries);
  result.head_bytes = condensed->head_bytes;
  result.has_residue = opened.has_residue;
  result.face_count = opened.face_count();
  result.point_count = opened.point_count();
  return {};
}

Status condense_patches(const StoredPrimitive& stored, const CondenseOptions& options, const ThreadPool& pool,
                        Candidate& candidate) {
  const Expected<PatchContainer> container = open_container(stored.bytes);
  if (!container) return container.status();
  candidate.result.was_condensed = container->condensed_count() > 0;
  if (candidate.result.was_condensed) return {};
  if (const Mesh* const known = options.decoded(candidate.result.ids.front()))
    return condense(*container, stored, *known, options, pool, candidate);
  Expected<Mesh> plain = Mesh();
  if (options.verify) plain = cpu_backend().decode(*container, stored.requests, pool);
  if (!plain) return runtime_failure("verification: " + plain.status().to_string());
  return condense(*container, stored, *plain, options, pool, candidate);
}

// Leaves sequential streams, streams of old bitstreams, and all that a container may not hold.
Status condense_stock(const Document& document, const StoredPrimitive& stored, const DataUsers& users,
                      const CondenseOptions& options, const ThreadPool& pool, Candidate& candidate) {
  const std::vector<PrimitiveId>& ids = candidate.result.ids;
  const AssetRecords& records = document.records();
  const auto points = static_cast<uint32_t>(records.points_of(records.primitive(ids.front())));
  PatchContainer stream = open_stream(stored.bytes, points);
  if (!stream.refusal.ok() || !stream.headers[0].edgebreaker || stream.point_count() != points) return {};
  stream.expect_points(points);
  if (group_equal_primitives(document, ids).size() > 1) return {};
  const Expected<CheckedMesh> plain = decode_checked(stream, stored.requests, pool);
  if (!plain || !plain->streams[0].types.ok()) return {};
  std::optional<AccessorChanges> changes = exact_accessors(document, ids, plain->mesh, users);
  if (!changes) return {};
  candidate.accessors = std::move(*changes);
  return condense(stream, stored, plain->mesh, options, pool, candidate);
}

// The bytes of a file's JSON, on each of the two ways to write it.
struct JsonBytes {
  explicit JsonBytes(const Json& json)
      : in_glb(std::ssize(json_line(json))), in_gltf(std::ssize(json_lines(json))) {}

  int64_t in_glb, in_gltf;
};

// Whether a file gets smaller.
bool pays(uint64_t saved, const JsonBytes& before, const JsonBytes& after) {
  const auto bytes = static_cast<int64_t>(saved);
  return bytes > after.in_glb - before.in_glb && bytes > after.in_gltf - before.in_gltf;
}

// Whether the candidate makes the file smaller, lists of extensions apart.
bool pays_alone(const Document& document, const Candidate& candidate) {
  const uint64_t stream_bytes = document.records().view(candidate.view).range.bytes;
  Json before = Json::array(), after = Json::array();
  for (const auto& [index, changed] : candidate.accessors) {
    before.push_back(document.json()["accessors"][static_cast<size_t>(index)]);
    after.push_back(changed);
  }
  const uint64_t saved = aligned_for_stream(stream_bytes) - aligned_for_stream(candidate.container.size());
  return pays(saved, JsonBytes(Json{{"accessors", before}}), JsonBytes(Json{{"accessors", after}}));
}

// Changes the JSON from stock Draco to containers, if that makes the file smaller.
void name_containers(Document& document, std::vector<Candidate>& candidates) {
  std::vector<PrimitiveId> ids;
  StreamReplacements replacements;
  for (Candidate& candidate : candidates) {
    if (!candidate.is_stock || candidate.container.empty()) continue;
    if (!pays_alone(document, candidate)) {
      candidate.container.clear();
      continue;
    }
    ids.insert(ids.end(), candidate.result.ids.begin(), candidate.result.ids.end());
    replacements[candidate.view] = candidate.container;
  }
  if (ids.empty()) return;
  const Json before = document.json();
  rename_draco_extension(document, ids, kStockExtensionName, kExtensionName);
  unlist_unused_extension(document, kStockExtensionName);
  Json& accessors = document.json()["accessors"];
  for (Candidate& candidate : candidates)
    if (!candidate.container.empty())
      for (auto& [index, changed] : candidate.accessors)
        accessors[static_cast<size_t>(index)] = std::move(changed);
  if (pays(bytes_saved(document, replacements), JsonBytes(before), JsonBytes(document.json()))) return;
  document.json() = before;
  for (Candidate& candidate : candidates)
    if (candidate.is_stock) candidate.container.clear();
}

}  // namespace

Expected<std::vector<CondensedView>> condense_document(Document& document, std::span<const PrimitiveId> ids,
                                                       const CondenseOptions& options, const ThreadPool& pool) {
  if (Status status = document.check(); !status.ok()) return status;
  std::vector<Candidate> candidates = find_candidates(document, ids);
  const DataUsers users(std::as_const(document).json());
  const std::set<int64_t> replaceable = replaceable_views(document);
  pool.for_each(candidates.size(), [&](size_t i) {
    Candidate& candidate = candidates[i];
    const PrimitiveId id = candidate.result.ids.front();
    const Expected<StoredPrimitive> stored = stored_primitive(document, id);
    if (!stored) candidate.status = stored.status();
    // What has other users, or shares bytes with another view, stays.
    else if (DataUsers::has(users.views, candidate.view, candidate.result.ids.size()) &&
             replaceable.contains(candidate.view))
      candidate.status = candidate.is_stock ? condense_stock(document, *stored, users, options, pool, candidate)
                                            : condense_patches(*stored, options, pool, candidate);
    candidate.status = std::move(candidate.status).at(place_of(document, id));
  });
  for (Candidate& candidate : candidates)
    if (!candidate.status.ok()) return std::move(candidate.status);
  name_containers(document, candidates);
  StreamReplacements replacements;
  std::vector<CondensedView> results;
  for (Candidate& candidate : candidates) {
    if (!candidate.container.empty()) replacements[candidate.view] = candidate.container;
    candidate.result.bytes = candidate.container.size();
    results.push_back(std::move(candidate.result));
  }
  replace_streams(document, replacements);
  return results;
}

}  // namespace psplit
