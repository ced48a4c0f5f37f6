#include "gltf_ext/convert/patch_primitives.h"

#include <cstring>

#include "encoder/stitching/number_points.h"

namespace psplit {
namespace {

// Whether the stream equals its part of the stitched mesh: the faces from `face_base` on, and the values of its
// points.
bool is_part_of(const Mesh& part, std::span<const Face> faces, const std::vector<uint32_t>& numbers,
                const Mesh& whole, size_t face_base) {
  for (size_t i = 0; i < faces.size(); ++i)
    for (size_t c = 0; c < 3; ++c)
      if (numbers[faces[i][c]] != whole.faces[face_base + i][c]) return false;
  for (const Attribute& attribute : part.attributes) {
    const Attribute* stitched = whole.find(attribute.semantic);
    if (stitched == nullptr || stitched->stride() != attribute.stride()) return false;
    const size_t stride = attribute.stride();
    for (size_t point = 0; point < part.point_count; ++point)
      if (std::memcmp(attribute.values.data() + point * stride,
                      stitched->values.data() + numbers[point] * stride, stride) != 0)
        return false;
  }
  return true;
}

}  // namespace

Expected<std::vector<PatchPrimitive>> patch_primitives(const EncodedMesh& encoded, const DecodeBackend& backend,
                                                       const ThreadPool& pool) {
  const PatchContainer& container = *encoded.opened;
  std::vector<PatchContainer> alone;
  for (uint32_t i = 0; i < container.entries.size(); ++i) alone.push_back(container.alone(i));
  std::vector<DecodeTask> tasks;
  for (const PatchContainer& patch : alone) tasks.push_back({&patch, encoded.requests});
  std::vector<Expected<Mesh>> meshes = backend.decode(tasks, pool, {});
  std::vector<std::span<const Face>> faces;
  for (size_t i = 0; i < meshes.size(); ++i) {
    const Place place{.patch = static_cast<int64_t>(i)};
    if (!meshes[i]) return meshes[i].status().at(place);
    if (meshes[i]->faces.size() < container.entries[i].face_count ||
        meshes[i]->point_count != container.entries[i].point_count)
      return runtime_failure("verification: the counts of a stream differ from its row", place);
    faces.push_back(std::span<const Face>(meshes[i]->faces).first(container.entries[i].face_count));
  }
  const auto numbers = number_points(container, faces, pool);
  if (!numbers) return numbers.status();

  std::vector<PatchPrimitive> patches(meshes.size());
  std::vector<Status> statuses(meshes.size());
  pool.for_each(meshes.size(), [&](size_t i) {
    if (encoded.decoded &&
        !is_part_of(*meshes[i], faces[i], (*numbers)[i], *encoded.decoded, container.face_base[i]))
      statuses[i] = runtime_failure("verification: a stream differs from its part of the mesh",
                                    {.patch = static_cast<int64_t>(i)});
    patches[i].stream = container.streams[i];
    for (const uint32_t number : (*numbers)[i]) patches[i].source_point.push_back(encoded.source_point[number]);
  });
  for (size_t i = 0; i < meshes.size(); ++i) {
    if (!statuses[i].ok()) return statuses[i];
    patches[i].mesh = std::move(*meshes[i]);
  }
  return patches;
}

std::vector<std::vector<PrimitiveGroup>> repeat_primitives(Document& document,
                                                           std::span<const PrimitiveGroup> groups,
                                                           std::span<const size_t> counts) {
  std::map<std::pair<size_t, size_t>, size_t> group_of;
  std::vector<std::vector<PrimitiveGroup>> repeated(groups.size());
  for (size_t i = 0; i < groups.size(); ++i) {
    repeated[i].resize(counts[i]);
    for (const PrimitiveId id : groups[i].ids) group_of[{id.mesh, id.primitive}] = i;
  }
  if (groups.empty()) return repeated;
  Json& meshes = document.json["meshes"];
  for (size_t m = 0; m < meshes.size(); ++m) {
    Json& primitives = meshes[m]["primitives"];
    Json all = Json::array();
    for (size_t p = 0; p < primitives.size(); ++p) {
      const auto found = group_of.find({m, p});
      if (found == group_of.end()) {
        all.push_back(std::move(primitives[p]));
        continue;
      }
      for (PrimitiveGroup& group : repeated[found->second]) {
        group.ids.push_back({m, all.size()});
        all.push_back(primitives[p]);
      }
    }
    primitives = std::move(all);
  }
  return repeated;
}

}  // namespace psplit
