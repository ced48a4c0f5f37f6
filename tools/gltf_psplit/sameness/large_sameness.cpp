#include "tools/gltf_psplit/sameness/large_sameness.h"

#include <algorithm>

#include "gltf_ext/compare/rounded_mesh.h"
#include "tools/gltf_psplit/sameness/large_groups.h"

namespace psplit {
namespace {

using MeshResult = LargeComparison::Mesh;

// How an attribute of two sides is compared.
enum class ColumnKind {
  kExact,      // bit for bit
  kRounded,    // the side without a grid is rounded
  kOtherGrid,  // both sides have grids, which differ
  kOtherType,
};

struct Column {
  std::string semantic;
  ColumnKind kind = ColumnKind::kExact;
  size_t exact_side = 0;  // of kRounded
  DeclaredGrid grid{};    // of kRounded
};

// An attribute of all primitives of one side; nothing if its type or its grid changes from one to the next.
struct SideColumn {
  ValuesView values;
  const DeclaredGrid* grid = nullptr;
};
std::optional<SideColumn> column_of(const LargeGroup& side, const std::string& semantic) {
  std::optional<SideColumn> found;
  for (const LargePrimitive* primitive : side) {
    const ValuesView& values =
        std::ranges::find(primitive->view.attributes, semantic, &MeshView::Values::semantic)->values;
    const auto grid = primitive->grids.find(semantic);
    const DeclaredGrid* const its_grid = grid == primitive->grids.end() ? nullptr : &grid->second;
    if (!found) found = {values, its_grid};
    const bool same_grid = (its_grid == nullptr) == (found->grid == nullptr) &&
                           (its_grid == nullptr || its_grid->identity == found->grid->identity);
    if (!same_grid || values.component_type != found->values.component_type ||
        values.normalized != found->values.normalized)
      return std::nullopt;
  }
  return found;
}

Column plan_column(const std::string& semantic, const LargeGroup& a, const LargeGroup& b) {
  Column column{semantic};
  const auto of_a = column_of(a, semantic), of_b = column_of(b, semantic);
  if (!of_a || !of_b || of_a->values.component_type != of_b->values.component_type ||
      of_a->values.normalized != of_b->values.normalized) {
    column.kind = ColumnKind::kOtherType;
    return column;
  }
  if (of_a->grid == nullptr && of_b->grid == nullptr) return column;
  if (of_a->grid != nullptr && of_b->grid != nullptr) {
    // Streams of one primitive may have several grids: then their identity is empty.
    if (of_a->grid->identity.empty() || of_a->grid->identity != of_b->grid->identity)
      column.kind = ColumnKind::kOtherGrid;
    return column;
  }
  column.exact_side = of_a->grid == nullptr ? 0 : 1;
  column.grid = of_a->grid == nullptr ? *of_b->grid : *of_a->grid;
  const size_t components = of_a->values.component_count;
  const bool can_round = !column.grid.identity.empty() &&
                         of_a->values.component_type == ComponentType::kFloat32 &&
                         components == (column.grid.direction ? 3 : column.grid.origin.size());
  column.kind = can_round ? ColumnKind::kRounded : ColumnKind::kOtherGrid;
  return column;
}

// Compares groups of primitives that have the same attributes.
class GroupComparer {
 public:
  GroupComparer(const LargeGroup& a, const LargeGroup& b, const std::vector<std::string>& only,
                const std::filesystem::path& folder, const ThreadPool& pool)
      : sides_{a, b}, folder_(folder), pool_(pool) {
    for (const auto& [semantic, components] : compared_attributes(*a[0], only))
      columns_.push_back(plan_column(semantic, a, b));
    box_ = position_box(views_of(0));
  }

  Expected<MeshResult> run() {
    const std::vector<std::string> comparable = names({ColumnKind::kExact, ColumnKind::kRounded});
    const bool can_decide = comparable.size() == columns_.size();
    const std::vector<std::string> rounded = names({ColumnKind::kRounded});
    Sums sums;
    const auto is_same = [&](const std::vector<std::string>& attributes, Rounding rounding) -> Expected<bool> {
      Expected<Sums> found = sum(attributes, rounding);
      if (!found) return found.status();
      sums = std::move(*found);
      return sums.of[0].all == sums.of[1].all;
    };
    const bool has_weights =
        std::ranges::any_of(rounded, [](const std::string& name) { return name.starts_with("WEIGHTS_"); });
    Rounding rounding = rounded.empty() ? Rounding::kNone : Rounding::kTogether;
    if (can_decide) {
      const Expected<bool> same = is_same(comparable, rounding);
      if (!same) return same.status();
      if (*same) return result(sums, rounded);
      if (has_weights) {
        const Expected<bool> alone = is_same(comparable, Rounding::kAlone);
        if (!alone) return alone.status();
        if (*alone) return result(sums, rounded);
      }
    }
    // A decoded file has the values of the grid, but does not declare it.
    if ((!rounded.empty() || !can_decide) && names({ColumnKind::kOtherType}).empty()) {
      const Expected<bool> same =
          is_same(names({ColumnKind::kExact, ColumnKind::kRounded, ColumnKind::kOtherGrid}), Rounding::kNone);
      if (!same) return same.status();
      if (*same) return result(sums, {});
    }
    return describe(comparable, rounded, rounding);
  }

