// Random meshes that break every assumption: flat and repeated faces, edges of three faces, folds, vertices of
// several fans, handles, holes, points without faces, values that are equal at other vertices.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "encoder/stream/patch_mesh.h"
#include "encoder/welding/weld.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {

// A mesh, which of its values are equal, and all of it as a patch.
struct Soup {
  Mesh mesh;
  WeldedMesh welded;
  PatchMesh patch;

  Soup() = default;
  Soup(const Soup&) = delete;
  Soup& operator=(const Soup&) = delete;
};

class SoupMaker {
 public:
  explicit SoupMaker(uint64_t seed) : random_(seed) {}

  // Makes at most about `size` faces. Every attribute has one byte, because values do not matter.
  void make(uint32_t size, Soup& soup) {
    mesh_ = &soup.mesh;
    if (below(3) == 0)
      scatter_faces(size);
    else
      roll_up_grid(size);
    for (uint32_t k = below(4); k > 0; --k) change_some_faces();
    const uint32_t attribute_count = below(4);
    weld(soup, attribute_count);
    soup.patch = whole_mesh(soup.mesh);
  }

 private:
  uint32_t below(uint32_t n) { return static_cast<uint32_t>(random_() % n); }

  void scatter_faces(uint32_t size) {
    const uint32_t faces = 1 + below(size);
    mesh_->point_count = 3 + below(1 + faces);
    for (uint32_t i = 0; i < faces; ++i) {
      std::array<uint32_t, 3> face{};
      for (uint32_t& point : face) point = below(mesh_->point_count);
      mesh_->faces.push_back(face);
    }
  }

  // A grid whose sides may be joined: to a tube, a torus, a Klein bottle.
  void roll_up_grid(uint32_t size) {
    const auto side = static_cast<uint32_t>(2 + std::sqrt(size / 2));
    const uint32_t columns = 1 + below(side), rows = 1 + below(side);
    *mesh_ = make_grid(columns, rows);
    mesh_->attributes.clear();
    std::vector<uint32_t> joined(mesh_->point_count);
    for (uint32_t point = 0; point < mesh_->point_count; ++point) joined[point] = point;
    const bool turned = below(4) == 0, around = below(2) == 0, along = below(2) == 0;
    if (around)
      for (uint32_t row = 0; row <= rows; ++row) joined[row * (columns + 1) + columns] = row * (columns + 1);
    if (along)
      for (uint32_t column = 0; column <= columns; ++column)
        joined[rows * (columns + 1) + column] = joined[turned ? columns - column : column];
    for (auto& face : mesh_->faces)
      for (uint32_t& point : face) point = joined[joined[point]];
    if (below(2) == 0) std::shuffle(mesh_->faces.begin(), mesh_->faces.end(), random_);
  }

  void change_some_faces() {
    const uint32_t kind = below(6), often = 1 + below(30);
    Faces& faces = mesh_->faces;
    for (size_t i = 0, count = faces.size(); i < count; ++i) {
      if (below(often) != 0) continue;
      std::array<uint32_t, 3> face = faces[i];
      if (kind == 0) std::swap(faces[i][1], faces[i][2]);
      if (kind == 1) faces[i] = faces[below(static_cast<uint32_t>(count))];
      if (kind == 2) faces[i][below(3)] = below(mesh_->point_count);
      if (kind == 3) faces.push_back(face);
      if (kind == 4) std::swap(face[0], face[2]), faces.push_back(face);
      if (kind == 5) std::rotate(faces[i].begin(), faces[i].begin() + 1, faces[i].end());
    }
    if (kind == 2 && below(2) == 0) faces.resize(1 + below(static_cast<uint32_t>(faces.size())));
  }

  // Splits some points of faces in two, which may have different values of some attributes.
  void weld(Soup& soup, uint32_t attribute_count) {
    Mesh& mesh = soup.mesh;
    std::vector<uint32_t> position(mesh.point_count);
    const uint32_t merged = below(2) == 0 ? 0 : 1 + below(40), split = below(2) == 0 ? 0 : 1 + below(40);
    for (uint32_t point = 0; point < mesh.point_count; ++point)
      position[point] = merged != 0 && point > 0 && below(merged) == 0 ? position[below(point)] : point;
    for (auto& face : mesh.faces)
      for (uint32_t& point : face)
        if (split != 0 && below(split) == 0) {
          position.push_back(position[point]);
          point = mesh.point_count++;
        }
    soup.welded.mesh = &mesh;
    soup.welded.value_of_point = {position};
    for (uint32_t k = 0; k < attribute_count; ++k) {
      const uint32_t kind = below(3), often = 1 + below(50);
      std::vector<uint32_t> value(mesh.point_count);
      for (uint32_t point = 0; point < mesh.point_count; ++point) {
        value[point] = kind == 0 ? point : position[point];
        if (kind == 2 && below(often) == 0) value[point] = below(mesh.point_count);
      }
      soup.welded.value_of_point.push_back(value);
    }
    for (uint32_t k = 0; k <= attribute_count; ++k)
      mesh.attributes.push_back(make_attribute(k == 0 ? "POSITION" : "_VALUE_" + std::to_string(k),
                                               ComponentType::kUint8, 1, false,
                                               std::vector<uint8_t>(mesh.point_count)));
  }

  std::mt19937_64 random_;
  Mesh* mesh_ = nullptr;
};

}  // namespace psplit
