// Seams on a fan of four faces around vertex 1, and on random meshes against sets of corners.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <random>
#include <set>

#include "src/core/seam_lanes.h"
#include "tests/src/core/clers_mesh.h"
#include "tests/support/emulated_warp.h"
#include "tests/support/sanitizers.h"

namespace psplit::core {
namespace {

template <typename T>
View<T> view(std::vector<T>& values) {
  return View<T>(values.data(), values.size());
}

struct SeamedMesh {
  explicit SeamedMesh(const std::string& letters) : decoded(letters) {
    decoded.move_up();
    scratch.resize(decoded.mesh.vertex_count);
    edges.resize(3 * decoded.mesh.counts.face_count);
    edges.resize(list_inner_edges(decoded.mesh.table, view(edges)));
    on_seam = std::make_unique<bool[]>(scratch.size());
    on_any_seam = std::make_unique<bool[]>(scratch.size());
  }

  // `seams` has a byte for each inner edge.
  void add_attribute(std::vector<uint8_t> seams) {
    ASSERT_EQ(seams.size(), edges.size());
    const size_t bytes = AttributeTable<uint16_t>::bytes(decoded.mesh.counts.face_count);
    memory.emplace_back(bytes);
    Arena arena(memory.back().data(), bytes);
    AttributeTable<uint16_t> table;
    const View<bool> ends(on_seam.get(), scratch.size());
    fill(ends, false);
    ASSERT_EQ(cut_seams(decoded.mesh, view(edges), view(seams), arena, table, ends), Fault::kNone);
    ASSERT_EQ(table.has_seams, std::count(seams.begin(), seams.end(), 1) > 0);
    AttributeTable<uint16_t>* const one = &table;
    if (table.has_seams) splitter().split(&one, 1, View<const bool>(ends), {});
    for (size_t v = 0; v < ends.size(); ++v) on_any_seam[v] |= ends[v];
    attributes.push_back(table);
  }
  // Tables of their own get the same values when they are split together. With a single table that has seams,
  // points follow from its values.
  uint32_t split() {
    points = {decoded.mesh.table.vertex.data(),
              decoded.mesh.table.vertex.data() + decoded.mesh.table.vertex.size()};
    std::vector<AttributeTable<uint16_t>> tables;
    for (const AttributeTable<uint16_t>& table : attributes)
      if (table.has_seams) tables.push_back(table);
    if (tables.empty()) return decoded.mesh.vertex_count;
    std::vector<std::vector<uint16_t>> values;
    std::vector<AttributeTable<uint16_t>*> cut;
    for (AttributeTable<uint16_t>& table : tables) {
      values.emplace_back(table.table.vertex.data(), table.table.vertex.data() + table.table.vertex.size());
      table.vertex_count = decoded.mesh.vertex_count;
      cut.push_back(&table);
    }
    VertexSplit<uint16_t> together = splitter();
    std::vector<uint16_t> numbers(points.size());
    together.split(cut.data(), static_cast<uint32_t>(cut.size()),
                   View<const bool>(on_any_seam.get(), scratch.size()), view(numbers));
    for (size_t i = 0; i < tables.size(); ++i)
      for (size_t c = 0; c < points.size(); ++c)
        EXPECT_TRUE(c % 4 == 3 || tables[i].table.vertex[c] == values[i][c]);
    std::vector<uint16_t> corner_of_point(together.count());
    together.store(view(points), view(corner_of_point));
    for (uint32_t point = 0; point < together.count(); ++point)
      EXPECT_EQ(points[corner_of_point[point]], point);
    return together.count();
  }
  VertexSplit<uint16_t> splitter() {
    around.resize(3 * decoded.mesh.counts.face_count);
    changes.resize(around.size());
    return {decoded.mesh, view(around), view(changes), view(scratch)};
  }

