#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "encoder/partition/band_cut.h"
#include "encoder/partition/partition_steps.h"
#include "tests/encoder/partition/pieces.h"

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

// The least cut of all divisions of a few nodes.
int64_t least_cut(const std::vector<std::vector<int32_t>>& between, const std::vector<int32_t>& from_source,
                  const std::vector<int32_t>& to_sink) {
  const size_t count = between.size();
  int64_t least = 1 << 30;
  for (uint32_t division = 0; division < 1u << count; ++division) {
    int64_t cut = 0;
    for (size_t i = 0; i < count; ++i) {
      const bool is_source = (division >> i & 1) != 0;
      cut += is_source ? to_sink[i] : from_source[i];
      for (size_t k = 0; k < i; ++k)
        if (is_source != ((division >> k & 1) != 0)) cut += between[i][k];
    }
    least = std::min(least, cut);
  }
  return least;
}

TEST(BandCut, IsTheLeastOfAllDivisions) {
  std::mt19937 random(3);
  BandCut band;
  for (int run = 0; run < 500; ++run) {
    const size_t count = 1 + random() % 9;
    std::vector<std::vector<int32_t>> between(count, std::vector<int32_t>(count, 0));
    std::vector<int32_t> from_source(count), to_sink(count);
    for (size_t i = 0; i < count; ++i) {
      if (random() % 3 == 0) from_source[i] = static_cast<int32_t>(random() % 5);
      if (random() % 3 == 0) to_sink[i] = static_cast<int32_t>(random() % 5);
      for (size_t k = 0; k < i; ++k)
        if (random() % 2 == 0) between[i][k] = between[k][i] = static_cast<int32_t>(random() % 4);
    }
    band.clear();
    for (size_t i = 0; i < count; ++i) {
      for (size_t k = 0; k < count; ++k)
        if (between[i][k] > 0) band.add_link(static_cast<uint32_t>(k), between[i][k]);
      band.end_node(from_source[i], to_sink[i]);
    }
    const int64_t least = least_cut(between, from_source, to_sink);
    ASSERT_EQ(band.run(), least);
    // Free nodes may be on either side.
    for (const bool free_is_source : {false, true}) {
      int64_t cut = 0;
      const auto is_source = [&](size_t i) {
        const BandCut::Side side = band.side(static_cast<uint32_t>(i));
        return side == BandCut::Side::kSource || (side == BandCut::Side::kFree && free_is_source);
      };
      for (size_t i = 0; i < count; ++i) {
        cut += is_source(i) ? to_sink[i] : from_source[i];
        for (size_t k = 0; k < i; ++k) cut += is_source(i) != is_source(k) ? between[i][k] : 0;
      }
      ASSERT_EQ(cut, least);
    }
  }
}

TEST(RecutBorders, StraightensAJaggedBorder) {
  const ThreadPool pool(2);
  const CellGraph graph = grid(20, 12);
  std::vector<uint32_t> patch_of;
  for (uint32_t y = 0; y < 12; ++y)
    for (uint32_t x = 0; x < 20; ++x) patch_of.push_back(x < (y % 2 == 0 ? 8u : 12u) ? 0 : 1);
  ASSERT_GT(cut_edges(graph, patch_of), 50u);
  recut_borders(graph, std::vector<uint32_t>{126, 126}, {6, 8}, patch_of, pool);
  EXPECT_EQ(cut_edges(graph, patch_of), 12u);  // a straight one
  EXPECT_LE(std::count(patch_of.begin(), patch_of.end(), 0u), 126);
  EXPECT_LE(std::count(patch_of.begin(), patch_of.end(), 1u), 126);
}

// Faces move from one patch to its neighbour, and on to the next.
TEST(RecutBorders, BringsPatchesBelowTheirLimits) {
  const ThreadPool pool(2);
  const CellGraph graph = grid(30, 10);
  std::vector<uint32_t> patch_of;
  for (uint32_t y = 0; y < 10; ++y)
    for (uint32_t x = 0; x < 30; ++x) patch_of.push_back(x < 16 ? 0 : x < 26 ? 1 : 2);
  recut_borders(graph, std::vector<uint32_t>{105, 105, 105}, {2, 2}, patch_of, pool);
  for (uint32_t patch = 0; patch < 3; ++patch)
    EXPECT_LE(std::count(patch_of.begin(), patch_of.end(), patch), 105) << patch;
  EXPECT_LE(cut_edges(graph, patch_of), 26u);
}

