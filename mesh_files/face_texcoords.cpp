#include "mesh_files/face_texcoords.h"

#include <algorithm>
#include <cstring>
#include <tuple>

#include "src/mesh/select_points.h"

namespace psplit {
namespace {

struct CornerPoint {
  uint32_t point;
  std::array<uint32_t, 2> texcoord;  // its bits
  size_t corner;                     // of the part's faces
  auto key() const { return std::tie(point, texcoord); }
};

// The faces with these numbers, with points of their own in the order of the file.
MeshFilePart part_of_faces(const MeshFilePart& whole, const FaceTexcoords& texcoords,
                           const std::vector<size_t>& faces, bool has_texcoords) {
  const Mesh& mesh = whole.mesh;
  std::vector<CornerPoint> corners;
  corners.reserve(3 * faces.size());
  for (const size_t face : faces)
    for (size_t i = 0; i < 3; ++i) {
      CornerPoint corner{mesh.faces[face][i], {}, corners.size()};
      std::memcpy(corner.texcoord.data(), &texcoords.corners[face][2 * i], sizeof corner.texcoord);
      corners.push_back(corner);
    }
  // Sorting takes the same time for every file; a hash table would not.
  std::sort(corners.begin(), corners.end(),
            [](const CornerPoint& a, const CornerPoint& b) { return a.key() < b.key(); });
  MeshFilePart result;
  Mesh& part = result.mesh;
  part.faces.resize(faces.size());
  std::vector<uint32_t> points;
  Attribute coordinates{"TEXCOORD_0", ComponentType::kFloat32, 2, false, {}};
  for (size_t i = 0; i < corners.size(); ++i) {
    if (i == 0 || corners[i].key() != corners[i - 1].key()) {
      points.push_back(corners[i].point);
      const auto* const bytes = reinterpret_cast<const std::byte*>(corners[i].texcoord.data());
      coordinates.values.insert(coordinates.values.end(), bytes, bytes + coordinates.stride());
    }
    part.faces[corners[i].corner / 3][corners[i].corner % 3] = static_cast<uint32_t>(points.size() - 1);
  }
  part.point_count = static_cast<uint32_t>(points.size());
  for (const Attribute& attribute : mesh.attributes)
    if (attribute.semantic == "POSITION" && !whole.positions.empty())
      part.attributes.push_back(attribute);
    else if (attribute.semantic != "TEXCOORD_0")
      part.attributes.push_back(select_points(attribute, points));
  if (!whole.positions.empty())
    for (const uint32_t point : points) result.positions.push_back(whole.positions[point]);
  if (has_texcoords) part.attributes.push_back(std::move(coordinates));
  return result;
}

}  // namespace

std::vector<MeshFilePart> parts_with_texcoords(MeshFilePart whole, const FaceTexcoords& texcoords,
                                               std::span<const int64_t> materials, Losses& losses) {
  const Mesh& mesh = whole.mesh;
  if (mesh.find("TEXCOORD_0") != nullptr)
    losses.say("texture coordinates of vertices are left out: faces have others");
  std::map<int32_t, std::vector<size_t>> faces_of_texture;
  for (size_t face = 0; face < mesh.faces.size(); ++face) {
    const int32_t texture = texcoords.textures[face];
    const bool exists = texture < static_cast<int64_t>(materials.size());
    faces_of_texture[exists ? texture : FaceTexcoords::kNoTexture].push_back(face);
  }
  losses.add("vertex without a face is left out", "vertices without a face are left out",
             static_cast<uint64_t>(std::ranges::count(used_points(mesh), uint8_t{0})));
  std::vector<MeshFilePart> parts;
  for (const auto& [texture, faces] : faces_of_texture) {
    parts.push_back(part_of_faces(whole, texcoords, faces, texture != FaceTexcoords::kNone));
    parts.back().material = texture < 0 ? -1 : materials[static_cast<size_t>(texture)];
  }
  return parts;
}

}  // namespace psplit
