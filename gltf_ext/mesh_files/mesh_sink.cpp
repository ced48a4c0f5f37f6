#include "gltf_ext/mesh_files/mesh_sink.h"

#include <cstring>

namespace psplit {

Status MeshBuilder::begin(std::span<const Attribute> layout, size_t expected_points) {
  mesh_.attributes.assign(layout.begin(), layout.end());
  for (Attribute& attribute : mesh_.attributes) attribute.values.reserve(expected_points * attribute.stride());
  return {};
}

Status MeshBuilder::add_points(std::span<const Attribute> block, size_t count) {
  mesh_.point_count += static_cast<uint32_t>(count);
  for (size_t i = 0; i < block.size(); ++i)
    mesh_.attributes[i].values.insert(mesh_.attributes[i].values.end(), block[i].values.begin(),
                                      block[i].values.end());
  return {};
}

Status MeshBuilder::add_faces(std::span<const std::array<uint32_t, 3>> faces) {
  mesh_.faces.insert(mesh_.faces.end(), faces.begin(), faces.end());
  return {};
}

Expected<Position> MeshBuilder::position(uint32_t point) {
  Position position;
  std::memcpy(position.data(), mesh_.attributes[0].values.data() + point * sizeof(position), sizeof(position));
  return position;
}

}  // namespace psplit
