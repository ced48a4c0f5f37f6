#include "gltf_ext/convert/read_jobs.h"

#include <algorithm>
#include <set>

#include "encoder/coding/choose_codings.h"
#include "encoder/coding/position_bits.h"
#include "encoder/coding/quantization.h"
#include "encoder/welding/reduce.h"
#include "gltf_ext/convert/shared_points.h"
#include "gltf_ext/convert/validate.h"
#include "gltf_ext/document/element_layout.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/json/json_fields.h"

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

// For each job the number of its group: jobs of a group share their grids.
std::vector<size_t> grid_groups(const std::vector<EncodeJob>& jobs, QuantizationVolume volume) {
  const std::map<size_t, size_t> joined = joined_meshes(jobs);
  std::vector<size_t> groups;
  for (size_t i = 0; i < jobs.size(); ++i)
    groups.push_back(volume == QuantizationVolume::kPrimitive ? i
                     : volume == QuantizationVolume::kMesh    ? joined.at(jobs[i].group.ids.front().mesh)
                                                              : 0);
  return groups;
}

// Chooses the codings of all jobs. Meshes that must fit together get one grid for each semantic.
void choose_job_codings(std::vector<EncodeJob>& jobs, std::span<const size_t> groups,
                        const CodingOptions& options, const std::set<std::string>& exact,
                        const ThreadPool& pool) {
  std::vector<std::vector<CodingBounds>> bounds(jobs.size());
  pool.for_each(jobs.size(), [&](size_t k) {
    EncodeJob& job = jobs[k];
    for (Attribute& attribute : job.mesh.attributes)
      if (wanted_bits(attribute, options, exact) > 0) trim_noise(attribute);
    const std::vector<uint8_t> stored = stored_points_of(job);
    for (const Attribute& attribute : job.mesh.attributes) {
      const int bits = wanted_bits(attribute, options, exact);
      bounds[k].push_back(bits == 0 ? CodingBounds() : bounds_of(attribute, bits, stored));
      job.codings.push_back(choose_coding(attribute, bounds[k].back(), bits));
    }
  });
  std::map<std::tuple<size_t, std::string, size_t>, CodingBounds> joined;
  const auto visit = [&](const auto& act) {
    for (size_t k = 0; k < jobs.size(); ++k)
      for (size_t i = 0; i < jobs[k].codings.size(); ++i) {
        const Attribute& attribute = jobs[k].mesh.attributes[i];
        AttributeCoding& coding = jobs[k].codings[i];
        if (coding.bits > 0 && !coding.octahedral)
          act(joined[{groups[k], attribute.semantic, attribute.component_count}], bounds[k][i], attribute,
              coding);
      }
  };
  visit([](CodingBounds& all, const CodingBounds& own, const auto&...) { all.add(own); });
  visit([&](const CodingBounds& all, const CodingBounds&, const Attribute& attribute, AttributeCoding& coding) {
    AttributeCoding shared = choose_coding(attribute, all, wanted_bits(attribute, options, exact));
    if (shared.bits > 0) coding = std::move(shared);
  });
}

// Chooses the bits of positions for all jobs of a group together, because they share a grid.
Status choose_position_bits(const Document& document, const EncodeDocumentOptions& options,
                            std::span<const size_t> groups, std::vector<EncodeJob>& jobs) {
  std::map<size_t, double> steps;  // the finest that the edges of one of the group's jobs want
  for (size_t k = 0; k < jobs.size() && options.position_bits_by_edges; ++k) {
    EdgeSample sample;
    sample.add(jobs[k].mesh);
    const double step = step_for_edges(sample.lengths());
    if (step == 0) continue;
    const auto [found, is_new] = steps.emplace(groups[k], step);
    if (!is_new) found->second = std::min(found->second, step);
  }
  for (size_t k = 0; k < jobs.size(); ++k) {
    AttributeCoding* coding = jobs[k].position_coding();
    if (coding == nullptr) continue;
    const Expected<int> bits = options.position_bits_by_edges
                                   ? position_bits_for_step(*coding, steps[groups[k]])
                                   : position_bits_for_error(*coding, options.max_position_error);
    if (!bits) return bits.status().at(jobs[k].place(document));
    coding->bits = *bits;
  }
  return {};
}

// An extension that refers to points or faces of the primitive by index, or null: splitting changes indices.
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

// Whether elements are two padded columns. libdraco's values have no padding, and a VEC4 would not be a matrix.
bool is_padded_pair_of_columns(const Document& document, const Json& accessor_index) {
  const auto index = integer_value(accessor_index);
  const Json* accessor = index ? top_level_object(document.json, "accessors", *index) : nullptr;
  if (accessor == nullptr) return false;
  const auto layout = element_layout(*accessor);
  return layout && layout->columns == 2 && component_bytes(layout->component_type) == 1;
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
  auto morphs = read_morph_targets(document, id, job.mesh.point_count);
  if (!morphs && morphs.status().code() == StatusCode::kUnsupported) {
    skipped = morphs.status().message();
    return {};
  }
  if (!morphs) return morphs.status();
  job.morphs = std::move(*morphs);
  return {};
}

