// Receives the points and faces of a mesh file while it is read.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "gltf_ext/mesh_files/triangulate.h"
#include "src/mesh/mesh.h"
#include "src/status.h"

namespace psplit {

// The reader stops at the first error that a call returns. Not thread-safe.
class MeshSink {
 public:
  virtual ~MeshSink() = default;

  // Comes first. `layout` has the attributes without values; POSITION is the first, and holds floats.
  // `expected_points` is a number of points that the size of the file justifies memory for.
  virtual Status begin(std::span<const Attribute> layout, size_t expected_points) = 0;
  // The next `count` points: the attributes of `layout` with the values of these points.
  virtual Status add_points(std::span<const Attribute> block, size_t count) = 0;
  // A number of faces that the size of the file justifies memory for.
  virtual void expect_faces(size_t count) = 0;
  // Faces of points that were added before.
  virtual Status add_faces(std::span<const std::array<uint32_t, 3>> faces) = 0;
  // The position of a point that was added before.
  virtual Expected<Position> position(uint32_t point) = 0;
};

// A mesh in memory.
class MeshBuilder : public MeshSink {
 public:
  Status begin(std::span<const Attribute> layout, size_t expected_points) override;
  Status add_points(std::span<const Attribute> block, size_t count) override;
  void expect_faces(size_t count) override { mesh_.faces.reserve(mesh_.faces.size() + count); }
  Status add_faces(std::span<const std::array<uint32_t, 3>> faces) override;
  Expected<Position> position(uint32_t point) override;

  Mesh take() { return std::move(mesh_); }

 private:
  Mesh mesh_;
};

}  // namespace psplit