 private:
  enum class Rounding { kNone, kTogether, kAlone };
  struct Sums {
    TriangleSums of[2];
  };

  std::vector<std::string> names(std::initializer_list<ColumnKind> kinds) const {
    std::vector<std::string> found;
    for (const Column& column : columns_)
      if (std::ranges::find(kinds, column.kind) != kinds.end()) found.push_back(column.semantic);
    return found;
  }

  std::vector<MeshView> views_of(size_t side) const {
    std::vector<MeshView> views;
    for (const LargePrimitive* primitive : sides_[side]) views.push_back(primitive->view);
    return views;
  }

  Expected<Sums> sum(const std::vector<std::string>& attributes, Rounding rounding) const {
    Sums sums;
    for (size_t side = 0; side < 2; ++side) {
      std::map<std::string, DeclaredGrid> grids;
      for (const Column& column : columns_)
        if (rounding != Rounding::kNone && column.kind == ColumnKind::kRounded && column.exact_side == side &&
            std::ranges::find(attributes, column.semantic) != attributes.end())
          grids.emplace(column.semantic, column.grid);
      std::vector<MeshView> views = views_of(side);
      std::vector<RoundedMesh> rounded;
      for (MeshView& view : views) {
        if (grids.empty()) break;
        const WeightRounding weights =
            rounding == Rounding::kAlone ? WeightRounding::kAlone : WeightRounding::kTogether;
        Expected<RoundedMesh> mesh = round_to_grids(view, grids, weights, folder_, pool_);
        if (!mesh) return mesh.status();
        view = mesh->view;
        rounded.push_back(std::move(*mesh));
      }
      Expected<TriangleSums> found = sum_triangles(views, attributes, box_, pool_);
      if (!found) return found.status();
      sums.of[side] = std::move(*found);
    }
    return sums;
  }

  MeshResult result(const Sums& sums, std::vector<std::string> rounded) const {
    MeshResult mesh;
    mesh.rounded = std::move(rounded);
    for (size_t side = 0; side < 2; ++side) {
      mesh.triangles[side] = sums.of[side].all.count;
      mesh.degenerate[side] = sums.of[side].degenerate;
    }
    return mesh;
  }

  // Finds the attributes that differ, each together with the positions.
  Expected<MeshResult> describe(const std::vector<std::string>& comparable,
                                const std::vector<std::string>& rounded, Rounding rounding) const {
    const bool has_positions = !comparable.empty() && comparable.front() == "POSITION";
    Expected<Sums> positions = sum({"POSITION"}, has_positions ? rounding : Rounding::kNone);
    if (!positions) return positions.status();
    MeshResult mesh = result(*positions, rounded);
    mesh.undecided = names({ColumnKind::kOtherGrid, ColumnKind::kOtherType});
    // Positions on different grids: then equal counts are all that is known.
    if (!has_positions) {
      mesh.verdict = LargeVerdict::kUndecided;
      return mesh;
    }
    if (positions->of[0].all != positions->of[1].all) {
      mesh.differing.push_back("POSITION");
      find_cells(*positions, mesh);
    }
    for (const std::string& semantic : comparable) {
      if (!mesh.differing.empty() && mesh.differing.front() == "POSITION") break;
      if (semantic == "POSITION") continue;
      const Expected<Sums> found = sum({"POSITION", semantic}, rounding);
      if (!found) return found.status();
      if (found->of[0].all == found->of[1].all) continue;
      if (mesh.differing.empty()) find_cells(*found, mesh);
      mesh.differing.push_back(semantic);
    }
    if (mesh.differing.empty() && comparable.size() > 2) {  // each alone is the same
      const Expected<Sums> all = sum(comparable, rounding);
      if (!all) return all.status();
      if (all->of[0].all != all->of[1].all) {
        find_cells(*all, mesh);
        mesh.differing.assign(comparable.begin() + 1, comparable.end());
      }
    }
    mesh.verdict = mesh.differing.empty() ? LargeVerdict::kUndecided : LargeVerdict::kDiffers;
    return mesh;
  }

  void find_cells(const Sums& sums, MeshResult& mesh) const {
    constexpr size_t kCells = TriangleSums::kCells;
    std::array<size_t, 3> low{kCells, kCells, kCells}, high{};
    for (size_t i = 0; i < sums.of[0].cells.size(); ++i) {
      if (sums.of[0].cells[i] == sums.of[1].cells[i]) continue;
      ++mesh.differing_cells;
      const std::array<size_t, 3> at{i % kCells, i / kCells % kCells, i / kCells / kCells};
      for (size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], at[axis]);
        high[axis] = std::max(high[axis], at[axis] + 1);
      }
    }
    for (size_t axis = 0; axis < 3; ++axis) {
      const float step = (box_.high[axis] - box_.low[axis]) / static_cast<float>(kCells);
      mesh.difference.low[axis] = box_.low[axis] + step * static_cast<float>(low[axis]);
      mesh.difference.high[axis] = box_.low[axis] + step * static_cast<float>(high[axis]);
    }
  }

