// Built-in sample meshes: irregular isosurfaces, generated from a seed, that a mesh codec compresses like
// scans.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "psplit/base.h"
#include "psplit/mesh.h"
#include "psplit/parallel.h"

namespace psplit {

enum class Shape {
  kTerrain,  // an open sheet with hills and overhangs
  kBlob,     // a closed, bumpy ball
  kGyroid,   // a closed solid of high genus: a gyroid cut by a ball
  kScene,    // six objects of different shapes and sizes, terrain first
};

struct ShapeOptions {
  Shape shape = Shape::kTerrain;
  uint64_t faces = 0;  // of all meshes together; from some thousand faces per mesh, the result is within 2 %
  uint64_t seed = 0;
  bool normals = false;    // NORMAL, from the gradient of the field
  bool texcoords = false;  // TEXCOORD_0 in several charts, so that points on chart borders are duplicated
};

// Makes one mesh, or six for kScene. The bytes depend only on the options, not on threads, compiler or machine.
// Meshes are manifold and consistently oriented; no two points are equal, and no face is degenerate. Memory is
// proportional to the output, plus two grid layers per thread. Errors: kUsage (faces out of range).
Expected<std::vector<Mesh>> generate_shape(const ShapeOptions& options, const ThreadPool& pool);

// Part of a mesh, whose points and faces follow earlier parts'. A face may refer to the first points of
// the next part.
struct ShapePiece {
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<float, 3>> normals;  // empty without ShapeOptions::normals
  Array<std::array<uint32_t, 3>> faces;
};

// The mesh of generate_shape, computed piece by piece, for meshes that are larger than memory. Opening computes
// the mesh once to count its parts. So the counts are known before the first piece.
class ShapeStream {
 public:
  // Errors: kUsage for faces out of range, texture coordinates (charts need the whole mesh), and the scene,
  // which has several meshes.
  static Expected<ShapeStream> open(const ShapeOptions& options, const ThreadPool& pool);
  ShapeStream(ShapeStream&&) noexcept;
  ~ShapeStream();

  uint64_t point_count() const { return point_count_; }
  uint64_t face_count() const { return face_count_; }
  // Hands over the pieces in order. `take` is called by the calling thread; its error ends the work and is
  // returned. Memory: some pieces for each thread; a piece of a mesh of F faces has about 16 * sqrt(F) faces to
  // 100 * sqrt(F) faces.
  Status read(const ThreadPool& pool, const std::function<Status(ShapePiece&&)>& take) const;

 private:
  ShapeStream() = default;
  std::unique_ptr<class Field> field_;
  ShapeOptions options_;
  double cell_ = 0;
  uint64_t point_count_ = 0, face_count_ = 0;
};

}  // namespace psplit
