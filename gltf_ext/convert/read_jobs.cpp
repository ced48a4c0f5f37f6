#include "gltf_ext/convert/read_jobs.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <set>

#include "encoder/coding/position_bits.h"
#include "encoder/coding/quantization.h"
#include "encoder/coding/step_grid.h"
#include "encoder/shared_codings.h"
#include "encoder/welding/reduce.h"
#include "gltf_ext/convert/encode_large_mesh.h"
#include "gltf_ext/convert/scene_offsets.h"
#include "gltf_ext/convert/shared_points.h"
#include "gltf_ext/convert/stated_grids.h"
#include "gltf_ext/convert/texture_reads.h"
#include "gltf_ext/convert/validate.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/document/unknown_references.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/out_of_core/temporary_space.h"
#include "gltf_ext/primitive/view_in_place.h"

namespace psplit {
namespace {

// For each mesh the lowest mesh that it shares a geometry with, directly or through other meshes. A shared
// geometry is stored once, so all these meshes are quantized as one.
std::map<size_t, size_t> joined_meshes(const std::vector<EncodeJob>& jobs) {
  std::map<size_t, size_t> lowest;
  const auto root = [&](size_t mesh) {
    while (lowest.try_emplace(mesh, mesh).first->second != mesh) mesh = lowest.at(mesh);
    return mesh;
  };
  for (const EncodeJob& job : jobs)
    for (const PrimitiveId id : job.group.ids) {
      const auto [low, high] = std::minmax({root(job.group.ids.front().mesh), root(id.mesh)});
      lowest[high] = low;
    }
  for (auto& [mesh, low] : lowest) low = root(mesh);
  return lowest;
}

// The grids of positions that skipped primitives have, whose streams are kept.
std::vector<KeptMesh> kept_meshes(const Document& document, const EncodeJobs& read, const ThreadPool& pool) {
  std::set<size_t> used;
  for (const EncodeJob& job : read.jobs)
    for (const PrimitiveId id : job.group.ids)
      if (const auto group = read.groups.of_mesh(id.mesh)) used.insert(*group);
  const std::vector<Attribute> position{{"POSITION", ComponentType::kFloat32, 3, false, {}}};
  std::vector<KeptMesh> kept;
  for (const auto& [at, reason] : read.skipped) {
    const PrimitiveId id{at.first, at.second};
    const auto group = read.groups.of_mesh(id.mesh);
    if (!group || !used.contains(*group)) continue;
    AttributeCoding grid = stated_grids(document, id, position, pool)[0];
    if (grid.bits > 0) kept.push_back({*group, std::move(grid)});
  }
  return kept;
}

// Warns of whole numbers that the given bits round.
void note_losses(const CodingOptions& coding, const std::set<std::string>& exact, EncodeJob& job) {
  const std::vector<uint8_t> stored = stored_points_of(job);
  for (size_t i = 0; i < job.codings.size(); ++i) {
    const Attribute& attribute = job.mesh.attributes[i];
    std::string loss =
        loss_of_whole_numbers(attribute, wanted_bounds(attribute, coding, exact, stored), job.codings[i]);
    if (!loss.empty()) job.warnings.push_back(std::move(loss));
  }
}

// Bits that are to be chosen by edges or errors are not those of the input.
void note_stated_grids(const Document& document, const EncodeDocumentOptions& options,
                       const StatedGrids& stated, std::vector<EncodeJob>& jobs, const ThreadPool& pool) {
  if (options.lossless) return;
  for (EncodeJob& job : jobs) {
    const PrimitiveId id = job.group.ids.front();
    job.stated = stated_grids(document, id, job.mesh.attributes, pool);
    if (const auto found = stated.find(id); found != stated.end())
      for (size_t i = 0; i < job.stated.size(); ++i)
        if (const auto grid = found->second.find(job.mesh.attributes[i].semantic); grid != found->second.end())
          job.stated[i] = grid->second;
    for (size_t i = 0; i < job.stated.size() && options.chooses_position_bits(); ++i)
      if (job.mesh.attributes[i].semantic == "POSITION") job.stated[i] = {};
  }
}

// Meshes on one grid touch in a scene as they did if nodes move them by multiples of its step. So the step
// becomes a power of two. Warns if that does not help.
void fit_scene(const Document& document, std::vector<EncodeJob>& jobs) {
  std::set<size_t> meshes;
  std::vector<AttributeCoding*> grids;
  for (EncodeJob& job : jobs) {
    for (const PrimitiveId id : job.group.ids) meshes.insert(id.mesh);
    if (AttributeCoding* grid = job.position_coding(); grid != nullptr) grids.push_back(grid);
  }
  if (grids.empty()) return;
  const SceneOffsets moved = scene_offsets(document.json(), meshes);
  if (moved.are_zero()) return;
  const double most = 2 * distance_bound(*grids.front());
  const std::vector<std::array<double, 3>> offsets(moved.offsets.begin(), moved.offsets.end());
  if (!moved.are_translations || !fit_to_offsets(grids, offsets))
    jobs.front().warnings.push_back(
        "nodes place the meshes of the scene so that their grids do not meet: surfaces of different meshes "
        "that touch may come apart by up to " +
        rounded_text(most));
}

// Chooses the codings of all jobs. Jobs of a group share their grids.
Status choose_job_codings(const Document& document, const EncodeDocumentOptions& options,
                          const std::set<std::string>& exact, EncodeJobs& read, const ThreadPool& pool) {
  std::vector<EncodeJob>& jobs = read.jobs;
  std::vector<MeshToCode> meshes;
  for (size_t k = 0; k < jobs.size(); ++k)
    meshes.push_back({&jobs[k].mesh, read.groups.of_mesh(jobs[k].group.ids.front().mesh).value_or(k),
                      [&job = jobs[k]] { return stored_points_of(job); },
                      texture_scales(document, jobs[k].group.ids), jobs[k].stated});
  const CodingOptions coding = options.coding();
  const std::vector<KeptMesh> kept = kept_meshes(document, read, pool);
  auto codings = choose_shared_codings(meshes, coding, exact, pool, kept);
  if (options.chooses_position_bits()) {
    size_t failed = 0;
    Status status = choose_position_bits(meshes, options.chosen_position_error(), codings, failed);
    if (!status.ok()) return std::move(status).at(jobs[failed].place(document));
  }
  auto notes = guard_precision(meshes, coding, exact, codings, pool);
  for (size_t k = 0; k < jobs.size(); ++k) {
    jobs[k].codings = std::move(codings[k]);
    jobs[k].precision = std::move(notes[k]);
  }
  if (options.volume == QuantizationVolume::kScene) fit_scene(document, jobs);
  if (coding.given.generic)
    for (EncodeJob& job : jobs) note_losses(coding, exact, job);
  return {};
}

// Whether elements are two padded columns. libdraco's values have no padding, and a VEC4 would not be a matrix.
bool is_padded_pair_of_columns(const ElementLayout& layout) {
  return layout.columns == 2 && component_bytes(layout.component_type) == 1;
}

Status read_job(const Document& document, Expected<Mesh> mesh, EncodeJob& job, std::string& skipped) {
  const PrimitiveId id = job.group.ids.front();
  if (!mesh && mesh.status().code() == StatusCode::kUnsupported) {
    skipped = mesh.status().message();
    return {};
  }
  if (!mesh) return mesh.status();
  job.mesh = std::move(*mesh);
  if (job.mesh.faces.empty()) {
    skipped = "no triangles";
    return {};
  }
  for (const Attribute& attribute : job.mesh.attributes) {
    if (attribute.component_count > 16) skipped = attribute.semantic + " has too many components";
    if (attribute.component_type == ComponentType::kUint32)
      skipped = attribute.semantic + " holds 32-bit integers";
  }
  if (document.spooled && !document.spooled->numbers.empty()) {
    const std::span<const std::byte> numbers = std::as_bytes(std::span(document.spooled->numbers));
    job.unrounded.push_back(
        {"", ComponentType::kUint32, 3, false, Array<std::byte>(numbers.begin(), numbers.end())});
  }
  auto morphs = read_morph_targets(document, id, job.mesh.point_count);
  if (!morphs && morphs.status().code() == StatusCode::kUnsupported) {
    skipped = morphs.status().message();
    return {};
  }
  if (!morphs) return morphs.status();
  job.morphs = std::move(*morphs);
  return {};
}

// Keeps the weights as they were, and rounds those of the mesh.
void round_job_weights(EncodeJob& job) {
  for (size_t i = 0; i < job.codings.size(); ++i)
    if (job.mesh.attributes[i].semantic.starts_with("WEIGHTS_") && job.codings[i].bits > 0)
      job.unrounded.push_back(job.mesh.attributes[i]);
  round_weights(job.mesh, job.codings);
}

// What the accessors state.
ExpectedSizes stated_size(const Document& document, PrimitiveId id) {
  const AssetRecords& records = document.records();
  const PrimitiveRecord& primitive = records.primitive(id);
  ExpectedSizes size{records.points_of(primitive), records.faces_of(primitive)};
  for (const AttributeRecord& attribute : primitive.attributes)
    size.record_bytes += records.accessor(attribute.accessor).layout.packed_bytes();
  return size;
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
    size_t users = 0;  // with those of the group
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

uint64_t stated_faces(const Document& document, std::span<const PrimitiveGroup> groups) {
  uint64_t faces = 0;
  for (const PrimitiveGroup& group : groups) faces += stated_size(document, group.ids.front()).faces;
  return faces;
}

// The options of one primitive. PatchTarget::count is of all primitives together, which have `all_faces`.
EncodeDocumentOptions with_share_of_patches(EncodeDocumentOptions options, uint64_t faces, uint64_t all_faces) {
  const uint64_t counts[] = {faces, all_faces - faces};
  if (options.patches.count > 0)
    options.patches.count = distribute_patches(counts, options.patches.count).front();
  return options;
}

// Nothing if the primitive stays as it is, because all of its triangles are degenerate.
Expected<std::optional<EncodeJob>> encode_in_parts(const Document& document, const PrimitiveGroup& group,
                                                   const EncodeDocumentOptions& options,
                                                   const OutOfCoreOptions& limits, const ThreadPool& pool,
                                                   const Progress& progress,
                                                   const std::function<void()>& forget) {
  const PrimitiveId id = group.ids.front();
  const PrimitiveRecord& primitive = document.records().primitive(id);
  const ExpectedSizes size = stated_size(document, id);
  if (!primitive.targets.empty()) return unsupported("morph targets do not fit into --memory");
  if (extension_field(document.json()["meshes"][id.mesh], "EXT_mesh_manifold") != nullptr)
    return unsupported("EXT_mesh_manifold does not fit into --memory");
  Status status = document.spooled ? check_space_of_parts(size, limits.temporary)
                                   : check_temporary_space(size, limits.temporary, limits.note);
  if (!status.ok()) return status;
  Expected<MeshView> view = view_in_place(document, id);
  if (!view) return view.status();
  std::span<const uint8_t> numbers;
  if (document.spooled) numbers = document.spooled->numbers;
  const Expected<LargeMesh> mesh =
      LargeMesh::open(std::move(*view), numbers,
                      {options.coding(), metadata_attributes(document.json()), options.position_bits_by_edges,
                       options.keep_duplicates, forget},
                      "accessor " + std::to_string(primitive.accessor_of("POSITION")));
  if (!mesh) return mesh.status();
  if (!mesh->has_proper_face() && !options.keep_degenerate) return std::optional<EncodeJob>();
  Expected<EncodeJob> job =
      encode_large_mesh(*mesh, options, limits, pool, texture_scales(document, group.ids), progress);
  if (!job) return job.status();
  return std::optional(std::move(*job));
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

std::set<std::string> metadata_attributes(const Json& json) {
  std::set<std::string> names;
  const Json* metadata = extension_field(json, "EXT_structural_metadata");
  if (metadata == nullptr) return names;
  for_each_element(*metadata, "propertyAttributes", [&](const Json& group) {
    for_each_member(group, "properties", [&](const Json& property) {
      if (const std::string* semantic = string_field(property, "attribute")) names.insert(*semantic);
    });
  });
  return names;
}

Expected<EncodeJobs> read_jobs(const Document& document, const EncodeDocumentOptions& options,
                               const DecodeBackend& backend, const ThreadPool& pool,
                               const OutOfCoreOptions& limits, const Progress& progress,
                               const std::function<void()>& forget, const StatedGrids& stated) {
  EncodeJobs result;
  const std::set<std::string> exact = metadata_attributes(document.json());
  SharedPoints shared_points;
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
      result.skipped[{id.mesh, id.primitive}] = *reason;
  }
  std::vector<PrimitiveGroup> groups = group_equal_primitives(document, wanted);
  const auto skip = [&](const PrimitiveGroup& group, const std::string& reason) {
    for (const PrimitiveId id : group.ids) result.skipped[{id.mesh, id.primitive}] = reason;
  };
  const uint64_t all_faces = stated_faces(document, groups);
  const SharedWithOthers shared(document, wanted, options);
  std::vector<EncodeJob> large;
  for (PrimitiveGroup& group : take_large(document, groups, limits)) {
    const PrimitiveId id = group.ids.front();
    const EncodeDocumentOptions own =
        with_share_of_patches(options, stated_size(document, id).faces, all_faces);
    Status status = shared.check(group);
    if (status.ok() && options.fallback == Fallback::kCoarse)
      status = unsupported("does not fit into memory: only a mesh in memory can be simplified");
    Expected<std::optional<EncodeJob>> encoded = std::optional<EncodeJob>();
    if (status.ok()) encoded = encode_in_parts(document, group, own, limits, pool, progress, forget);
    if (status.ok()) status = encoded.status();
    if (!status.ok()) return std::move(status).at(place_of(document, id));
    if (!*encoded) {
      skip(group, kOnlyDegenerate);
      continue;
    }
    (*encoded)->group = std::move(group);
    large.push_back(std::move(**encoded));
  }
  // Compressed primitives are decoded together. Plain ones are read one after the other: primitives may share
  // points, and each job drops the points of others before the next is read.
  const auto is_compressed = [&](const PrimitiveGroup& group) {
    return document.records().primitive(group.ids.front()).storage() != PrimitiveStorage::kPlain;
  };
  std::vector<PrimitiveId> compressed;
  for (const PrimitiveGroup& group : groups)
    if (is_compressed(group)) compressed.push_back(group.ids.front());
  std::vector<Expected<Mesh>> decoded = read_primitives(document, compressed, backend, pool);
  auto next_decoded = decoded.begin();
  for (PrimitiveGroup& group : groups) {
    EncodeJob job;
    job.group = std::move(group);
    Expected<Mesh> mesh = is_compressed(job.group)
                              ? std::move(*next_decoded++)
                              : read_primitive(document, job.group.ids.front(), backend, pool);
    std::string skipped;
    if (Status status = read_job(document, std::move(mesh), job, skipped); !status.ok())
      return std::move(status).at(job.place(document));
    if (!options.keep_degenerate && skipped.empty() && std::ranges::all_of(job.mesh.faces, repeats_a_point))
      skipped = kOnlyDegenerate;
    if (!skipped.empty()) {
      skip(job.group, skipped);
      continue;
    }
    job.options = options_of_streams(options);
    result.jobs.push_back(std::move(job));
    shared_points.divide(document, result.jobs);
  }
  shared_points.finish(result.jobs);
  result.groups = {options.volume, joined_meshes(result.jobs)};
  note_stated_grids(document, options, stated, result.jobs, pool);
  Status chosen = choose_job_codings(document, options, exact, result, pool);
  if (!chosen.ok()) return chosen;
  for (EncodeJob& job : result.jobs) round_job_weights(job);
  std::ranges::move(large, std::back_inserter(result.jobs));
  return result;
}

}  // namespace psplit
