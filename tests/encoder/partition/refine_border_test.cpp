#include "encoder/partition/refine_border.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "encoder/partition/halve_sets.h"

namespace psplit {
namespace {

// width x height cells of a face each, linked to the left, right, above and below.
CellGraph grid(uint32_t width, uint32_t height) {
  CellGraph graph;
  graph.face_counts.assign(size_t{width} * height, 1);
  graph.first.push_back(0);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const uint32_t cell = y * width + x;
      if (x > 0) graph.links.push_back({cell - 1, 1});
      if (x + 1 < width) graph.links.push_back({cell + 1, 1});
      if (y > 0) graph.links.push_back({cell - width, 1});
      if (y + 1 < height) graph.links.push_back({cell + width, 1});
      graph.first.push_back(static_cast<uint32_t>(graph.links.size()));
    }
  return graph;
}

size_t cut_edges(const CellGraph& graph, const std::vector<uint32_t>& patch_of) {
  size_t cut = 0;
  for (uint32_t c = 0; c < graph.cell_count(); ++c)
    for (const CellGraph::Link& link : graph.around(c))
      cut += patch_of[c] < patch_of[link.cell] ? link.edges : 0;
  return cut;
}

TEST(RefineBorder, StraightensAJaggedBorder) {
  const CellGraph graph = grid(20, 12);
  std::vector<uint32_t> patch_of;
  for (uint32_t y = 0; y < 12; ++y)
    for (uint32_t x = 0; x < 20; ++x) patch_of.push_back(x < (y % 2 == 0 ? 8u : 12u) ? 0 : 1);
  ASSERT_GT(cut_edges(graph, patch_of), 50u);
  refine_border(graph, std::vector<uint32_t>{126, 126}, patch_of);
  EXPECT_LE(cut_edges(graph, patch_of), 13u);  // a straight one has 12
  EXPECT_LE(std::count(patch_of.begin(), patch_of.end(), 0u), 126);
  EXPECT_LE(std::count(patch_of.begin(), patch_of.end(), 1u), 126);
}

TEST(RefineBorder, KeepsPatchesWithinLimitsAndNoneEmpty) {
  const CellGraph graph = grid(4, 4);
  std::vector<uint32_t> patch_of(16, 0);
  patch_of[5] = 1;  // would save four edges by joining
  refine_border(graph, std::vector<uint32_t>{16, 16}, patch_of);
  EXPECT_GE(std::count(patch_of.begin(), patch_of.end(), 1u), 1);
}

TEST(HalveSets, GivesPatchesOfOneSize) {
  const CellGraph graph = grid(30, 20);
  std::vector<uint32_t> all(600), patch_of(600);
  for (uint32_t c = 0; c < 600; ++c) all[c] = c;
  halve_sets(graph, {PatchSet{all, 0, 7}}, patch_of);
  for (uint32_t patch = 0; patch < 7; ++patch)
    EXPECT_NEAR(static_cast<double>(std::count(patch_of.begin(), patch_of.end(), patch)), 600.0 / 7, 4.0);
}

TEST(HalveSets, GivesEachCellAPatchWhereThereAreNoMore) {
  const CellGraph graph = grid(3, 1);
  std::vector<uint32_t> patch_of(3);
  halve_sets(graph, {PatchSet{{2, 1, 0}, 4, 5}}, patch_of);
  EXPECT_EQ(patch_of, (std::vector<uint32_t>{6, 5, 4}));
}

}  // namespace
}  // namespace psplit
