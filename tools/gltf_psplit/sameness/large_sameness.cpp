#include "tools/gltf_psplit/sameness/large_sameness.h"

#include <algorithm>
#include <cstdio>

#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

// One mesh of one asset.
struct Side {
  std::vector<MeshView> views;
  std::vector<const LargePrimitive*> primitives;

  // An attribute of all primitives, with one type and one grid.
  struct Column {
    ValuesView values;
    const DeclaredGrid* grid = nullptr;
  };
  std::optional<Column> column(const std::string& semantic) const {
    std::optional<Column> found;
    std::string identity;
    for (const LargePrimitive* primitive : primitives) {
      const auto& attributes = primitive->view.attributes;
      const auto at = std::ranges::find(attributes, semantic, &MeshView::Values::semantic);
      if (at == attributes.end()) return std::nullopt;
      const auto grid = primitive->grids.find(semantic);
      const DeclaredGrid* const its_grid = grid == primitive->grids.end() ? nullptr : &grid->second;
      const std::string its_identity = its_grid == nullptr ? "exact" : its_grid->identity;
      if (its_identity.empty()) return std::nullopt;
      if (!found) {
        found = {at->values, its_grid};
        identity = its_identity;
      } else if (identity != its_identity || found->values.component_type != at->values.component_type ||
                 found->values.component_count != at->values.component_count) {
        return std::nullopt;
      }
    }
    return found;
  }
};

Side side_of(const LargeAsset& asset, size_t mesh) {
  Side side;
  for (const LargePrimitive& primitive : asset.primitives) {
    if (primitive.mesh != mesh) continue;
    side.views.push_back(primitive.view);
    side.primitives.push_back(&primitive);
  }
  return side;
}

// How the columns of both sides count.
struct Plan {
  std::vector<SummedColumn> columns[2];
  std::vector<std::string> rounded, ignored;
};

void plan_attribute(const std::string& semantic, const Side& a, const Side& b, Plan& plan) {
  const auto of_a = a.column(semantic), of_b = b.column(semantic);
  const bool comparable = of_a && of_b && of_a->values.component_type == of_b->values.component_type &&
                          of_a->values.component_count == of_b->values.component_count &&
                          of_a->values.normalized == of_b->values.normalized;
  if (!comparable) return plan.ignored.push_back(semantic);
  SummedColumn columns[2] = {{semantic, std::nullopt}, {semantic, std::nullopt}};
  if ((of_a->grid == nullptr) != (of_b->grid == nullptr)) {
    const DeclaredGrid& grid = of_a->grid == nullptr ? *of_b->grid : *of_a->grid;
    // Encoders change normals, colours and weights before they round them.
    const bool is_rounded = semantic == "POSITION" || semantic.starts_with("TEXCOORD_");
    if (grid.direction || !is_rounded || of_a->values.component_type != ComponentType::kFloat32)
      return plan.ignored.push_back(semantic);
    columns[of_a->grid == nullptr ? 0 : 1].round_to = grid;
    plan.rounded.push_back(semantic);
  } else if (of_a->grid != nullptr && of_a->grid->identity != of_b->grid->identity) {
    return plan.ignored.push_back(semantic);
  }
  for (size_t side = 0; side < 2; ++side) plan.columns[side].push_back(std::move(columns[side]));
}

Plan plan_columns(const Side& a, const Side& b, const std::vector<std::string>& only) {
  Plan plan;
  plan_attribute("POSITION", a, b, plan);
  std::vector<std::string> semantics;
  for (const Side* side : {&a, &b})
    for (const MeshView& view : side->views)
      for (const MeshView::Values& attribute : view.attributes) semantics.push_back(attribute.semantic);
  std::ranges::sort(semantics);
  semantics.erase(std::unique(semantics.begin(), semantics.end()), semantics.end());
  for (const std::string& semantic : semantics) {
    const bool is_wanted = only.empty() || std::ranges::find(only, semantic) != only.end();
    if (semantic != "POSITION" && is_wanted) plan_attribute(semantic, a, b, plan);
  }
  return plan;
}

void find_difference(const TriangleSums& a, const TriangleSums& b, const PositionBox& box,
                     LargeComparison::Mesh& mesh) {
  constexpr size_t kCells = TriangleSums::kCells;
  std::array<size_t, 3> low{kCells, kCells, kCells}, high{};
  for (size_t i = 0; i < a.cells.size(); ++i) {
    if (a.cells[i] == b.cells[i]) continue;
    ++mesh.differing_cells;
    const std::array<size_t, 3> at{i % kCells, i / kCells % kCells, i / kCells / kCells};
    for (size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], at[axis]);
      high[axis] = std::max(high[axis], at[axis] + 1);
    }
  }
  for (size_t axis = 0; axis < 3 && mesh.differing_cells > 0; ++axis) {
    const float step = (box.high[axis] - box.low[axis]) / static_cast<float>(kCells);
    mesh.difference.low[axis] = box.low[axis] + step * static_cast<float>(low[axis]);
    mesh.difference.high[axis] = box.low[axis] + step * static_cast<float>(high[axis]);
  }
}