  const LargeGroup sides_[2];
  const std::filesystem::path& folder_;
  const ThreadPool& pool_;
  std::vector<Column> columns_;
  PositionBox box_;
};

void add(MeshResult& sum, const MeshResult& part) {
  sum.verdict = std::max(sum.verdict, part.verdict);
  for (size_t side = 0; side < 2; ++side) {
    sum.triangles[side] += part.triangles[side];
    sum.degenerate[side] += part.degenerate[side];
  }
  const auto append = [](std::vector<std::string>& to, const std::vector<std::string>& from) {
    for (const std::string& word : from)
      if (std::ranges::find(to, word) == to.end()) to.push_back(word);
  };
  append(sum.rounded, part.rounded);
  append(sum.undecided, part.undecided);
  append(sum.differing, part.differing);
  if (sum.what.empty()) sum.what = part.what;
  if (sum.differing_cells == 0) sum.difference = part.difference;
  sum.differing_cells = std::max(sum.differing_cells, part.differing_cells);
}

uint64_t triangle_count(const LargeGroup& side) {
  uint64_t count = 0;
  for (const LargePrimitive* primitive : side) count += primitive->view.indices.count / 3;
  return count;
}

// The two sides of a mesh, or of one of its groups.
class MeshComparer {
 public:
  MeshComparer(bool by_material, const std::vector<std::string>& only, const std::filesystem::path& folder,
               const ThreadPool& pool)
      : by_material_(by_material), only_(only), folder_(folder), pool_(pool) {}

  // First by the numbers of primitives; if that fails, all primitives of one kind together.
  Expected<MeshResult> compare(const LargeGroup& a, const LargeGroup& b) const {
    MeshResult by_number;
    if (a.size() == b.size()) {
      for (size_t i = 0; i < a.size(); ++i) {
        const Expected<MeshResult> part = compare_group({a[i]}, {b[i]});
        if (!part) return part;
        add(by_number, *part);
      }
      if (by_number.verdict == LargeVerdict::kSame || a.size() == 1) return by_number;
    }
    MeshResult together;
    for (const auto& [of_a, of_b] : groups_of(a, b, by_material_, only_)) {
      const Expected<MeshResult> part = compare_group(of_a, of_b);
      if (!part) return part;
      add(together, *part);
    }
    // Primitives in another order differ by number, and may be undecided together.
    return a.size() != b.size() || together.verdict < by_number.verdict ? together : by_number;
  }

 private:
  Expected<MeshResult> compare_group(const LargeGroup& a, const LargeGroup& b) const {
    std::string what = difference_of_kind(a, b, by_material_, only_);
    if (what.empty() && !a.empty() && !b.empty()) return GroupComparer(a, b, only_, folder_, pool_).run();
    MeshResult mesh;
    mesh.triangles[0] = triangle_count(a);
    mesh.triangles[1] = triangle_count(b);
    if (what.empty()) return mesh;
    mesh.verdict = LargeVerdict::kDiffers;
    mesh.what = std::move(what);
    return mesh;
  }

  bool by_material_;
  const std::vector<std::string>& only_;
  const std::filesystem::path& folder_;
  const ThreadPool& pool_;
};

}  // namespace

LargeVerdict LargeComparison::verdict() const {
  LargeVerdict worst = mesh_counts[0] == mesh_counts[1] ? LargeVerdict::kSame : LargeVerdict::kDiffers;
  for (const MeshResult& mesh : meshes) worst = std::max(worst, mesh.verdict);
  return worst;
}

LargeComparison::Mesh LargeComparison::sum() const {
  MeshResult all;
  for (const MeshResult& mesh : meshes) add(all, mesh);
  return all;
}

Expected<LargeComparison> compare_large(const LargeAsset& a, const LargeAsset& b,
                                        const std::vector<std::string>& only,
                                        const std::filesystem::path& folder, const ThreadPool& pool) {
  LargeComparison comparison;
  comparison.mesh_counts[0] = a.mesh_count;
  comparison.mesh_counts[1] = b.mesh_count;
  const MeshComparer comparer(a.material_count == b.material_count, only, folder, pool);
  const auto primitives_of = [](const LargeAsset& asset, size_t mesh) {
    LargeGroup group;
    for (const LargePrimitive& primitive : asset.primitives)
      if (primitive.mesh == mesh) group.push_back(&primitive);
    return group;
  };
  for (size_t i = 0; i < std::max(a.mesh_count, b.mesh_count); ++i) {
    Expected<MeshResult> mesh = comparer.compare(primitives_of(a, i), primitives_of(b, i));
    if (!mesh) return mesh.status().at({.mesh = static_cast<int64_t>(i)});
    comparison.meshes.push_back(std::move(*mesh));
  }
  return comparison;
}

}  // namespace psplit
