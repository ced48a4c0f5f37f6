#include "encoder/cut_faces.h"

#include <algorithm>
#include <array>

#include "encoder/welding/reduce.h"

namespace psplit {
namespace {

constexpr uint32_t kNone = 0xffffffffu;

}  // namespace

Cut cut_faces(const WeldedMesh& welded, const PartitionOptions& options,
              std::span<const uint32_t> patch_of_face, const ThreadPool& pool) {
  const Mesh& mesh = *welded.mesh;
  size_t position = 0;
  while (mesh.attributes[position].semantic != "POSITION") ++position;
  const std::vector<uint32_t>& vertex = welded.value_of_point[position];
  std::vector<uint32_t> number(mesh.point_count, kNone);
  uint32_t vertex_count = 0;
  Cut cut;
  std::vector<uint32_t> regular;
  std::vector<std::array<uint32_t, 3>> vertices;
  for (uint32_t i = 0; i < mesh.faces.size(); ++i) {
    std::array<uint32_t, 3> face{};
    for (size_t c = 0; c < 3; ++c) face[c] = vertex[mesh.faces[i][c]];
    if (repeats_a_point(face)) {  // only if it repeats a point (separate_flat_faces)
      cut.residue_faces.push_back(i);
      continue;
    }
    for (uint32_t& v : face) {
      if (number[v] == kNone) number[v] = vertex_count++;
      v = number[v];
    }
    regular.push_back(i);
    vertices.push_back(face);
  }
  if (vertices.empty()) return cut;
  Partition partition;
  if (patch_of_face.empty()) {
    partition = partition_faces(vertices, vertex_count, options, pool);
  } else {
    for (const uint32_t face : regular) partition.patch_of_face.push_back(patch_of_face[face]);
    partition.patch_count =
        *std::max_element(partition.patch_of_face.begin(), partition.patch_of_face.end()) + 1;
  }
  cut.patches.resize(partition.patch_count);
  for (size_t i = 0; i < regular.size(); ++i) cut.patches[partition.patch_of_face[i]].push_back(regular[i]);
  std::erase_if(cut.patches, [](const std::vector<uint32_t>& faces) { return faces.empty(); });
  return cut;
}

PatchMesh extract(const Mesh& mesh, std::span<const uint32_t> faces) {
  PatchMesh patch;
  patch.faces.reserve(faces.size());
  patch.points.reserve(faces.size() * 3);
  for (uint32_t face : faces)
    for (uint32_t point : mesh.faces[face]) patch.points.push_back(point);
  std::sort(patch.points.begin(), patch.points.end());
  patch.points.erase(std::unique(patch.points.begin(), patch.points.end()), patch.points.end());
  const auto local = [&](uint32_t point) {
    return static_cast<uint32_t>(std::lower_bound(patch.points.begin(), patch.points.end(), point) -
                                 patch.points.begin());
  };
  for (uint32_t face : faces) {
    const auto& points = mesh.faces[face];
    patch.faces.push_back({local(points[0]), local(points[1]), local(points[2])});
  }
  return patch;
}

Residue extract_residue(const Mesh& mesh, std::span<const uint32_t> residue_faces,
                        std::span<const uint8_t> is_in_patch, bool standalone) {
  Residue residue;
  residue.patch = extract(mesh, residue_faces);
  residue.face_count = static_cast<uint32_t>(residue_faces.size());
  std::vector<uint8_t> is_used(is_in_patch.begin(), is_in_patch.end());
  for (const uint32_t point : residue.patch.points) {
    residue.owned_count += is_in_patch[point] == 0 ? 1 : 0;
    is_used[point] = 1;
  }
  for (uint32_t point = 0; point < mesh.point_count; ++point) {
    if (is_used[point] != 0) continue;
    ++residue.owned_count;
    residue.patch.points.push_back(point);
  }
  while (residue.patch.faces.size() * 3 < residue.patch.points.size()) residue.patch.faces.push_back({0, 0, 0});
  if (standalone) return residue;
  // Decoders take a copy's values from its owner, so any value may be stored here. The one before costs least.
  for (const uint32_t point : residue.patch.points)
    residue.patch.value_points.push_back(is_in_patch[point] == 0 ? point
                                         : residue.patch.value_points.empty()
                                             ? residue.patch.points.front()
                                             : residue.patch.value_points.back());
  return residue;
}

}  // namespace psplit