TEST(RecutBorders, KeepsPatchesConnectedAndNoneEmpty) {
  const ThreadPool pool(2);
  const CellGraph graph = grid(4, 4);
  std::vector<uint32_t> patch_of(16, 0);
  patch_of[5] = 1;  // would save four edges by joining
  recut_borders(graph, std::vector<uint32_t>{16, 16}, {2, 8}, patch_of, pool);
  EXPECT_GE(std::count(patch_of.begin(), patch_of.end(), 1u), 1);
  // A dumbbell, whose handle is the shortest border but keeps it together.
  const CellGraph wide = grid(15, 5);
  std::vector<uint32_t> dumbbell(75, 1);
  for (uint32_t y = 0; y < 5; ++y)
    for (uint32_t x = 0; x < 15; ++x)
      if (x < 5 || x >= 10 || y == 2) dumbbell[y * 15 + x] = 0;
  recut_borders(wide, std::vector<uint32_t>{75, 75}, {3, 8}, dumbbell, pool);
  std::vector<uint32_t> found;
  for (uint32_t cell = 0; cell < 75 && found.empty(); ++cell)
    if (dumbbell[cell] == 0) found.push_back(cell);
  std::vector<bool> is_seen(75, false);
  is_seen[found[0]] = true;
  for (size_t i = 0; i < found.size(); ++i)
    for (const CellGraph::Link& link : wide.around(found[i]))
      if (dumbbell[link.cell] == 0 && !is_seen[link.cell]) {
        is_seen[link.cell] = true;
        found.push_back(link.cell);
      }
  EXPECT_EQ(found.size(), static_cast<size_t>(std::count(dumbbell.begin(), dumbbell.end(), 0u)));
}

// Patches grow at random on sheets, tubes and tori, with holes or with faces that are repeated, turned, or join
// distant points.
TEST(RecutBorders, KeepsPatchesOfAnyFacesTogether) {
  const ThreadPool pool(2);
  std::mt19937 random(1);
  const auto below = [&](size_t end) { return static_cast<uint32_t>(random() % end); };
  for (int run = 0; run < 4000; ++run) {
    const uint32_t width = 6 + below(12), height = 6 + below(12);
    const bool is_tube = below(2) != 0, is_torus = is_tube && below(2) != 0;
    const uint32_t columns = is_tube ? width : width + 1, rows = is_torus ? height : height + 1;
    const auto at = [&](uint32_t x, uint32_t y) { return y % rows * columns + x % columns; };
    std::vector<std::array<uint32_t, 3>> faces;
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        if (run % 3 == 0 && below(12) == 0) continue;
        faces.push_back({at(x, y), at(x + 1, y), at(x, y + 1)});
        faces.push_back({at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
      }
    const uint32_t damage = run % 4 == 1 ? below(20) : 0;
    for (uint32_t i = 0; i < damage; ++i) {
      auto& face = faces[below(faces.size())];
      const uint32_t kind = below(4);
      if (kind == 0) std::swap(face[0], face[1]);
      if (kind == 1) face[below(3)] = face[below(3)];
      if (kind == 2) face[below(3)] = below(size_t{columns} * rows);
      if (kind == 3) faces.push_back(std::array(face));
    }
    const FaceGraph graph = face_graph(faces, columns * rows, pool);
    const uint32_t patch_count = 2 + below(5);
    std::vector<uint32_t> patch_of(graph.cell_count(), kNoCell), front;
    for (uint32_t patch = 0; patch < patch_count; ++patch) {
      const uint32_t face = below(graph.cell_count());
      if (patch_of[face] != kNoCell) continue;
      patch_of[face] = patch;
      front.push_back(face);
    }
    while (!front.empty()) {
      const uint32_t place = below(front.size());
      std::vector<uint32_t> free;
      graph.for_each_link(front[place], [&](uint32_t next, uint32_t) {
        if (patch_of[next] == kNoCell) free.push_back(next);
      });
      if (free.empty()) {
        front[place] = front.back();
        front.pop_back();
        continue;
      }
      const uint32_t face = free[below(free.size())];
      patch_of[face] = patch_of[front[place]];
      front.push_back(face);
    }
    std::replace(patch_of.begin(), patch_of.end(), kNoCell, 0u);
    const size_t before = piece_count(graph, patch_of);
    recut_borders(graph, std::vector<uint32_t>(patch_count, graph.cell_count() / patch_count * 6 / 5 + 3),
                  {3, static_cast<double>(1 + below(8))}, patch_of, pool);
    ASSERT_LE(piece_count(graph, patch_of), before) << run;
  }
}

TEST(HalveSets, GivesPatchesOfOneSize) {
  const CellGraph graph = grid(30, 20);
  std::vector<uint32_t> all(600), patch_of(600);
  for (uint32_t c = 0; c < 600; ++c) all[c] = c;
  halve_sets(graph, {PatchSet{all, 0, 7}}, patch_of, ThreadPool(2));
  for (uint32_t patch = 0; patch < 7; ++patch)
    EXPECT_NEAR(static_cast<double>(std::count(patch_of.begin(), patch_of.end(), patch)), 600.0 / 7, 4.0);
}

TEST(HalveSets, GivesEachCellAPatchWhereThereAreNoMore) {
  const CellGraph graph = grid(3, 1);
  std::vector<uint32_t> patch_of(3);
  halve_sets(graph, {PatchSet{{2, 1, 0}, 4, 5}}, patch_of, ThreadPool(2));
  EXPECT_EQ(patch_of, (std::vector<uint32_t>{6, 5, 4}));
}

}  // namespace
}  // namespace psplit
