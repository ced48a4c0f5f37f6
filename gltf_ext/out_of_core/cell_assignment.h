// Which cell each point and each face of a mesh belongs to.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "gltf_ext/out_of_core/cell_tree.h"
#include "gltf_ext/out_of_core/large_mesh.h"
#include "psplit/base.h"
#include "psplit/parallel.h"

namespace psplit {

// The memory that a part takes while it is encoded: `face` bytes for each face and `point` for each point.
struct PartCost {
  uint64_t face = 0, point = 0;
  uint64_t most = 0;  // of a part
  uint64_t of(uint64_t faces, uint64_t points) const { return face * faces + point * points; }
};

// A point belongs to a cell by its position. A face belongs to the cell of most of its points, or to the lowest
// of three.
class CellAssignment {
 public:
  // Divides space until each cell costs at most cost.most. `mesh` must outlive the object. Takes two bytes for
  // each point, except for a soup.
  static Expected<CellAssignment> make(const LargeMesh& mesh, const PartCost& cost, const ThreadPool& pool);

  struct Counts {
    uint64_t points = 0, faces = 0;
    uint64_t foreign_corners = 0;  // of its faces: their points belong to other cells
    uint64_t requests = 0;         // corners of faces of other cells that are its points
  };
  const std::vector<Counts>& counts() const { return counts_; }

  using Cell = uint16_t;
  // Consecutive points with their records and cells.
  using VisitPoints =
      std::function<Status(uint64_t first, std::span<const uint8_t> records, std::span<const Cell> cells)>;
  Status for_each_point(const VisitPoints& visit) const;
  // Faces with the cells of their points.
  using VisitFaces = std::function<Status(std::span<const Face>, std::span<const std::array<Cell, 3>>)>;
  Status for_each_face(const VisitFaces& visit) const;

  static Cell cell_of_face(const std::array<Cell, 3>& cells) {
    const auto [a, b, c] = cells;
    if (a == b || a == c) return a;
    return b == c ? b : std::min({a, b, c});
  }

 private:
  CellAssignment(const LargeMesh& mesh, const ThreadPool& pool)
      : mesh_(&mesh), pool_(&pool), tree_(mesh.box(), mesh.point_count()) {}
  Status locate(std::span<const uint8_t> records, std::vector<Cell>& cells) const;
  Status assign();

  const LargeMesh* mesh_;
  const ThreadPool* pool_;
  CellTree tree_;
  Array<Cell> cell_of_point_;  // empty for a soup
  std::vector<Counts> counts_;
};

}  // namespace psplit
