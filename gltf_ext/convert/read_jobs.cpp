#include "gltf_ext/convert/read_jobs.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

#include "encoder/coding/position_bits.h"
#include "encoder/coding/step_grid.h"
#include "encoder/welding/reduce.h"
#include "gltf_ext/convert/scene_offsets.h"
#include "gltf_ext/convert/stated_grids.h"
#include "gltf_ext/convert/texture_reads.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/json/json_fields.h"
#include "src/core/attributes.h"
#include "src/mesh/select_points.h"

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
std::vector<KeptMesh> kept_meshes(const Document& document, const SkippedPrimitives& skipped,
                                  const GridGroups& groups, std::span<const EncodeJob> jobs,
                                  const ThreadPool& pool) {
  std::set<size_t> used;
  for (const EncodeJob& job : jobs)
    for (const PrimitiveId id : job.group.ids)
      if (const auto group = groups.of_mesh(id.mesh)) used.insert(*group);
  const std::vector<Attribute> position{{"POSITION", ComponentType::kFloat32, 3, false, {}}};
  std::vector<KeptMesh> kept;
  for (const auto& [id, reason] : skipped) {
    const auto group = groups.of_mesh(id.mesh);
    if (!group || !used.contains(*group)) continue;
    AttributeCoding grid = stated_grids(document, id, position, pool)[0];
    if (grid.bits > 0) kept.push_back({*group, std::move(grid)});
  }
  return kept;
}

