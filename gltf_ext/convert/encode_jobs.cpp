#include "gltf_ext/convert/encode_jobs.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <set>

#include "encoder/coding/quantization.h"
#include "encoder/partition/partition.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/document/structure.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

bool all_unit_vectors(const Attribute& attribute) {
  for (size_t at = 0; at < attribute.values.size(); at += 12) {
    std::array<float, 3> v{};
    std::memcpy(v.data(), attribute.values.data() + at, 12);
    const double square =
        double{v[0]} * double{v[0]} + double{v[1]} * double{v[1]} + double{v[2]} * double{v[2]};
    if (!(std::fabs(std::sqrt(square) - 1.0) <= 1e-2)) return false;
  }
  return true;
}

// Attributes that name things or hold data of the application, which must not be rounded though they are
// floats: feature ids (EXT_mesh_features, and _BATCHID of 3D Tiles before it) and what EXT_structural_metadata
// reads.
class ExactAttributes {
 public:
  explicit ExactAttributes(const Json& json) {
    const Json* metadata = extension_field(json, "EXT_structural_metadata");
    if (metadata == nullptr) return;
    for_each_element(*metadata, "propertyAttributes", [&](const Json& group) {
      for_each_member(group, "properties", [&](const Json& property) {
        if (const std::string* semantic = string_field(property, "attribute")) named_.insert(*semantic);
      });
    });
  }

  bool contains(const std::string& semantic) const {
    return semantic.starts_with("_FEATURE_ID_") || semantic == "_BATCHID" || named_.contains(semantic);
  }

 private:
  std::set<std::string> named_;
};

// What no grid can hold (integers, NaN, normals that are no directions) is kept exactly.
AttributeCoding coding_of(const Attribute& attribute, const ExactAttributes& exact,
                          const EncodeDocumentOptions& options) {
  if (options.lossless || attribute.component_type != ComponentType::kFloat32) return {};
  if (exact.contains(attribute.semantic)) return {};
  const auto starts = [&](const char* prefix) { return attribute.semantic.starts_with(prefix); };
  if (attribute.semantic == "NORMAL" && attribute.component_count == 3) {
    if (options.normal_bits < 2 || !all_unit_vectors(attribute)) return {};
    return {options.normal_bits, true, {}, 0};
  }
  const int bits = attribute.semantic == "POSITION" ? options.position_bits
                   : starts("TEXCOORD_")            ? options.texcoord_bits
                   : starts("COLOR_")               ? options.color_bits
                                                    : options.generic_bits;
  if (bits == 0) return {};
  Expected<AttributeCoding> grid = fit_grid(attribute, bits);
  return grid.ok() ? std::move(*grid) : AttributeCoding{};
}

// For every mesh the lowest one that it shares a geometry with, be it over others: the geometry is stored once,
// so all of them are quantized as one.
std::map<size_t, size_t> joined_meshes(const std::vector<Job>& jobs) {
  std::map<size_t, size_t> lowest;
  const auto root = [&](size_t mesh) {
    while (lowest.try_emplace(mesh, mesh).first->second != mesh) mesh = lowest.at(mesh);
    return mesh;
  };
  for (const Job& job : jobs)
    for (const PrimitiveId id : job.group.ids) {
      const auto [low, high] = std::minmax({root(job.group.ids.front().mesh), root(id.mesh)});
      lowest[high] = low;
    }
  for (auto& [mesh, low] : lowest) low = root(mesh);
  return lowest;
}

// Meshes that must fit together get one grid per semantic.
void share_grids(std::vector<Job>& jobs, QuantizationVolume volume) {
  if (volume == QuantizationVolume::kPrimitive) return;
  const std::map<size_t, size_t> joined = joined_meshes(jobs);
  std::map<std::tuple<size_t, std::string, size_t>, AttributeCoding> grids;
  const auto visit = [&](const auto& act) {
    for (Job& job : jobs)
      for (size_t i = 0; i < job.codings.size(); ++i) {
        const Attribute& attribute = job.mesh.attributes[i];
        if (job.codings[i].bits == 0 || job.codings[i].octahedral) continue;
        const size_t mesh = volume == QuantizationVolume::kMesh ? joined.at(job.group.ids.front().mesh) : 0;
        act(std::tuple(mesh, attribute.semantic, size_t{attribute.component_count}), job.codings[i]);
      }
  };
  visit([&](const auto& key, AttributeCoding& coding) {
    const auto [found, is_new] = grids.emplace(key, coding);
    if (!is_new) found->second = merge_grids(found->second, coding);
  });
  visit([&](const auto& key, AttributeCoding& coding) { coding = grids.at(key); });
}

