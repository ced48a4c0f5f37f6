#include "gltf_ext/out_of_core/cell_assignment.h"

#include <algorithm>
#include <string>

namespace psplit {

Status CellAssignment::locate(std::span<const uint8_t> records, std::vector<Cell>& cells) const {
  constexpr size_t kGrain = 4096;
  const size_t width = mesh_->record_bytes();
  cells.resize(records.size() / width);
  pool_->for_ranges(cells.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      cells[i] = static_cast<Cell>(tree_.cell_of(mesh_->position_of(records.data() + i * width)));
  });
  return {};
}

Status CellAssignment::for_each_point(const VisitPoints& visit) const {
  std::vector<Cell> cells;
  return mesh_->for_each_point([&](uint64_t first, std::span<const uint8_t> records) {
    if (!cell_of_point_.empty()) {
      const size_t count = records.size() / mesh_->record_bytes();
      return visit(first, records, std::span(cell_of_point_).subspan(static_cast<size_t>(first), count));
    }
    if (Status status = locate(records, cells); !status.ok()) return status;
    return visit(first, records, cells);
  });
}

Status CellAssignment::for_each_face(const VisitFaces& visit) const {
  std::vector<std::array<Cell, 3>> cells;
  if (!mesh_->is_soup())
    return mesh_->for_each_face([&](std::span<const Face> faces) {
      cells.resize(faces.size());
      for (size_t i = 0; i < faces.size(); ++i)
        for (size_t c = 0; c < 3; ++c) cells[i][c] = cell_of_point_[faces[i][c]];
      return visit(faces, cells);
    });
  std::vector<Face> faces;
  return for_each_point([&](uint64_t first, std::span<const uint8_t>, std::span<const Cell> corners) {
    faces.resize(corners.size() / 3);
    cells.resize(faces.size());
    for (size_t i = 0; i < faces.size(); ++i)
      for (size_t c = 0; c < 3; ++c) {
        faces[i][c] = static_cast<uint32_t>(first + 3 * i + c);
        cells[i][c] = corners[3 * i + c];
      }
    return visit(faces, cells);
  });
}

Status CellAssignment::assign() {
  counts_.assign(tree_.cell_count(), {});
  Array<Cell> cell_of_point;
  if (!mesh_->is_soup()) cell_of_point.resize(static_cast<size_t>(mesh_->point_count()));
  cell_of_point_ = Array<Cell>();
  Status status = for_each_point([&](uint64_t first, std::span<const uint8_t>, std::span<const Cell> cells) {
    for (const Cell cell : cells) ++counts_[cell].points;
    if (!mesh_->is_soup()) std::ranges::copy(cells, cell_of_point.begin() + static_cast<std::ptrdiff_t>(first));
    return Status();
  });
  cell_of_point_ = std::move(cell_of_point);
  if (!status.ok()) return status;
  return for_each_face([&](std::span<const Face>, std::span<const std::array<Cell, 3>> cells) {
    for (const auto& corners : cells) {
      const Cell cell = cell_of_face(corners);
      ++counts_[cell].faces;
      for (const Cell corner : corners)
        if (corner != cell) {
          ++counts_[cell].foreign_corners;
          ++counts_[corner].requests;
        }
    }
    return Status();
  });
}

Expected<CellAssignment> CellAssignment::make(const LargeMesh& mesh, const PartCost& cost,
                                              const ThreadPool& pool) {
  CellAssignment result(mesh, pool);
  const PositionScan scan = [&](const auto& visit) { return mesh.for_each_position(visit); };
  // A cell that costs too much gets fewer points. Its cost shrinks with them, except for faces that share no
  // points with their neighbours in space.
  constexpr int kMostRounds = 12;
  std::vector<uint64_t> most(1);
  const uint64_t whole = cost.of(mesh.face_count(), mesh.point_count());
  const auto points_within = [&](uint64_t points, uint64_t cost_of_cell) {
    constexpr double kMargin = 0.9;
    if (cost_of_cell <= cost.most) return points;
    return static_cast<uint64_t>(static_cast<double>(points) * kMargin * static_cast<double>(cost.most) /
                                 static_cast<double>(cost_of_cell));
  };
  most[0] = points_within(mesh.point_count(), whole);
  for (int round = 0; round < kMostRounds; ++round) {
    if (Status status = result.tree_.divide(most, scan); !status.ok()) return status;
    if (Status status = result.assign(); !status.ok()) return status;
    bool fits = true;
    most.clear();
    for (const Counts& counts : result.counts_) {
      // Corners of one foreign point are not told apart here. Its neighbours are a third of them.
      const uint64_t cell = cost.of(counts.faces, counts.points + counts.foreign_corners / 3);
      most.push_back(points_within(counts.points, cell));
      fits = fits && cell <= cost.most;
    }
    if (fits) return result;
  }
  return unsupported("the faces cannot be divided into parts that fit into --memory");
}

}  // namespace psplit