// If bits are to be chosen by edges or errors, the input's bits are not kept.
void note_stated_grids(const Document& document, const EncodeDocumentOptions& options,
                       std::vector<EncodeJob>& jobs, const ThreadPool& pool) {
  if (options.lossless) return;
  for (EncodeJob& job : jobs) {
    const PrimitiveId id = job.group.ids.front();
    job.source.stated = stated_grids(document, id, job.source.mesh.attributes, pool);
    if (const auto found = options.stated.find(id); found != options.stated.end())
      for (size_t i = 0; i < job.source.stated.size(); ++i)
        if (const auto grid = found->second.find(job.source.mesh.attributes[i].semantic);
            grid != found->second.end())
          job.source.stated[i] = grid->second;
    for (size_t i = 0; i < job.source.stated.size() && options.chooses_position_bits(); ++i)
      if (job.source.mesh.attributes[i].semantic == "POSITION") job.source.stated[i] = {};
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

// Drops the points that are not kept; no face uses them.
void keep_points(EncodeJob& job, const std::vector<uint8_t>& keep) {
  std::vector<uint32_t> kept;
  for (uint32_t point = 0; point < keep.size(); ++point)
    if (keep[point] != 0) kept.push_back(point);
  Mesh& mesh = job.source.mesh;
  mesh = select_points(mesh, kept, std::move(mesh.faces));
  job.morphs = reorder(job.morphs, kept);
  if (!job.numbers.empty()) job.numbers = select_rows(job.numbers, job.numbers.size() / keep.size(), kept);
}

// Exporters write a surface of several materials as primitives with common attributes, each with indices of its
// own. Each primitive is stored with the points that its faces use. The first of them also gets the points that
// no face uses. Quantization grids are fitted after that, so that no primitive's grid holds points of another
// mesh.
class SharedPoints {
 public:
  // Call once for each job, when it has become the last of `jobs`: drops its points that others have.
  void divide(const Document& document, std::vector<EncodeJob>& jobs);
  // Call when all jobs are read: drops the first primitives' points that only others use.
  void finish(std::vector<EncodeJob>& jobs) const;

 private:
  struct Set {
    size_t first = 0;  // index into the jobs
    std::vector<uint8_t> used_by_others;
  };
  std::map<std::pair<AttributeRecords, std::vector<AttributeRecords>>, Set> sets_;  // with morph targets
};

void SharedPoints::divide(const Document& document, std::vector<EncodeJob>& jobs) {
  EncodeJob& job = jobs.back();
  const PrimitiveId id = job.group.ids.front();
  const PrimitiveRecord& primitive = document.records().primitive(id);
  if (primitive.storage() != PrimitiveStorage::kPlain) return;
  const auto [found, is_first] =
      sets_.try_emplace({primitive.attributes, primitive.targets}, Set{jobs.size() - 1, {}});
  if (is_first) return;
  std::vector<uint8_t>& used_by_others = found->second.used_by_others;
  const std::vector<uint8_t> used = used_points(job.source.mesh);
  used_by_others.resize(used.size(), 0);
  for (size_t i = 0; i < used.size(); ++i) used_by_others[i] |= used[i];
  keep_points(job, used);
}

void SharedPoints::finish(std::vector<EncodeJob>& jobs) const {
  for (const auto& [key, set] : sets_) {
    if (set.used_by_others.empty()) continue;
    std::vector<uint8_t> keep = used_points(jobs[set.first].source.mesh);
    for (size_t i = 0; i < keep.size(); ++i)
      if (set.used_by_others[i] == 0) keep[i] = 1;
    keep_points(jobs[set.first], keep);
  }
}

Status read_job(const Document& document, Expected<Mesh> mesh, EncodeJob& job, std::string& skipped) {
  const PrimitiveId id = job.group.ids.front();
  if (!mesh && mesh.status().code() == StatusCode::kUnsupported) {
    skipped = mesh.status().message();
    return {};
  }
  if (!mesh) return mesh.status();
  job.source.mesh = std::move(*mesh);
  job.morphs = take_targets(job.source.mesh);
  if (job.source.mesh.faces.empty()) {
    skipped = "no triangles";
    return {};
  }
  for (const Attribute& attribute : job.source.mesh.attributes) {
    if (attribute.component_count > 16) skipped = attribute.semantic + " has too many components";
    if (attribute.component_type == ComponentType::kUint32)
      skipped = attribute.semantic + " holds 32-bit integers";
  }
  if (document.spooled && !document.spooled->numbers.empty()) {
    const std::span<const std::byte> numbers = std::as_bytes(std::span(document.spooled->numbers));
    job.numbers.assign(numbers.begin(), numbers.end());
  }
  auto morphs = read_morph_targets(document, id, job.source.mesh.point_count);
  if (!morphs && morphs.status().code() == StatusCode::kUnsupported) {
    skipped = morphs.status().message();
    return {};
  }
  if (!morphs) return morphs.status();
  std::ranges::move(*morphs, std::back_inserter(job.morphs));
  return {};
}

bool is_zero(const MorphAttribute& morph) {
  return elements_that_are_not_zero(morph.data, ZeroSign::kIgnored).empty();
}

// Moves morph targets to the attributes of meshes that get containers, and of meshes that share their grids, so
// that touching surfaces move alike. plan() finds the grids of floats.
void move_targets_to_meshes(const Document& document, std::vector<EncodeJob>& jobs, const GridGroups& groups,
                            const EncodeDocumentOptions& options) {
  if (options.morph_targets == MorphTargets::kKeep || options.morph_targets == MorphTargets::kSparse ||
      options.compat == Compat::kKhr || options.storage == Storage::kOneStream)
    return;
  std::vector<uint64_t> faces;
  for (const EncodeJob& job : jobs) faces.push_back(job.face_count);
  const EncodeOptions of_meshes = options.of_meshes();
  const std::vector<uint32_t> counts = patch_counts(faces, of_meshes.patches);
  const bool all_are_in_containers = options.morph_targets == MorphTargets::kPatches || options.condenses() ||
                                     of_meshes.storage == Storage::kContainer;
  const auto group_of = [&](size_t k) {
    const std::optional<size_t> group = groups.of_mesh(jobs[k].group.ids.front().mesh);
    return std::pair(group.has_value(), group.value_or(k));
  };
  std::set<std::pair<bool, size_t>> in_containers;
  for (size_t k = 0; k < jobs.size(); ++k)
    if (all_are_in_containers || counts[k] > 1) in_containers.insert(group_of(k));
  for (size_t k = 0; k < jobs.size(); ++k) {
    EncodeJob& job = jobs[k];
    if (!in_containers.contains(group_of(k))) continue;
    Mesh& mesh = job.source.mesh;
    const AssetRecords& records = document.records();
    const PrimitiveRecord& primitive = records.primitive(job.group.ids.front());
    const auto stays_compressed = [&](const MorphAttribute& morph) {
      const int64_t accessor = primitive.accessor_of(name_of_target(morph.target, morph.semantic));
      return options.morph_targets == MorphTargets::kAsFits && records.is_meshopt(records.accessor(accessor));
    };
    std::vector<MorphAttribute> others;
    std::map<std::tuple<std::string, ComponentType, size_t, std::string_view>, std::string> names;  // by values
    for (MorphAttribute& morph : job.morphs) {
      const ComponentType type = morph.data.component_type;
      const bool fits = type == ComponentType::kFloat32
                            ? !options.lossless && mesh.find(morph.semantic) != nullptr
                            : type != ComponentType::kUint32;
      if (fits && mesh.attributes.size() < core::kMaxAttributes && !is_zero(morph) &&
          !stays_compressed(morph)) {
        const std::string semantic = morph.semantic;
        Attribute attribute = attribute_of(std::move(morph));
        const std::string_view bytes(reinterpret_cast<const char*>(attribute.values.data()),
                                     attribute.values.size());
        const auto [found, is_new] =
            names.try_emplace({semantic, type, attribute.component_count, bytes}, attribute.semantic);
        if (!is_new) {
          job.equal_targets.emplace_back(attribute.semantic, found->second);
          continue;
        }
        mesh.attributes.push_back(std::move(attribute));
        job.source.needs_container = true;
      } else {
        others.push_back(std::move(morph));
      }
    }
    job.morphs = std::move(others);
  }
}

// Floats without a grid would be stored as they are. A sparse accessor takes fewer bytes.
void take_exact_targets(EncodeJob& job) {
  MeshToEncode& source = job.source;
  std::vector<Attribute>& attributes = source.mesh.attributes;
  bool has_targets = false;
  std::vector<MorphAttribute> equals;
  for (size_t i = 0; i < attributes.size(); ++i) {
    const auto target = target_of(attributes[i].semantic);
    const bool is_exact =
        attributes[i].component_type == ComponentType::kFloat32 && source.codings[i].bits == 0;
    has_targets |= target && !is_exact;
    if (!target || !is_exact) continue;
    Attribute& a = attributes[i];
    job.morphs.push_back(
        {target->number,
         target->semantic,
         {a.component_type, a.component_count, a.normalized, source.mesh.point_count, std::move(a.values)}});
    for (const auto& [name, stored] : job.equal_targets)
      if (stored == a.semantic) {
        MorphAttribute equal = job.morphs.back();
        equal.target = target_of(name)->number;
        equals.push_back(std::move(equal));
      }
    std::erase_if(job.equal_targets, [&](const auto& names) { return names.second == a.semantic; });
    // They still keep points apart.
    source.distinct.push_back({job.morphs.back().data.values, a.stride()});
    attributes.erase(attributes.begin() + static_cast<std::ptrdiff_t>(i));
    source.codings.erase(source.codings.begin() + static_cast<std::ptrdiff_t>(i--));
  }
  std::ranges::move(equals, std::back_inserter(job.morphs));
  source.needs_container &= has_targets;
}

}  // namespace

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

Expected<std::vector<EncodeJob>> read_jobs(const Document& document, const EncodeDocumentOptions& options,
                                           SelectedPrimitives& selected, const DecodeBackend& backend,
                                           const ThreadPool& pool) {
  std::vector<EncodeJob> jobs;
  SharedPoints shared_points;
  // Compressed primitives are decoded together. Plain ones are read one after the other: primitives may share
  // points, and each job drops the points of others before the next is read.
  const auto is_compressed = [&](const PrimitiveGroup& group) {
    return document.records().primitive(group.ids.front()).storage() != PrimitiveStorage::kPlain;
  };
  std::vector<PrimitiveId> compressed;
  for (const PrimitiveGroup& group : selected.in_memory)
    if (is_compressed(group)) compressed.push_back(group.ids.front());
  std::vector<Expected<Mesh>> decoded = read_primitives(document, compressed, backend, pool);
  auto next_decoded = decoded.begin();
  for (const PrimitiveGroup& group : selected.in_memory) {
    EncodeJob job;
    job.group = group;
    Expected<Mesh> mesh = is_compressed(group) ? std::move(*next_decoded++)
                                               : read_primitive(document, group.ids.front(), backend, pool);
    std::string skipped;
    if (Status status = read_job(document, std::move(mesh), job, skipped); !status.ok())
      return std::move(status).at(job.place(document));
    const Mesh& read = job.source.mesh;
    if (!options.keep_degenerate && skipped.empty() && std::ranges::all_of(read.faces, repeats_a_point))
      skipped = kOnlyDegenerate;
    if (!skipped.empty()) {
      selected.skip(group, skipped);
      continue;
    }
    job.face_count = read.faces.size();
    jobs.push_back(std::move(job));
    shared_points.divide(document, jobs);
  }
  shared_points.finish(jobs);
  return jobs;
}

Expected<GridGroups> plan_jobs(const Document& document, const EncodeDocumentOptions& options,
                               const SkippedPrimitives& skipped, std::vector<EncodeJob>& jobs,
                               const ThreadPool& pool) {
  GridGroups groups{options.volume, joined_meshes(jobs)};
  move_targets_to_meshes(document, jobs, groups, options);
  note_stated_grids(document, options, jobs, pool);
  EncodeOptions of_meshes = options.of_meshes();
  of_meshes.exact.merge(metadata_attributes(document.json()));
  std::vector<MeshToEncode*> meshes;
  for (size_t k = 0; k < jobs.size(); ++k) {
    EncodeJob& job = jobs[k];
    MeshToEncode& source = job.source;
    source.group = groups.of_mesh(job.group.ids.front().mesh).value_or(k);
    source.texture_scales = texture_scales(document, job.group.ids);
    source.is_condensed_later = true;
    for (const MorphAttribute& morph : job.morphs)
      source.distinct.push_back({morph.data.values, morph.data.values.size() / std::max(1u, morph.data.count)});
    if (!job.numbers.empty())
      source.distinct.push_back({job.numbers, job.numbers.size() / source.mesh.point_count});
    meshes.push_back(&source);
  }
  size_t failed = 0;
  Status planned = plan(meshes, of_meshes, pool, kept_meshes(document, skipped, groups, jobs, pool), &failed);
  if (!planned.ok())
    return jobs.empty() ? std::move(planned) : std::move(planned).at(jobs[failed].place(document));
  if (options.volume == QuantizationVolume::kScene) fit_scene(document, jobs);
  for (EncodeJob& job : jobs) take_exact_targets(job);
  return groups;
}

Expected<PlannedJobs> read_and_plan(const Document& document, const EncodeDocumentOptions& options,
                                    const DecodeBackend& backend, const ThreadPool& pool) {
  Expected<SelectedPrimitives> selected = select_primitives(document, options);
  if (!selected) return selected.status();
  Expected<std::vector<EncodeJob>> jobs = read_jobs(document, options, *selected, backend, pool);
  if (!jobs) return jobs.status();
  const Expected<GridGroups> groups = plan_jobs(document, options, selected->skipped, *jobs, pool);
  if (!groups) return groups.status();
  return PlannedJobs{std::move(*jobs), std::move(selected->skipped)};
}

}  // namespace psplit
