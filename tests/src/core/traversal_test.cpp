// The two walks over the faces, on meshes that can be followed by hand.
#include "src/core/traversal.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "tests/src/core/clers_mesh.h"
#include "tests/support/sanitizers.h"

namespace psplit::core {
namespace {

struct Order {
  Fault fault = Fault::kNone;
  std::vector<uint32_t> vertices;  // in the order of their values

  bool operator==(const Order&) const = default;
};

// Walks with exactly the memory that `bytes` says. `extra` vertices have no corner.
template <typename Traversal>
Order walk(const ClersMesh& decoded, size_t bytes, uint32_t extra = 0) {
  const Connectivity<uint16_t>& mesh = decoded.mesh;
  const uint32_t count = mesh.vertex_count + extra;
  const AttributeTable<uint16_t> table{mesh.table, mesh.closed, count, false};
  std::vector<uint8_t> memory(Sequence<uint16_t>::bytes(count) + bytes);
  Arena arena(memory.data(), memory.size());
  Sequence<uint16_t> sequence;
  Traversal traversal;
  if (!sequence.allocate(count, arena)) return {Fault::kWorkspace, {}};
  if (const Fault fault = traversal.start(table, arena, sequence); fault != Fault::kNone) return {fault, {}};
  while (traversal.steps_left() > 0) traversal.step();
  Order order{traversal.finish(), {}};
  for (uint32_t i = 0; i < mesh.vertex_count && order.fault == Fault::kNone; ++i) {
    order.vertices.push_back(mesh.table.vertex[sequence.corner[i]]);
    EXPECT_EQ(sequence.rank[order.vertices.back()], i);
  }
  return order;
}
Order depth_first(const ClersMesh& decoded, uint32_t extra = 0) {
  using Traversal = DepthFirstTraversal<uint16_t>;
  return walk<Traversal>(decoded, Traversal::bytes(decoded.mesh.counts.face_count), extra);
}
Order by_prediction_degree(const ClersMesh& decoded, uint32_t extra = 0) {
  using Traversal = PredictionDegreeTraversal<uint16_t>;
  const uint32_t vertex_count = decoded.mesh.vertex_count + extra;
  return walk<Traversal>(decoded, Traversal::bytes(decoded.mesh.counts.face_count, vertex_count), extra);
}

TEST(Traversal, BeginsWithTheFirstFace) {
  // First the vertices at its corners 1 and 2, then the one at corner 0.
  EXPECT_EQ(depth_first(ClersMesh("E")), (Order{Fault::kNone, {1, 2, 0}}));
  EXPECT_EQ(by_prediction_degree(ClersMesh("E")), (Order{Fault::kNone, {1, 2, 0}}));
}

TEST(Traversal, TurnsLeftWhereNothingIsOnTheRight) {
  // A fan around vertex 1: the edges on the right are the border.
  EXPECT_EQ(depth_first(ClersMesh("ERRC")), (Order{Fault::kNone, {1, 2, 0, 4, 3}}));
  EXPECT_EQ(by_prediction_degree(ClersMesh("ERRC")), (Order{Fault::kNone, {1, 2, 0, 4, 3}}));
}

TEST(Traversal, DepthGoesOnWhereThePredictionDegreeTurnsBack) {
  // Faces (0, 1, 2), (2, 1, 3), (3, 1, 4), (1, 0, 4), (0, 2, 4), (2, 5, 4). Both walks go from the first face
  // to the fifth, which brings vertex 4. Depth first goes on to the right, to vertex 5. The vertices of the
  // fourth face are all known by then, so the other walk visits it next, and comes to vertex 3.
  EXPECT_EQ(depth_first(ClersMesh("ERRCCL")), (Order{Fault::kNone, {1, 2, 0, 4, 5, 3}}));
  EXPECT_EQ(by_prediction_degree(ClersMesh("ERRCCL")), (Order{Fault::kNone, {1, 2, 0, 4, 3, 5}}));
}

TEST(Traversal, VerticesThatTwoFacesPredictComeFirst) {
  // Faces (0, 1, 2), (2, 1, 3), (1, 0, 3), (3, 0, 4), (0, 2, 4), (2, 5, 4). Both walks visit the first and the
  // fifth, which bring vertices 0 and 4. Then a face on the left of each has vertex 3, and one face on the
  // right has vertex 5.
  EXPECT_EQ(depth_first(ClersMesh("ERCRCL")), (Order{Fault::kNone, {1, 2, 0, 4, 5, 3}}));
  EXPECT_EQ(by_prediction_degree(ClersMesh("ERCRCL")), (Order{Fault::kNone, {1, 2, 0, 4, 3, 5}}));
}

TEST(Traversal, PredictionDegreeTurnsRightIfThatIsAsGood) {
  // Faces (0, 1, 2), (2, 1, 3), (3, 1, 4), (1, 0, 4), (0, 5, 4). From the fourth face, the one on the right has
  // vertex 5 and the one on the left has vertex 3.
  EXPECT_EQ(by_prediction_degree(ClersMesh("ERRCL")), (Order{Fault::kNone, {1, 2, 0, 4, 5, 3}}));
}

TEST(Traversal, TakesTheComponentsInOrder) {
  EXPECT_EQ(depth_first(ClersMesh("EE")), (Order{Fault::kNone, {1, 2, 0, 4, 5, 3}}));
  EXPECT_EQ(by_prediction_degree(ClersMesh("EE")), (Order{Fault::kNone, {1, 2, 0, 4, 5, 3}}));
}

TEST(Traversal, RefusesVerticesWithoutFaces) {
  EXPECT_EQ(depth_first(ClersMesh("ER"), 1).fault, Fault::kConnectivity);
  EXPECT_EQ(by_prediction_degree(ClersMesh("ER"), 1).fault, Fault::kConnectivity);
}

TEST(Traversal, MeetsEachVertexOfAnyMeshOnce) {
  std::mt19937 random(1);
  constexpr size_t kRounds = fewer_with_sanitizers(20'000);
  size_t meshes = 0;
  for (size_t round = 0; round < kRounds; ++round) {
    std::string letters = "E";
    for (size_t length = 1 + random() % 20; letters.size() < length;) letters += "CLRCLRES"[random() % 8];
    ClersMesh decoded(letters);
    if (decoded.fault != Fault::kNone) continue;
    decoded.fill_holes();
    ++meshes;
    for (const Order& order : {depth_first(decoded), by_prediction_degree(decoded)}) {
      ASSERT_EQ(order.fault, Fault::kNone) << letters;
      const std::set<uint32_t> met(order.vertices.begin(), order.vertices.end());
      ASSERT_EQ(met.size(), decoded.mesh.vertex_count) << letters;
    }
  }
  EXPECT_GT(meshes, kRounds / 20);
}

}  // namespace
}  // namespace psplit::core