  ClersMesh decoded;
  std::vector<uint16_t> edges, scratch, points, around;
  std::vector<uint8_t> changes;
  std::vector<AttributeTable<uint16_t>> attributes;
  std::vector<std::vector<uint8_t>> memory;
  std::unique_ptr<bool[]> on_seam, on_any_seam;
};

// Faces (0, 1, 2), (2, 1, 3), (3, 1, 4), (1, 0, 4), with these corners at vertex 1.
constexpr const char* kFanSymbols = "ERRC";
constexpr uint32_t kAtCenter[] = {1, 5, 9, 12};

TEST(Seams, EveryInnerEdgeIsListedOnceByTheFirstOfItsFaces) {
  // Edges 1-2, 0-1, 1-3 and 1-4 of the fan.
  EXPECT_EQ(SeamedMesh(kFanSymbols).edges, (std::vector<uint16_t>{0, 2, 4, 8}));
  EXPECT_TRUE(SeamedMesh("E").edges.empty());
}

TEST(Seams, WithoutSeamsAnAttributeSharesTheMeshsTable) {
  SeamedMesh fan(kFanSymbols);
  fan.add_attribute({0, 0, 0, 0});
  EXPECT_EQ(fan.attributes[0].table.vertex.data(), fan.decoded.mesh.table.vertex.data());
  EXPECT_EQ(fan.attributes[0].vertex_count, 5u);
}

TEST(Seams, ASeamSplitsTheVertexAtItsEndOnTheBorder) {
  SeamedMesh fan(kFanSymbols);
  fan.add_attribute({1, 0, 0, 0});  // edge 1-2: vertex 2 has two values, vertex 1 has one all around
  const View<uint16_t> value = fan.attributes[0].table.vertex;
  EXPECT_EQ(fan.attributes[0].vertex_count, 6u);
  EXPECT_NE(value[2], value[4]);
  for (const uint32_t corner : kAtCenter) EXPECT_EQ(value[corner], value[kAtCenter[0]]);
  EXPECT_FALSE(fan.attributes[0].closed[value[kAtCenter[0]]]);  // a seam ends there
  EXPECT_EQ(fan.split(), 6u);
}

TEST(Seams, TwoSeamsSplitTheVertexBetweenThem) {
  SeamedMesh fan(kFanSymbols);
  fan.add_attribute({1, 0, 1, 0});  // edges 1-2 and 1-3 cut out the second face
  const View<uint16_t> value = fan.attributes[0].table.vertex;
  EXPECT_EQ(fan.attributes[0].vertex_count, 8u);
  EXPECT_NE(value[5], value[1]);
  EXPECT_EQ(value[9], value[1]);
  EXPECT_EQ(value[12], value[1]);
}

TEST(Seams, PointsAreSplitWhereAnyAttributeIs) {
  SeamedMesh fan(kFanSymbols);
  fan.add_attribute({1, 0, 0, 0});  // splits vertex 2
  fan.add_attribute({0, 0, 1, 0});  // splits vertex 3
  EXPECT_EQ(fan.split(), 7u);
  EXPECT_NE(fan.points[2], fan.points[4]);
  EXPECT_NE(fan.points[6], fan.points[8]);
  for (const uint32_t corner : kAtCenter) EXPECT_EQ(fan.points[corner], fan.points[kAtCenter[0]]);
}

TEST(Seams, NeedTheMemoryThatTheySay) {
  ClersMesh fan(kFanSymbols);
  Arena none;
  AttributeTable<uint16_t> table;
  uint16_t edges[] = {0};
  uint8_t seams[] = {1};
  bool on_seam[5];
  EXPECT_EQ(cut_seams(fan.mesh, View<uint16_t>(edges, 1), View<uint8_t>(seams, 1), none, table,
                      View<bool>(on_seam, 5)),
            Fault::kWorkspace);
}

// Sets of corners. Numbers that the stage gave are right if two corners have the same exactly when they are in
// one set.
struct CornerSets {
  explicit CornerSets(size_t count) : parent(count) { std::iota(parent.begin(), parent.end(), 0u); }
  uint32_t find(uint32_t c) { return parent[c] == c ? c : parent[c] = find(parent[c]); }
  void join(uint32_t a, uint32_t b) { parent[find(a)] = find(b); }