// The extension that means points or faces of a primitive by their place, which splitting changes, or null.
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

// libdraco's values have no padding between columns, and a VEC4 would no longer be a matrix.
bool is_padded_pair_of_columns(const Document& document, const Json& accessor_index) {
  const auto index = integer_value(accessor_index);
  const Json* accessor = index ? top_level_object(document.json, "accessors", *index) : nullptr;
  if (accessor == nullptr) return false;
  const auto layout = element_layout(*accessor);
  return layout && layout->columns == 2 && component_bytes(layout->component_type) == 1;
}

// Why a primitive is left as it is; empty when it is to be encoded.
Expected<std::string> reason_to_skip(const Document& document, PrimitiveId id,
                                     const EncodeDocumentOptions& options) {
  const Expected<PrimitiveKind> kind = primitive_kind(document, id);
  if (!kind) return kind.status();
  if (!kind->triangles) return std::string("points or lines");
  if (kind->storage == PrimitiveStorage::kPatches && options.compat == Compat::kNone)
    return std::string("already in patches");
  const Json& primitive = document.json["meshes"][id.mesh]["primitives"][id.primitive];
  if (const char* extension = order_dependent_extension(primitive))
    return extension + std::string(" depends on the order of points or faces");
  for (const auto& [semantic, index] : primitive["attributes"].items())
    if (is_padded_pair_of_columns(document, index)) return semantic + " is a matrix with padding";
  return std::string();
}

bool all_degenerate(const Mesh& mesh) {
  return std::all_of(mesh.faces.begin(), mesh.faces.end(), [](const std::array<uint32_t, 3>& face) {
    return face[0] == face[1] || face[1] == face[2] || face[2] == face[0];
  });
}

Status read_job(const Document& document, Expected<Mesh> mesh, Job& job, std::string& skipped) {
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

std::vector<bool> used_points(const Mesh& mesh) {
  std::vector<bool> used(mesh.point_count, false);
  for (const auto& face : mesh.faces)
    for (const uint32_t point : face) used[point] = true;
  return used;
}

// Drops the other points, none of which a face uses.
void keep_points(Job& job, const std::vector<bool>& keep) {
  std::vector<uint32_t> kept, number(keep.size(), 0);
  for (uint32_t point = 0; point < keep.size(); ++point) {
    if (!keep[point]) continue;
    number[point] = static_cast<uint32_t>(kept.size());
    kept.push_back(point);
  }
  for (std::vector<Attribute>* attributes : {&job.mesh.attributes, &job.unrounded})
    for (Attribute& attribute : *attributes) {
      const size_t stride = attribute.stride();
      Array<std::byte> values(stride * kept.size());
      for (size_t i = 0; i < kept.size(); ++i)
        std::memcpy(values.data() + i * stride, attribute.values.data() + kept[i] * stride, stride);
      attribute.values = std::move(values);
    }
  for (auto& face : job.mesh.faces)
    for (uint32_t& point : face) point = number[point];
  job.mesh.point_count = static_cast<uint32_t>(kept.size());
  job.morphs = reorder(job.morphs, kept);
}

// Exporters write a surface of several materials as primitives with the same attributes and indices of their
// own. Each is stored with the points that its faces use, and the first of them also with those that no face
// uses. Grids are fitted before, to all of the points: so the borders between the primitives stay closed.
class SharedPoints {
 public:
  void divide(const Document& document, std::vector<Job>& jobs) {
    Job& job = jobs.back();
    const PrimitiveId id = job.group.ids.front();
    const Json& primitive = document.json["meshes"][id.mesh]["primitives"][id.primitive];
    for (const char* name : {kExtensionName, kStockExtensionName})
      if (extension_field(primitive, name) != nullptr) return;
    const Json* targets = field(primitive, "targets");
    const std::string key = primitive["attributes"].dump() + (targets == nullptr ? "" : targets->dump());
    const auto [found, is_first] = sets_.try_emplace(key, Set{jobs.size() - 1, {}});
    if (is_first) return;
    std::vector<bool>& used_by_others = found->second.used_by_others;
    const std::vector<bool> used = used_points(job.mesh);
    used_by_others.resize(used.size(), false);
    for (size_t i = 0; i < used.size(); ++i)
      if (used[i]) used_by_others[i] = true;
    keep_points(job, used);
  }

  void finish(std::vector<Job>& jobs) const {
    for (const auto& [key, set] : sets_) {
      if (set.used_by_others.empty()) continue;
      std::vector<bool> keep = used_points(jobs[set.first].mesh);
      for (size_t i = 0; i < keep.size(); ++i) keep[i] = keep[i] || !set.used_by_others[i];
      keep_points(jobs[set.first], keep);
    }
  }

 private:
  struct Set {
    size_t first = 0;  // of the jobs
    std::vector<bool> used_by_others;
  };
  std::map<std::string, Set> sets_;
};

}  // namespace