EncodeOptions options_of_jobs(const EncodeDocumentOptions& options) {
  EncodeOptions result;
  result.refine = options.refine;
  result.method = options.method;
  result.distance = options.distance;
  result.encode_speed = options.encode_speed;
  result.keep_duplicates = options.keep_duplicates;
  result.drop_degenerate = !options.keep_degenerate;
  // A patch of its own cannot store unused points.
  result.drop_unused = !options.keep_unused || options.compat == Compat::kKhr;
  result.standalone_residue = options.compat == Compat::kKhr;
  result.condense = options.condense && options.compat == Compat::kNone;
  result.condense_smallest = options.condense_smallest;
  result.verify = options.verify;
  return result;
}

// Keeps the weights as they were, and rounds those of the mesh.
void round_job_weights(EncodeJob& job) {
  for (size_t i = 0; i < job.codings.size(); ++i)
    if (job.mesh.attributes[i].semantic.starts_with("WEIGHTS_") && job.codings[i].bits > 0)
      job.unrounded.push_back(job.mesh.attributes[i]);
  round_weights(job.mesh, job.codings);
}

// Primitives in patches are checked whole before they are encoded again, on the meshes that encoding needs
// anyway.
Status check_patched(const Document& document, const std::vector<PrimitiveId>& ids,
                     const std::vector<Expected<Mesh>>& meshes) {
  std::vector<PrimitiveId> patched;
  std::vector<MeshView> decoded;
  for (size_t i = 0; i < ids.size(); ++i) {
    if (primitive_kind(document, ids[i])->storage != PrimitiveStorage::kPatches) continue;
    if (!meshes[i]) return meshes[i].status();
    patched.push_back(ids[i]);
    decoded.push_back(view_of(*meshes[i]));
  }
  return patched.empty() ? Status() : check_decoded(document, patched, decoded);
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

Expected<std::string> reason_to_skip(const Document& document, PrimitiveId id,
                                     const EncodeDocumentOptions& options) {
  const Expected<PrimitiveKind> kind = primitive_kind(document, id);
  if (!kind) return kind.status();
  if (!kind->triangles) return std::string("points or lines");
  if (kind->storage == PrimitiveStorage::kPatches && options.compat == Compat::kNone) {
    if (options.options_of_patches.empty()) return std::string("already in patches");
    return unsupported(
        "already in patches, which " + options.options_of_patches +
            " cannot change: decode the asset first (gltf-psplit decode), and encode the result",
        {.mesh = static_cast<int64_t>(id.mesh), .primitive = static_cast<int64_t>(id.primitive)});
  }
  const Json& primitive = document.json["meshes"][id.mesh]["primitives"][id.primitive];
  if (const char* extension = order_dependent_extension(primitive))
    return extension + std::string(" depends on the order of points or faces; --drop-extension ") + extension +
           " removes it";
  for (const auto& [semantic, index] : primitive["attributes"].items())
    if (is_padded_pair_of_columns(document, index)) return semantic + " is a matrix with padding";
  return std::string();
}

Expected<EncodeJobs> read_jobs(const Document& document, const EncodeDocumentOptions& options,
                               const DecodeBackend& backend, const ThreadPool& pool,
                               const SkippedPrimitives& skipped_before) {
  EncodeJobs result;
  result.skipped = skipped_before;
  const std::set<std::string> exact = metadata_attributes(document.json);
  SharedPoints shared_points;
  std::vector<PrimitiveId> wanted;
  for (const PrimitiveId id : all_primitives(document)) {
    if (skipped_before.contains({id.mesh, id.primitive})) continue;
    const Expected<std::string> reason = reason_to_skip(document, id, options);
    if (!reason) return reason.status().at({.file = document.source.string()});
    if (reason->empty())
      wanted.push_back(id);
    else
      result.skipped[{id.mesh, id.primitive}] = *reason;
  }
  std::vector<PrimitiveGroup> groups = group_equal_primitives(document, wanted);
  // Compressed primitives are decoded together. Plain ones are read one after the other: primitives may share
  // points, and each job drops the points of others before the next is read.
  const auto is_compressed = [&](const PrimitiveGroup& group) {
    return primitive_kind(document, group.ids.front())->storage != PrimitiveStorage::kPlain;
  };
  std::vector<PrimitiveId> compressed;
  for (const PrimitiveGroup& group : groups)
    if (is_compressed(group)) compressed.push_back(group.ids.front());
  std::vector<Expected<Mesh>> decoded = read_primitives(document, compressed, backend, pool);
  if (Status status = check_patched(document, compressed, decoded); !status.ok()) return status;
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
      for (const PrimitiveId id : job.group.ids) result.skipped[{id.mesh, id.primitive}] = skipped;
      continue;
    }
    job.options = options_of_jobs(options);
    result.jobs.push_back(std::move(job));
    shared_points.divide(document, result.jobs);
  }
  shared_points.finish(result.jobs);
  const std::vector<size_t> shared_grids = grid_groups(result.jobs, options.volume);
  choose_job_codings(result.jobs, shared_grids, options.coding(), exact, pool);
  if (options.chooses_position_bits())
    if (Status status = choose_position_bits(document, options, shared_grids, result.jobs); !status.ok())
      return status;
  for (EncodeJob& job : result.jobs) round_job_weights(job);
  return result;
}

}  // namespace psplit
