#include "encoder/partition/border_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "encoder/partition/recut_borders.h"

namespace psplit {
namespace {

// Two triangles for each of width x height squares; on a tube, the last column is joined to the first.
FaceGraph squares(uint32_t width, uint32_t height, bool is_tube = false) {
  const uint32_t columns = is_tube ? width : width + 1;
  std::vector<std::array<uint32_t, 3>> faces;
  const auto at = [&](uint32_t x, uint32_t y) { return y * columns + x % columns; };
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      faces.push_back({at(x, y), at(x + 1, y), at(x, y + 1)});
      faces.push_back({at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  return face_graph(faces, columns * (height + 1), ThreadPool(1));
}

// Patch 0 where is_left(x, y) of the square, else 1.
template <typename IsLeft>
std::vector<uint32_t> divide(uint32_t width, uint32_t height, IsLeft is_left) {
  std::vector<uint32_t> patch_of;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) patch_of.insert(patch_of.end(), 2, is_left(x, y) ? 0 : 1);
  return patch_of;
}

template <typename Graph>
size_t cut_edges(const Graph& graph, const std::vector<uint32_t>& patch_of) {
  size_t cut = 0;
  for (uint32_t face = 0; face < graph.cell_count(); ++face)
    graph.for_each_link(face, [&](uint32_t next, uint32_t) { cut += patch_of[face] < patch_of[next] ? 1 : 0; });
  return cut;
}

size_t piece_count(const FaceGraph& graph, const std::vector<uint32_t>& patch_of) {
  std::vector<bool> is_seen(graph.cell_count(), false);
  size_t pieces = 0;
  for (uint32_t start = 0; start < graph.cell_count(); ++start) {
    if (is_seen[start]) continue;
    ++pieces;
    is_seen[start] = true;
    std::vector<uint32_t> queue{start};
    for (size_t i = 0; i < queue.size(); ++i)
      graph.for_each_link(queue[i], [&](uint32_t next, uint32_t) {
        if (is_seen[next] || patch_of[next] != patch_of[start]) return;
        is_seen[next] = true;
        queue.push_back(next);
      });
  }
  return pieces;
}

std::vector<uint32_t> all_faces(const FaceGraph& graph) {
  std::vector<uint32_t> all(graph.cell_count());
  for (uint32_t face = 0; face < graph.cell_count(); ++face) all[face] = face;
  return all;
}

TEST(BorderPath, FindsTheStraightBorderBesideAJaggedOne) {
  const FaceGraph graph = squares(20, 10);
  std::vector<uint32_t> patch_of =
      divide(20, 10, [](uint32_t x, uint32_t y) { return x < (y % 2 == 0 ? 8u : 12u); });
  BorderPath border(graph, patch_of);
  ASSERT_TRUE(border.trace(0, 1, all_faces(graph)));
  ASSERT_EQ(border.chains().size(), 1u);
  EXPECT_EQ(border.chains()[0].length(), 10u + 9 * 4);
  border.look_around(border.chains()[0], 6, 6);
  ASSERT_EQ(border.find(-6, 6, BorderPath::Preference::kNearest), 10u);
  ASSERT_TRUE(border.divide());
  EXPECT_EQ(border.to_a().size() + border.to_b().size(), 5u * 4 * 2);  // every second row
  ASSERT_TRUE(border.apply());
  EXPECT_EQ(cut_edges(graph, patch_of), 10u);
  EXPECT_EQ(piece_count(graph, patch_of), 2u);
}

TEST(BorderPath, MovesBetweenItsBounds) {
  const FaceGraph graph = squares(20, 10);
  std::vector<uint32_t> patch_of = divide(20, 10, [](uint32_t x, uint32_t) { return x < 10; });
  BorderPath border(graph, patch_of);
  ASSERT_TRUE(border.trace(0, 1, all_faces(graph)));
  border.look_around(border.chains()[0], 4, 4);
  // As short everywhere: as far as it may go, either way, or not at all.
  ASSERT_EQ(border.find(-3, 4, BorderPath::Preference::kIntoA), 10u);
  ASSERT_TRUE(border.divide());
  EXPECT_EQ(border.to_b().size(), 4u * 10 * 2);
  EXPECT_TRUE(border.to_a().empty());
  ASSERT_EQ(border.find(-3, 4, BorderPath::Preference::kIntoB), 10u);
  ASSERT_TRUE(border.divide());
  EXPECT_EQ(border.to_a().size(), 3u * 10 * 2);
  ASSERT_EQ(border.find(-3, 4, BorderPath::Preference::kNearest), 10u);
  ASSERT_TRUE(border.divide());
  EXPECT_TRUE(border.to_a().empty() && border.to_b().empty());
  // Where it must go.
  ASSERT_EQ(border.find(2, 4, BorderPath::Preference::kNearest), 10u);
  ASSERT_TRUE(border.divide());
  EXPECT_EQ(border.to_b().size(), 2u * 10 * 2);
}

TEST(BorderPath, GoesPastOtherPatchesAndBordersOfTheSamePair) {
  // Patch 2 in the middle of the border: two stretches, each from the rim to it.
  const FaceGraph graph = squares(20, 12);
  std::vector<uint32_t> patch_of =
      divide(20, 12, [](uint32_t x, uint32_t y) { return x < (y % 2 == 0 ? 9u : 11u); });
  for (uint32_t y = 5; y < 7; ++y)
    for (uint32_t x = 8; x < 12; ++x) patch_of[(y * 20 + x) * 2] = patch_of[(y * 20 + x) * 2 + 1] = 2;
  BorderPath border(graph, patch_of);
  ASSERT_TRUE(border.trace(0, 1, all_faces(graph)));
  ASSERT_EQ(border.chains().size(), 2u);
  for (const BorderPath::Chain& chain : border.chains()) {
    border.look_around(chain, 3, 3);
    EXPECT_EQ(border.find(-3, 3, BorderPath::Preference::kNearest), 5u);
    ASSERT_TRUE(border.divide());
    ASSERT_TRUE(border.apply());
  }
  EXPECT_EQ(piece_count(graph, patch_of), 3u);
  EXPECT_EQ(std::count(patch_of.begin(), patch_of.end(), 2u), 16);
}

TEST(BorderPath, LeavesTubesAndFacesThatDisagreeToOthers) {
  const FaceGraph tube = squares(8, 6, true);
  std::vector<uint32_t> patch_of = divide(8, 6, [](uint32_t, uint32_t y) { return y < 3; });
  EXPECT_FALSE(BorderPath(tube, patch_of).trace(0, 1, all_faces(tube)));
  FaceGraph graph = squares(6, 6);
  patch_of = divide(6, 6, [](uint32_t x, uint32_t) { return x < 3; });
  ASSERT_TRUE(BorderPath(graph, patch_of).trace(0, 1, all_faces(graph)));
  // Every second one along the border.
  for (uint32_t face = 5; face < graph.cell_count(); face += 24) {
    std::swap(graph.faces[face].vertices[0], graph.faces[face].vertices[1]);
    std::swap(graph.faces[face].neighbours[1], graph.faces[face].neighbours[2]);
  }
  EXPECT_FALSE(BorderPath(graph, patch_of).trace(0, 1, all_faces(graph)));
}

// Borders of faces are drawn by paths, those of cells by flows: neither finds shorter ones than the other.
TEST(BorderPath, IsAsShortAsALeastCut) {
  const ThreadPool pool(2);
  std::mt19937 random(5);
  const FaceGraph graph = squares(48, 48);
  Coarsening each{std::vector<uint32_t>(graph.cell_count()), graph.cell_count()};
  for (uint32_t face = 0; face < graph.cell_count(); ++face) each.coarse_of[face] = face;
  const CellGraph cells = contract(graph, each, pool);
  size_t by_paths = 0, by_cuts = 0;
  for (int run = 0; run < 5; ++run) {
    // Nine patches with noise of connected squares along their borders.
    std::vector<uint32_t> patch_of(graph.cell_count());
    std::vector<uint32_t> shift(96);
    for (uint32_t& s : shift) s = static_cast<uint32_t>(random() % 5);
    for (uint32_t y = 0; y < 48; ++y)
      for (uint32_t x = 0; x < 48; ++x) {
        const uint32_t column = std::min((x + shift[y]) / 17, 2u),
                       row = std::min((y + shift[48 + column]) / 17, 2u);
        patch_of[(y * 48 + x) * 2] = patch_of[(y * 48 + x) * 2 + 1] = row * 3 + column;
      }
    const std::vector<uint32_t> limits(9, 720);
    std::vector<uint32_t> cut = patch_of;
    recut_borders(graph, limits, {4, 4}, patch_of, pool);
    recut_borders(cells, limits, {4, 4}, cut, pool);
    by_paths += cut_edges(graph, patch_of);
    by_cuts += cut_edges(cells, cut);
    for (uint32_t patch = 0; patch < 9; ++patch)
      EXPECT_LE(std::count(patch_of.begin(), patch_of.end(), patch), 720);
    EXPECT_EQ(piece_count(graph, patch_of), 9u);
  }
  EXPECT_LE(by_paths, by_cuts * 103 / 100);
}

// Patches grown at random on sheets, tubes and tori, with holes or with faces that are repeated, turned, or join
// what is far apart.
TEST(BorderPath, KeepsPatchesOfAnyFacesTogether) {
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

}  // namespace
}  // namespace psplit