Expected<Jobs> read_jobs(const Document& document, const EncodeDocumentOptions& options,
                         const DecodeBackend& backend, const ThreadPool& pool) {
  Jobs result;
  const ExactAttributes exact(document.json);
  SharedPoints shared_points;
  std::vector<PrimitiveId> wanted;
  for (const PrimitiveId id : all_primitives(document)) {
    const Expected<std::string> reason = reason_to_skip(document, id, options);
    if (!reason) return reason.status().at({.file = document.source.string()});
    if (reason->empty())
      wanted.push_back(id);
    else
      result.skipped[{id.mesh, id.primitive}] = *reason;
  }
  std::vector<PrimitiveGroup> groups = group_equal_primitives(document, wanted);
  // What is compressed is decoded at once. All else is read in its turn: primitives may share points, of which
  // each keeps its own before the next is read.
  const auto is_compressed = [&](const PrimitiveGroup& group) {
    return primitive_kind(document, group.ids.front())->storage != PrimitiveStorage::kPlain;
  };
  std::vector<PrimitiveId> compressed;
  for (const PrimitiveGroup& group : groups)
    if (is_compressed(group)) compressed.push_back(group.ids.front());
  std::vector<Expected<Mesh>> decoded = read_primitives(document, compressed, backend, pool);
  auto next_decoded = decoded.begin();
  for (PrimitiveGroup& group : groups) {
    Job job;
    job.group = std::move(group);
    Expected<Mesh> mesh = is_compressed(job.group)
                              ? std::move(*next_decoded++)
                              : read_primitive(document, job.group.ids.front(), backend, pool);
    std::string skipped;
    if (Status status = read_job(document, std::move(mesh), job, skipped); !status.ok())
      return std::move(status).at(job.place(document));
    if (!options.keep_degenerate && skipped.empty() && all_degenerate(job.mesh))
      skipped = "no triangles but degenerate ones";
    if (!skipped.empty()) {
      for (const PrimitiveId id : job.group.ids) result.skipped[{id.mesh, id.primitive}] = skipped;
      continue;
    }
    for (Attribute& attribute : job.mesh.attributes) {
      if (!options.lossless && !exact.contains(attribute.semantic)) trim_noise(attribute);
      job.codings.push_back(coding_of(attribute, exact, options));
    }
    job.options.refine = options.refine;
    job.options.method = options.method;
    job.options.distance = options.distance;
    job.options.encode_speed = options.encode_speed;
    job.options.keep_duplicates = options.keep_duplicates;
    job.options.drop_degenerate = !options.keep_degenerate;
    // A patch of its own has no place for them.
    job.options.drop_unused = !options.keep_unused || options.compat == Compat::kKhr;
    job.options.standalone_residue = options.compat == Compat::kKhr;
    job.options.verify = options.verify;
    result.jobs.push_back(std::move(job));
    shared_points.divide(document, result.jobs);
  }
  shared_points.finish(result.jobs);
  share_grids(result.jobs, options.volume);
  for (Job& job : result.jobs) {
    for (size_t i = 0; i < job.codings.size(); ++i)
      if (job.mesh.attributes[i].semantic.starts_with("WEIGHTS_") && job.codings[i].bits > 0)
        job.unrounded.push_back(job.mesh.attributes[i]);
    round_weights(job.mesh, job.codings);
  }
  return result;
}

