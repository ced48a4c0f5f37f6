#include "tests/support/mesh_in_parts.h"

#include <algorithm>

#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

constexpr uint32_t kNone = 0xffffffffu;

}  // namespace

MeshInParts::MeshInParts(const Mesh& mesh, std::span<const uint32_t> part_of_face) {
  for (uint32_t face = 0; face < mesh.faces.size(); ++face) {
    const uint32_t part = part_of_face[face];
    if (part >= faces_.size()) faces_.resize(part + 1);
    faces_[part].push_back(face);
  }
  std::erase_if(faces_, [](const std::vector<uint32_t>& faces) { return faces.empty(); });
  // For each point, the last part that uses it; then the number of points that several parts use.
  std::vector<uint32_t> user(mesh.point_count, kNone), shared(mesh.point_count, kNone);
  for (uint32_t part = 0; part < faces_.size(); ++part)
    for (const uint32_t face : faces_[part])
      for (const uint32_t point : mesh.faces[face]) {
        if (user[point] != kNone && user[point] != part && shared[point] == kNone)
          shared[point] = shared_count_++;
        user[point] = part;
      }
  std::vector<uint32_t> number(mesh.point_count);
  for (const std::vector<uint32_t>& faces : faces_) {
    MeshPart& part = parts_.emplace_back();
    std::vector<uint32_t> points;
    for (const uint32_t face : faces)
      points.insert(points.end(), mesh.faces[face].begin(), mesh.faces[face].end());
    std::sort(points.begin(), points.end());
    points.erase(std::unique(points.begin(), points.end()), points.end());
    part.mesh = take_points(mesh, points);
    for (uint32_t i = 0; i < points.size(); ++i) {
      const uint32_t point = points[i];
      number[point] = i;
      if (shared[point] == kNone) continue;
      part.shared_points.push_back(number[point]);
      part.shared_numbers.push_back(shared[point]);
    }
    for (const uint32_t face : faces) {
      const auto& [a, b, c] = mesh.faces[face];
      part.mesh.faces.push_back({number[a], number[b], number[c]});
    }
  }
}

std::vector<uint8_t> read_all(StoredBytes& bytes) {
  std::vector<uint8_t> all(static_cast<size_t>(bytes.size()));
  if (!bytes.read(0, all).ok()) all.clear();
  return all;
}

}  // namespace psplit