Expected<LargeComparison::Mesh> compare_mesh(const Side& a, const Side& b, const std::vector<std::string>& only,
                                             const ThreadPool& pool) {
  LargeComparison::Mesh mesh;
  if (a.views.empty() || b.views.empty()) {
    mesh.same = a.views.empty() && b.views.empty();
    for (const MeshView& view : a.views) mesh.triangles[0] += view.indices.count / 3;
    for (const MeshView& view : b.views) mesh.triangles[1] += view.indices.count / 3;
    return mesh;
  }
  Plan plan = plan_columns(a, b, only);
  if (plan.columns[0].empty() || plan.columns[0].front().semantic != "POSITION")
    return unsupported(
        "the positions of the two assets are on different grids, which only a comparison in memory "
        "compares: raise --memory, or decode both");
  const PositionBox box = position_box(a.views);
  const auto sum = [&] {
    return std::pair(sum_triangles(a.views, plan.columns[0], box, pool),
                     sum_triangles(b.views, plan.columns[1], box, pool));
  };
  auto [of_a, of_b] = sum();
  if (of_a && of_b && of_a->all != of_b->all && !plan.rounded.empty()) {
    // A decoded file has the values of the grid, but does not declare it.
    for (auto& columns : plan.columns)
      for (SummedColumn& column : columns) column.round_to.reset();
    auto [exact_a, exact_b] = sum();
    if (exact_a && exact_b && exact_a->all == exact_b->all) {
      of_a = std::move(exact_a);
      of_b = std::move(exact_b);
      plan.rounded.clear();
    }
  }
  if (!of_a) return of_a.status();
  if (!of_b) return of_b.status();
  mesh.rounded = std::move(plan.rounded);
  mesh.ignored = std::move(plan.ignored);
  mesh.same = of_a->all == of_b->all;
  mesh.triangles[0] = of_a->all.count;
  mesh.triangles[1] = of_b->all.count;
  mesh.degenerate[0] = of_a->degenerate;
  mesh.degenerate[1] = of_b->degenerate;
  if (!mesh.same) find_difference(*of_a, *of_b, box, mesh);
  return mesh;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string corner_text(const std::array<float, 3>& corner) {
  char text[80];
  std::snprintf(text, sizeof text, "(%.6g %.6g %.6g)", double{corner[0]}, double{corner[1]}, double{corner[2]});
  return text;
}

}  // namespace

bool LargeComparison::same() const {
  return mesh_counts[0] == mesh_counts[1] && std::ranges::all_of(meshes, &Mesh::same);
}

Expected<LargeComparison> compare_large(const LargeAsset& a, const LargeAsset& b,
                                        const std::vector<std::string>& only, const ThreadPool& pool) {
  LargeComparison comparison;
  comparison.mesh_counts[0] = a.mesh_count;
  comparison.mesh_counts[1] = b.mesh_count;
  for (size_t i = 0; i < std::max(a.mesh_count, b.mesh_count); ++i) {
    Expected<LargeComparison::Mesh> mesh = compare_mesh(side_of(a, i), side_of(b, i), only, pool);
    if (!mesh) return mesh.status().at({.mesh = static_cast<int64_t>(i)});
    comparison.meshes.push_back(std::move(*mesh));
  }
  return comparison;
}

std::string to_text(const LargeComparison& comparison, const std::string& first, const std::string& second) {
  std::string text = comparison.same() ? "same by sums of hashes: " : "differs: ";
  if (comparison.mesh_counts[0] != comparison.mesh_counts[1])
    text += counted(comparison.mesh_counts[0], "mesh") + " in " + first + ", " +
            counted(comparison.mesh_counts[1], "mesh") + " in " + second + "; ";
  uint64_t triangles = 0;
  std::vector<std::string> rounded, ignored;
  for (size_t i = 0; i < comparison.meshes.size(); ++i) {
    const LargeComparison::Mesh& mesh = comparison.meshes[i];
    triangles += mesh.triangles[0];
    rounded.insert(rounded.end(), mesh.rounded.begin(), mesh.rounded.end());
    ignored.insert(ignored.end(), mesh.ignored.begin(), mesh.ignored.end());
    if (mesh.same) continue;
    text += "mesh " + std::to_string(i) + ": " + counted(mesh.triangles[0], "triangle") + " in " + first +
            ", " + counted(mesh.triangles[1], "triangle") + " in " + second;
    if (mesh.differing_cells > 0)
      text += "; differences in " + with_separators(mesh.differing_cells) + " of 4,096 cells, between " +
              corner_text(mesh.difference.low) + " and " + corner_text(mesh.difference.high);
    text += "\n";
  }
  if (comparison.same()) text += counted(triangles, "triangle") + "\n";
  if (!text.ends_with('\n')) text += "\n";
  for (std::vector<std::string>* words : {&rounded, &ignored}) {
    std::ranges::sort(*words);
    words->erase(std::unique(words->begin(), words->end()), words->end());
  }
  if (!rounded.empty()) text += "rounded to the grid of the other asset: " + joined(rounded) + "\n";
  if (!ignored.empty()) text += "not compared: " + joined(ignored) + "\n";
  return text;
}

Json to_json(const LargeComparison& comparison) {
  Json meshes = Json::array();
  for (const LargeComparison::Mesh& mesh : comparison.meshes) {
    Json object{{"same", mesh.same},
                {"triangles", {mesh.triangles[0], mesh.triangles[1]}},
                {"degenerate", {mesh.degenerate[0], mesh.degenerate[1]}},
                {"rounded", mesh.rounded},
                {"not_compared", mesh.ignored}};
    if (mesh.differing_cells > 0)
      object["difference"] = {
          {"cells", mesh.differing_cells}, {"min", mesh.difference.low}, {"max", mesh.difference.high}};
    meshes.push_back(std::move(object));
  }
  return {{"same", comparison.same()},
          {"method", "sums of hashes"},
          {"mesh_counts", {comparison.mesh_counts[0], comparison.mesh_counts[1]}},
          {"meshes", std::move(meshes)}};
}

}  // namespace psplit