  template <typename Numbers>
  void expect_equal(const Numbers& number, uint32_t count) {
    std::map<uint32_t, uint32_t> set_of;
    for (uint32_t c = 0; c < parent.size(); ++c) {
      if (c % 4 == 3) continue;
      ASSERT_LT(number[c], count);
      ASSERT_EQ(set_of.emplace(number[c], find(c)).first->second, find(c));
    }
    std::set<uint32_t> sets;
    for (const auto& [ignored, set] : set_of) sets.insert(set);
    ASSERT_EQ(set_of.size(), count);
    ASSERT_EQ(sets.size(), count);
  }
  std::vector<uint32_t> parent;
};

// The twins of seams.h give the same numbers in any order of the lanes.
void expect_same_by_lanes(SeamedMesh& made, const std::vector<std::vector<uint8_t>>& seams, LaneOrder order) {
  const Connectivity<uint16_t>& mesh = made.decoded.mesh;
  const uint32_t point_count = made.split();
  std::vector<uint16_t> edges(made.edges.size() + 3 * mesh.counts.face_count), scratch(mesh.vertex_count),
      point_at(mesh.table.vertex.size()), corner_of_point(point_count);
  const auto on_seam = std::make_unique<bool[]>(mesh.vertex_count);
  std::vector<std::vector<uint8_t>> memory;
  std::vector<AttributeTable<uint16_t>> attributes;
  for (const std::vector<uint8_t>& bits : seams) {
    attributes.push_back(
        {mesh.table, mesh.closed, mesh.vertex_count, std::count(bits.begin(), bits.end(), 1) > 0});
    memory.emplace_back(AttributeTable<uint16_t>::bytes(mesh.counts.face_count));
    Arena arena(memory.back().data(), memory.back().size());
    if (attributes.back().has_seams) {
      ASSERT_TRUE(attributes.back().allocate(mesh.counts.face_count, arena));
    }
  }
  uint32_t edge_count = 0, points = 0;
  run_warp(
      [&](EmulatedLanes lanes) {
        const View<bool> ends(on_seam.get(), mesh.vertex_count);
        const uint32_t count = list_inner_edges(lanes, mesh.table, view(edges));
        if (lanes.rank() == 0) edge_count = count;
        for (size_t i = 0; i < seams.size(); ++i) {
          AttributeTable<uint16_t>& table = attributes[i];
          if (!table.has_seams) continue;
          cut_seams(lanes, mesh.table.opposite, view(edges),
                    View<const uint8_t>(seams[i].data(), seams[i].size()), table.table.opposite);
          const uint32_t values = number_attribute_vertices(lanes, mesh, table, view(scratch), ends);
          if (lanes.rank() == 0) table.vertex_count = values;
          lanes.sync();
        }
        const PointSplit<uint16_t> split(mesh, view(attributes), ends, view(scratch));
        const uint32_t split_count = split.count(lanes);
        if (lanes.rank() == 0) points = split_count;
        split.store(lanes, view(point_at), view(corner_of_point));
      },
      order);
  edges.resize(edge_count);
  ASSERT_EQ(edges, made.edges);
  ASSERT_EQ(points, point_count);
  for (uint32_t c = 0; c < point_at.size(); ++c) {
    if (c % 4 == 3) continue;
    ASSERT_EQ(point_at[c], made.points[c]);
    for (size_t i = 0; i < seams.size(); ++i) {
      ASSERT_EQ(attributes[i].table.opposite[c], made.attributes[i].table.opposite[c]);
      ASSERT_EQ(attributes[i].table.vertex[c], made.attributes[i].table.vertex[c]);
    }
  }
  for (uint32_t point = 0; point < points; ++point) ASSERT_EQ(point_at[corner_of_point[point]], point);
  for (size_t i = 0; i < seams.size(); ++i) {
    ASSERT_EQ(attributes[i].vertex_count, made.attributes[i].vertex_count);
    for (uint32_t value = 0; value < attributes[i].vertex_count; ++value)
      ASSERT_EQ(attributes[i].closed[value], made.attributes[i].closed[value]);
  }
}

TEST(Seams, NumberValuesAndPointsOfRandomMeshes) {
  std::mt19937 random(1);
  size_t seamed = 0;
  for (size_t round = 0; round < fewer_with_sanitizers(5000); ++round) {
    std::string letters = "E";
    // Every tenth mesh is a fan, of few corners or many, and every other fan has few seams: edges are looked at
    // 32 at a time.
    const bool is_fan = round % 10 == 0, is_sparse = round % 20 == 0;
    if (is_fan)
      letters.append(20 + random() % (is_sparse ? 300 : 30), 'R').append(random() % 2, 'C');
    else
      for (size_t length = 1 + random() % 20; letters.size() < length;) letters += "CLRCLRES"[random() % 8];
    if (ClersMesh(letters).fault != Fault::kNone) continue;
    SeamedMesh made(letters);
    const CornerTable<uint16_t>& table = made.decoded.mesh.table;
    std::vector<std::vector<uint8_t>> all_seams;
    const size_t attribute_count = 1 + random() % 6;
    for (size_t i = 0; i < attribute_count; ++i) {
      std::vector<uint8_t> seams;
      while (seams.size() < made.edges.size()) seams.push_back(random() % (is_sparse ? 60 : 3) == 0);
      made.add_attribute(seams);
      all_seams.push_back(seams);
      // Two corners at the end of an inner edge have the same value if the edge is not a seam.
      CornerSets values(table.opposite.size());
      for (size_t e = 0; e < seams.size(); ++e) {
        const uint16_t c = made.edges[e], across = table.opposite[c];
        if (seams[e] != 0) continue;
        values.join(next(c), previous(across));
        values.join(previous(c), next(across));
      }
      seamed += made.attributes.back().has_seams;
      values.expect_equal(made.attributes.back().table.vertex, made.attributes.back().vertex_count);
    }
    // They are the same point if all attributes have the same value.
    CornerSets points(table.opposite.size());
    const auto join_if_same = [&](uint16_t a, uint16_t b) {
      for (const AttributeTable<uint16_t>& attribute : made.attributes)
        if (attribute.has_seams && attribute.table.vertex[a] != attribute.table.vertex[b]) return;
      points.join(a, b);
    };
    for (const uint16_t c : made.edges) {
      join_if_same(next(c), previous(table.opposite[c]));
      join_if_same(previous(c), next(table.opposite[c]));
    }
    points.expect_equal(made.points, made.split());
    expect_same_by_lanes(made, all_seams, kLaneOrders[seamed % kLaneOrders.size()]);
    if (HasFatalFailure()) FAIL() << letters;
  }
  EXPECT_GT(seamed, fewer_with_sanitizers(1000));
}

}  // namespace
}  // namespace psplit::core
