#include "gltf_ext/out_of_core/encode_large_primitives.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "gltf_ext/convert/drop_attributes.h"
#include "gltf_ext/convert/patch_primitives.h"
#include "gltf_ext/convert/read_jobs.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/mesh_files/mesh_file.h"
#include "gltf_ext/out_of_core/encode_spool.h"
#include "gltf_ext/out_of_core/mesh_spool.h"
#include "gltf_ext/out_of_core/stream_primitive.h"
#include "gltf_ext/out_of_core/temporary_space.h"

namespace psplit {
namespace {

Place place_of(const Document& document, PrimitiveId id) {
  return {document.source.string(), static_cast<int64_t>(id.mesh), static_cast<int64_t>(id.primitive), -1};
}

// The primitives that are encoded, and the number of those in each mesh.
struct Candidates {
  std::vector<PrimitiveGroup> groups;
  std::map<size_t, size_t> count_of_mesh;
  size_t count = 0;
};

Expected<Candidates> find_candidates(const Document& document, const EncodeDocumentOptions& options) {
  Candidates candidates;
  std::vector<PrimitiveId> ids;
  for (const PrimitiveId id : all_primitives(document)) {
    const Expected<std::string> reason = reason_to_skip(document, id, options);
    if (!reason) return reason.status().at({.file = document.source.string()});
    if (!reason->empty()) continue;
    ids.push_back(id);
    ++candidates.count_of_mesh[id.mesh];
  }
  candidates.count = ids.size();
  candidates.groups = group_equal_primitives(document, ids);
  return candidates;
}

// The largest groups, so that the others fit into memory together.
std::vector<PrimitiveGroup> large_groups(const Document& document, std::vector<PrimitiveGroup> groups,
                                         const OutOfCoreOptions& limits) {
  std::vector<uint64_t> costs;
  std::vector<size_t> order(groups.size());
  for (const PrimitiveGroup& group : groups) {
    const PrimitiveSize size = stated_size(document, group.ids.front());
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
  return large;
}

Status check_grid(const Candidates& candidates, const PrimitiveGroup& group, QuantizationVolume volume) {
  const PrimitiveId first = group.ids.front();
  const bool shares =
      volume == QuantizationVolume::kScene ? candidates.count > group.ids.size()
      : volume == QuantizationVolume::kMesh
          ? std::ranges::any_of(group.ids,
                                [&](PrimitiveId id) { return candidates.count_of_mesh.at(id.mesh) > 1; })
          : false;
  if (!shares) return {};
  return unsupported(
      "a primitive that does not fit into --memory cannot share the grid of others: use "
      "--quantization-volume primitive",
      {.mesh = static_cast<int64_t>(first.mesh), .primitive = static_cast<int64_t>(first.primitive)});
}

// Nothing if the primitive stays as it is, because all of its triangles are degenerate.
Expected<std::optional<EncodedSpool>> encode_group(const Document& document, const PrimitiveGroup& group,
                                                   const EncodeDocumentOptions& options,
                                                   const OutOfCoreOptions& limits, const ThreadPool& pool,
                                                   const Progress& progress) {
  const PrimitiveId id = group.ids.front();
  const PrimitiveSize size = stated_size(document, id);
  if (extension_field(document.json["meshes"][id.mesh], "EXT_mesh_manifold") != nullptr)
    return unsupported("EXT_mesh_manifold does not fit into --memory");
  Status status =
      check_temporary_space({size.points, size.faces, size.record_bytes, false}, limits.temporary, limits.note);
  if (!status.ok()) return status;
  Losses losses;  // glTF values stay as they are
  SpoolOptions spool_options;
  spool_options.folder = limits.temporary;
  spool_options.repairs = false;
  spool_options.coding = options.coding();
  spool_options.samples_edges = options.position_bits_by_edges;
  spool_options.exact = metadata_attributes(document.json);
  Expected<std::unique_ptr<MeshSpool>> spool = MeshSpool::create(std::move(spool_options), losses);
  if (!spool) return spool.status();
  status = stream_primitive(document, id, **spool);
  if (status.ok()) status = (*spool)->finish();
  if (!status.ok()) return status;
  if (!(*spool)->has_proper_face()) return std::optional<EncodedSpool>();
  Expected<EncodedSpool> encoded = encode_spool(**spool, options, limits, losses, pool, progress);
  if (!encoded) return encoded.status();
  return std::optional(std::move(*encoded));
}

}  // namespace

Expected<std::vector<PrimitiveReport>> encode_large_primitives(
    Document& document, const EncodeDocumentOptions& options, const OutOfCoreOptions& limits,
    const DecodeBackend& backend, const ThreadPool& pool, const Progress& progress) {
  const Expected<Candidates> candidates = find_candidates(document, options);
  if (!candidates) return candidates.status();
  std::vector<PrimitiveGroup> large;
  std::vector<EncodedSpool> encoded;
  std::vector<size_t> counts;
  SkippedPrimitives skipped;
  std::vector<std::vector<std::string>> dropped_attributes;
  std::vector<int64_t> freed;
  for (PrimitiveGroup& group : large_groups(document, candidates->groups, limits)) {
    const Place place = place_of(document, group.ids.front());
    if (Status status = check_grid(*candidates, group, options.volume); !status.ok())
      return std::move(status).at(place);
    const Expected<DroppedAttributes> dropped = drop_attributes(document, options, group.ids);
    if (!dropped) return dropped.status();
    freed.insert(freed.end(), dropped->freed.begin(), dropped->freed.end());
    Expected<std::optional<EncodedSpool>> spool =
        encode_group(document, group, options, limits, pool, progress);
    if (!spool) return spool.status().at(place);
    if (!*spool) {
      for (const PrimitiveId id : group.ids) skipped[{id.mesh, id.primitive}] = kOnlyDegenerate;
      continue;
    }
    counts.push_back((*spool)->encoded.containers.size());
    encoded.push_back(std::move(**spool));
    dropped_attributes.push_back(dropped->of(group.ids.front()));
    large.push_back(std::move(group));
  }
  const auto groups = repeat_primitives(document, large, counts);
  std::map<std::pair<size_t, size_t>, PrimitiveReport> report_of;
  std::set<std::pair<size_t, size_t>> checked;
  for (size_t i = 0; i < large.size(); ++i) {
    // The first renumbers the accessors.
    Status status = store_containers(document, groups[i], encoded[i], limits.temporary,
                                     i == 0 ? std::span<const int64_t>(freed) : std::span<const int64_t>());
    if (!status.ok()) return status;
    for (size_t k = 0; k < groups[i].size(); ++k)
      for (const PrimitiveId id : groups[i][k].ids) {
        PrimitiveReport report = encoded[i].reports[k];
        report.id = id;
        report.dropped_attributes = dropped_attributes[i];
        report.repeated =
            id.mesh != groups[i][k].ids.front().mesh || id.primitive != groups[i][k].ids.front().primitive;
        if (report.repeated) report.input_bytes = 0;  // shared data count for the first
        report_of[{id.mesh, id.primitive}] = std::move(report);
        checked.insert({id.mesh, id.primitive});
      }
  }
  // Primitives that became several have moved those after them in their meshes.
  SkippedPrimitives moved;
  for (const auto& [id, reason] : skipped) {
    size_t number = id.second;
    for (size_t i = 0; i < large.size(); ++i)
      for (const PrimitiveId other : large[i].ids)
        if (other.mesh == id.first && other.primitive < id.second) number += counts[i] - 1;
    moved[{id.first, number}] = reason;
  }
  auto reports = encode_document(document, options, backend, pool, progress, checked, moved);
  if (!reports) return reports;
  for (PrimitiveReport& report : *reports)
    if (const auto found = report_of.find({report.id.mesh, report.id.primitive}); found != report_of.end())
      report = std::move(found->second);
  return reports;
}

}  // namespace psplit