uint64_t default_patch_count(uint64_t faces, uint64_t min_faces) {
  constexpr double kPatchFaces = 30000;
  if (faces < min_faces) return 1;
  const double patches = static_cast<double>(faces) / kPatchFaces;
  if (patches < 24)
    return std::clamp<uint64_t>(std::bit_ceil(static_cast<uint64_t>(patches / std::sqrt(2.0)) + 1), 2, 16);
  return 16 * static_cast<uint64_t>(std::lround(patches / 16));
}

void choose_patch_counts(std::vector<Job>& jobs, const EncodeDocumentOptions& options) {
  std::vector<uint64_t> faces;
  for (const Job& job : jobs) faces.push_back(job.mesh.faces.size());
  std::vector<uint32_t> distributed;
  if (options.patches > 0) {
    const uint64_t total = std::accumulate(faces.begin(), faces.end(), uint64_t{0});
    const uint64_t most = std::max<uint64_t>(1, total / std::max<uint64_t>(1, options.least_patch_faces));
    distributed = distribute_patches(faces, std::min(options.patches, most));
  }
  const uint64_t size = options.patch_faces;
  const uint64_t most = options.most_patches > 0         ? options.most_patches
                        : options.compat == Compat::kKhr ? kMostPatchPrimitives
                                                         : UINT64_MAX;
  const auto count_of = [&](size_t i) -> uint64_t {
    if (faces[i] < options.min_faces) return 1;
    if (options.patches > 0) return distributed[i];
    if (size > 0) return std::max<uint64_t>(1, (faces[i] + size / 2) / size);
    return std::min(most, default_patch_count(faces[i], options.min_faces > 0 ? options.min_faces : kMinFaces));
  };
  for (size_t i = 0; i < jobs.size(); ++i) jobs[i].options.patch_count = static_cast<uint32_t>(count_of(i));
}

std::vector<std::byte> distinguishing_bytes(const Job& job, size_t& stride) {
  std::vector<std::pair<const Array<std::byte>*, size_t>> sources;
  for (const MorphAttribute& morph : job.morphs)
    sources.emplace_back(&morph.data.values, morph.data.values.size() / std::max(1u, morph.data.count));
  for (const Attribute& attribute : job.unrounded) sources.emplace_back(&attribute.values, attribute.stride());
  stride = 0;
  for (const auto& [values, width] : sources) stride += width;
  std::vector<std::byte> bytes(stride * job.mesh.point_count);
  size_t offset = 0;
  for (const auto& [values, width] : sources) {
    for (size_t i = 0; i < job.mesh.point_count; ++i)
      std::memcpy(bytes.data() + i * stride + offset, values->data() + i * width, width);
    offset += width;
  }
  return bytes;
}

std::vector<MorphAttribute> reorder(const std::vector<MorphAttribute>& morphs,
                                    const std::vector<uint32_t>& source_point) {
  std::vector<MorphAttribute> ordered;
  for (const MorphAttribute& morph : morphs) {
    MorphAttribute& copy = ordered.emplace_back(MorphAttribute{morph.target, morph.semantic, {}, morph.sparse});
    copy.data = {morph.data.component_type,
                 morph.data.component_count,
                 morph.data.normalized,
                 static_cast<uint32_t>(source_point.size()),
                 {}};
    const size_t width = component_bytes(morph.data.component_type) * morph.data.component_count;
    copy.data.values.resize(width * source_point.size());
    for (size_t i = 0; i < source_point.size(); ++i)
      std::memcpy(copy.data.values.data() + i * width, morph.data.values.data() + source_point[i] * width,
                  width);
  }
  return ordered;
}

}  // namespace psplit
