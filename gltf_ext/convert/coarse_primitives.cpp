#include "gltf_ext/convert/coarse_primitives.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <utility>

#include "gltf_ext/convert/encode_job.h"
#include "gltf_ext/convert/read_jobs.h"
#include "gltf_ext/convert/simplify.h"
#include "gltf_ext/document/drop_unused.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/primitive/primitive_edit.h"
#include "src/mesh/select_points.h"

namespace psplit {
namespace {

// The coarse form of one primitive. Without faces, it is too small to be seen.
struct CoarsePrimitive {
  Mesh mesh;
  std::vector<MorphAttribute> morphs;
};

// The points of a mesh that some of its faces use, in their order, and these faces.
CoarsePrimitive gather(const Mesh& mesh, const std::vector<MorphAttribute>& morphs, Faces faces) {
  std::vector<uint32_t> source_point;
  std::vector<uint8_t> is_known(mesh.point_count, 0);
  for (const auto& face : faces)
    for (const uint32_t point : face)
      if (std::exchange(is_known[point], uint8_t{1}) == 0) source_point.push_back(point);
  return {select_points(mesh, source_point, std::move(faces)), reorder(morphs, source_point)};
}

// Meshes whose compressed primitives have equal geometry.
struct EqualMeshes {
  std::vector<std::vector<PrimitiveId>> primitives;  // the compressed ones of each mesh
  std::vector<CoarsePrimitive> coarse;               // of the primitives of one of them
};

Expected<std::vector<CoarsePrimitive>> simplify_primitives(const Document& document,
                                                           std::span<const PrimitiveId> ids,
                                                           std::vector<Mesh> meshes, double share) {
  uint64_t faces = 0, points = 0;
  for (const Mesh& mesh : meshes) {
    faces += mesh.faces.size();
    points += mesh.point_count;
  }
  if (points > UINT32_MAX) return unsupported("has more points than can be simplified");
  const auto wanted = static_cast<uint64_t>(std::llround(share * static_cast<double>(faces)));
  std::vector<Faces> kept(meshes.size());
  if (faces > 0) {
    const uint64_t target = std::max({wanted, std::min(kLeastCoarseFaces, faces / 10), uint64_t{1}});
    auto simplified = simplify(meshes, target);
    if (!simplified) return simplified.status();
    kept = std::move(*simplified);
  }
  std::vector<CoarsePrimitive> coarse;
  for (size_t i = 0; i < ids.size(); ++i) {
    const auto morphs = read_morph_targets(document, ids[i], meshes[i].point_count);
    if (!morphs) return morphs.status();
    coarse.push_back(gather(meshes[i], *morphs, std::move(kept[i])));
    meshes[i] = {};
  }
  return coarse;
}

Expected<std::vector<EqualMeshes>> make_coarse(const Document& document, double share,
                                               const DecodeBackend& backend, const ThreadPool& pool) {
  std::vector<PrimitiveId> compressed;
  for (const PrimitiveId id : all_primitives(document))
    if (document.records().primitive(id).storage() != PrimitiveStorage::kPlain) compressed.push_back(id);
  std::map<PrimitiveId, size_t> group_of;
  const std::vector<PrimitiveGroup> groups = group_equal_primitives(document, compressed);
  for (size_t g = 0; g < groups.size(); ++g)
    for (const PrimitiveId id : groups[g].ids) group_of[id] = g;
  std::map<std::vector<size_t>, std::vector<std::vector<PrimitiveId>>> equal;
  for (size_t i = 0; i < compressed.size();) {
    std::vector<PrimitiveId> ids;
    std::vector<size_t> key;
    for (; i < compressed.size() && (ids.empty() || ids.front().mesh == compressed[i].mesh); ++i) {
      ids.push_back(compressed[i]);
      key.push_back(group_of.at(compressed[i]));
    }
    // Loaders that know Draco show a mesh without patches as it is.
    if (std::ranges::none_of(ids, [&](PrimitiveId id) {
          return document.records().primitive(id).storage() == PrimitiveStorage::kPatches;
        }))
      continue;
    equal[key].push_back(std::move(ids));
  }
  std::vector<EqualMeshes> result;
  for (auto& [key, primitives] : equal) {
    // One mesh is in memory at a time.
    std::vector<Mesh> meshes;
    std::vector<Expected<Mesh>> read = read_primitives(document, primitives.front(), backend, pool);
    for (size_t k = read.size(); k-- > 0;) {
      if (read[k].status().code() == StatusCode::kUnsupported)
        for (std::vector<PrimitiveId>& of_mesh : primitives)
          of_mesh.erase(of_mesh.begin() + static_cast<std::ptrdiff_t>(k));
      else if (!read[k])
        return read[k].status();
    }
    for (Expected<Mesh>& mesh : read)
      if (mesh) meshes.push_back(std::move(*mesh));
    read.clear();
    if (std::ranges::all_of(meshes, [](const Mesh& mesh) { return mesh.faces.empty(); })) continue;
    auto coarse = simplify_primitives(document, primitives.front(), std::move(meshes), share);
    if (!coarse) return coarse.status().at(place_of(document, primitives.front().front()));
    result.push_back({std::move(primitives), std::move(*coarse)});
  }
  return result;
}

// Copies the primitives of a mesh to its other list, and removes from the first the members that coarse
// primitives cannot have, so that the lists are as in a file.
void double_list(Document& document, std::span<const PrimitiveId> ids) {
  Json& mesh = document.json()["meshes"][ids.front().mesh];
  const Json fine = mesh["primitives"];
  for (const PrimitiveId id : ids) {
    Json& primitive = mesh["primitives"][id.primitive];
    Json& extensions = primitive["extensions"];
    for (const char* name : {kExtensionName, kStockExtensionName}) extensions.erase(name);
    while (const char* name = order_dependent_extension(primitive)) extensions.erase(name);
    if (extensions.empty()) primitive.erase("extensions");
  }
  mesh["extensions"][kExtensionName]["primitives"] = fine;
}

// Removes the primitives that became too small from the first list of their mesh.
void remove_empty(Document& document, const EqualMeshes& equal) {
  for (const std::vector<PrimitiveId>& ids : equal.primitives) {
    Json& primitives = document.json()["meshes"][ids.front().mesh]["primitives"];
    Json kept = Json::array();
    for (size_t p = 0, k = 0; p < primitives.size(); ++p) {
      const bool is_coarse = k < ids.size() && ids[k].primitive == p;
      if (is_coarse && equal.coarse[k++].mesh.faces.empty()) continue;
      kept.push_back(std::move(primitives[p]));
    }
    primitives = std::move(kept);
  }
}

// A loader that knows patches takes the fine primitives, and needs Draco if some of them are stock Draco.
void require_extensions(Document& document) {
  std::vector<PrimitiveId> patched;
  bool needs_draco = false;
  for (const PrimitiveId id : all_primitives(document)) {
    const PrimitiveRecord& primitive = document.records().primitive(id);
    if (primitive.patches) patched.push_back(id);
    needs_draco |= primitive.stock && !document.records().has_plain_data(primitive);
  }
  require_extension(document, kExtensionName, !all_have_fallbacks(document, patched));
  require_extension(document, kStockExtensionName, needs_draco);
}

}  // namespace

Status add_coarse_primitives(Document& document, double share, const DecodeBackend& backend,
                             const ThreadPool& pool) {
  drop_coarse_primitives(document);
  const auto meshes = make_coarse(document, share, backend, pool);
  if (!meshes) return meshes.status();
  if (meshes->empty()) return {};
  for (const EqualMeshes& equal : *meshes)
    for (const std::vector<PrimitiveId>& ids : equal.primitives) double_list(document, ids);
  PrimitiveEditor editor(document);
  for (const EqualMeshes& equal : *meshes)
    for (size_t k = 0; k < equal.coarse.size(); ++k) {
      PrimitiveGroup group;
      for (const std::vector<PrimitiveId>& ids : equal.primitives) group.ids.push_back(ids[k]);
      const auto& [mesh, morphs] = equal.coarse[k];
      if (!mesh.faces.empty()) editor.set_geometry(group, mesh, morphs, GeometryData::kInBufferViews);
    }
  for (const EqualMeshes& equal : *meshes) remove_empty(document, equal);
  editor.finish();
  if (Status status = exchange_primitives(document.json()); !status.ok()) return status;
  list_extension(document, kExtensionName, false);
  require_extensions(document);
  return {};
}

std::vector<int64_t> take_coarse_primitives(Document& document) {
  std::vector<int64_t> freed;
  for_each_coarse_reference(document.json(),
                            [&](const Json& index) { freed.push_back(integer_value(index).value_or(-1)); });
  for_each_element(document.json(), "meshes", [](Json& mesh) {
    if (other_primitives(mesh) == nullptr) return;
    mesh["extensions"].erase(kExtensionName);
    if (mesh["extensions"].empty()) mesh.erase("extensions");
  });
  return freed;
}

void drop_coarse_primitives(Document& document) {
  const std::vector<int64_t> freed = take_coarse_primitives(document);
  if (freed.empty()) return;
  drop_unused(document, freed);
  unlist_unused_extension(document, kExtensionName);
  require_extensions(document);
}

CoarseCounts coarse_counts(const Document& document) {
  const AssetRecords& records = document.records();
  const Json& json = document.json();
  std::map<int64_t, size_t> uses, own_uses;
  const auto count_in = [](std::map<int64_t, size_t>& counts) {
    return [&counts](const Json& index) { ++counts[integer_value(index).value_or(-1)]; };
  };
  for_each_accessor_reference(json, count_in(uses));
  for_each_coarse_reference(json, count_in(own_uses));
  CoarseCounts counts;
  for (const auto& [index, count] : own_uses)
    if (uses[index] == count) counts.bytes += records.accessor(index).stored_bytes();
  std::set<std::pair<int64_t, int64_t>> seen;
  for_each_element(json, "meshes", [&](const Json& mesh) {
    const Json* coarse = other_primitives(mesh);
    for (size_t i = 0; coarse != nullptr && i < coarse->size(); ++i) {
      const Json& primitive = (*coarse)[i];
      const int64_t position = integer_field(primitive["attributes"], "POSITION").value_or(-1);
      const int64_t indices = integer_field(primitive, "indices").value_or(-1);
      ++counts.primitives;
      if (position < 0 || !seen.emplace(position, indices).second) continue;
      const uint64_t points = records.accessor(position).count;
      counts.points += points;
      counts.faces += (indices < 0 ? points : records.accessor(indices).count) / 3;
    }
  });
  return counts;
}

}  // namespace psplit
