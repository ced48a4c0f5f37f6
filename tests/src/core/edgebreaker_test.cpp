// Edgebreaker on strings that can be followed by hand. edgebreaker.h has a picture of each symbol.
#include "src/core/edgebreaker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "tests/src/core/clers_mesh.h"
#include "tests/support/sanitizers.h"

namespace psplit::core {
namespace {

using Faces = std::vector<ClersMesh::Face>;
using Loops = std::vector<std::vector<uint32_t>>;

TEST(Edgebreaker, EBringsATriangle) {
  const ClersMesh e("E");
  EXPECT_EQ(e.fault, Fault::kNone);
  EXPECT_EQ(e.faces(), (Faces{{0, 1, 2}}));
  EXPECT_EQ(e.borders(), (Loops{{0, 2, 1}}));  // the mesh is on its right
}

TEST(Edgebreaker, RAndLBringAVertexBeyondTheActiveEdge) {
  // The active edge runs from 2 to 1. R goes on with the edge into 1, L with the edge out of 2.
  EXPECT_EQ(ClersMesh("ER").faces(), (Faces{{0, 1, 2}, {2, 1, 3}}));
  EXPECT_EQ(ClersMesh("EL").faces(), (Faces{{0, 1, 2}, {1, 3, 2}}));
  EXPECT_EQ(ClersMesh("ERR").faces().back(), (ClersMesh::Face{3, 1, 4}));
  EXPECT_EQ(ClersMesh("ELL").faces().back(), (ClersMesh::Face{3, 4, 2}));
  EXPECT_EQ(ClersMesh("ERL").borders(), (Loops{{0, 2, 3, 4, 1}}));
}

TEST(Edgebreaker, CClosesAVertex) {
  const ClersMesh fan("ERRC");  // around vertex 1
  EXPECT_EQ(fan.faces(), (Faces{{0, 1, 2}, {2, 1, 3}, {3, 1, 4}, {1, 0, 4}}));
  EXPECT_EQ(fan.borders(), (Loops{{0, 2, 3, 4}}));
  for (uint32_t v = 0; v < 5; ++v) EXPECT_EQ(fan.mesh.closed[v], v == 1) << v;
}

TEST(Edgebreaker, SJoinsTheComponentThatWaits) {
  // The first component waits with its edge from 2 to 1. S merges vertex 4 into 2.
  ClersMesh two("EERS");
  EXPECT_EQ(two.faces(), (Faces{{0, 1, 2}, {3, 2, 5}, {5, 2, 6}, {2, 1, 6}}));
  EXPECT_EQ(two.borders(), (Loops{{0, 2, 3, 5, 6, 1}}));
  // Numbers without gaps: the last vertex takes the place of the merged one, or all move up.
  two.fill_holes();
  EXPECT_EQ(two.faces(), (Faces{{0, 1, 2}, {3, 2, 5}, {5, 2, 4}, {2, 1, 4}}));
  ClersMesh in_order("EERS");
  in_order.move_up();
  EXPECT_EQ(in_order.faces(), (Faces{{0, 1, 2}, {3, 2, 4}, {4, 2, 5}, {2, 1, 5}}));
  // Vertex 6 is merged, and is the last one.
  ClersMesh last("EELS");
  last.fill_holes();
  EXPECT_EQ(last.faces(), (Faces{{0, 1, 2}, {3, 4, 5}, {4, 2, 5}, {2, 1, 5}}));
}

TEST(Edgebreaker, ComponentsWaitInAStack) {
  // The first S joins the third component to the second, the other S both of them to the first.
  const ClersMesh three("EEESS");
  EXPECT_EQ(three.fault, Fault::kNone);
  EXPECT_EQ(three.faces(), (Faces{{0, 1, 2}, {3, 2, 5}, {6, 5, 8}, {5, 2, 8}, {2, 1, 8}}));
  EXPECT_EQ(ClersMesh("EEE").borders().size(), 3u);
}

TEST(Edgebreaker, SplitEventsJoinABorderToItself) {
  // S takes the edge across from corner 1 of face 0, from 0 to 2: the border becomes two, and the strip a ring.
  const ClersMesh ring("ERLRLS", {{0, 5, 1}});
  EXPECT_EQ(ring.fault, Fault::kNone);
  EXPECT_EQ(ring.borders().size(), 2u);
  // A second one joins the two borders, and the ring becomes a handle: a torus with a hole.
  const ClersMesh handle("ELLSS", {{1, 4, 0}, {0, 3, 0}});
  EXPECT_EQ(handle.fault, Fault::kNone);
  EXPECT_EQ(handle.borders().size(), 1u);
  std::set<uint32_t> vertices;
  for (const ClersMesh::Face& face : handle.faces()) vertices.insert(face.begin(), face.end());
  const size_t faces = 5, edges = (3 * faces + handle.borders()[0].size()) / 2;
  EXPECT_EQ(vertices.size() + faces, edges - 1);  // Euler's characteristic: 2 - 2 * handles - borders = -1
}

TEST(Edgebreaker, AStartFaceClosesAHoleOfThreeEdges) {
  const ClersMesh tetrahedron("ERC", {}, 1);
  EXPECT_EQ(tetrahedron.fault, Fault::kNone);
  EXPECT_EQ(tetrahedron.faces(), (Faces{{0, 1, 2}, {2, 1, 3}, {1, 0, 3}, {2, 3, 0}}));
  EXPECT_TRUE(tetrahedron.borders().empty());
  EXPECT_EQ(ClersMesh("ER", {}, 1).fault, Fault::kConnectivity);  // a hole of four
  EXPECT_EQ(ClersMesh("ERC", {}, 2).fault, Fault::kCounts);       // more faces than holes
}

TEST(Edgebreaker, RefusesStringsThatMakeNoMesh) {
  for (const char* first : {"C", "L", "R", "S", "?"}) EXPECT_EQ(ClersMesh(first).fault, Fault::kConnectivity);
  EXPECT_EQ(ClersMesh("E?").fault, Fault::kConnectivity);
  EXPECT_EQ(ClersMesh("ES").fault, Fault::kConnectivity);     // nothing waits
  EXPECT_EQ(ClersMesh("ECC").fault, Fault::kConnectivity);    // a border of two edges is closed to one
  EXPECT_EQ(ClersMesh("EECCS").fault, Fault::kConnectivity);  // and an S follows
  EXPECT_EQ(ClersMesh("E", {}, 0, 2).fault, Fault::kCounts);
  EXPECT_EQ(ClersMesh("ERR", {}, 0, 4).fault, Fault::kCounts);
  EXPECT_EQ(ClersMesh("").fault, Fault::kNone);
}

TEST(Edgebreaker, RefusesSplitEventsThatFitNoSymbol) {
  EXPECT_EQ(ClersMesh("ERRC", {{3, 3, 0}}).fault, Fault::kSplitEvent);               // C sets nothing aside
  EXPECT_EQ(ClersMesh("ERLRLS", {{0, 5, 1}, {1, 5, 1}}).fault, Fault::kSplitEvent);  // they do not descend
  EXPECT_EQ(ClersMesh("ERLRLS", {{0, 5, 0}}).fault, Fault::kNone);
  EXPECT_EQ(ClersMesh("ERLRLS", {{2, 5, 1}}).fault, Fault::kConnectivity);  // that edge has a face by then
}

// On success every corner has its vertex, opposite corners name each other across one edge, and each vertex has
// one fan, which is closed or begins at the border.
void expect_sound(const ClersMesh& decoded) {
  const Connectivity<uint16_t>& mesh = decoded.mesh;
  const CornerTable<uint16_t>& table = mesh.table;
  std::vector<uint32_t> corner_count(mesh.vertex_count);
  for (uint32_t c = 0; c < 4 * mesh.counts.face_count; ++c) {
    if (c % 4 == 3) continue;
    ASSERT_LT(table.vertex[c], mesh.vertex_count);
    ++corner_count[table.vertex[c]];
    const uint16_t across = table.opposite[c];
    if (across == kNone<uint16_t>) continue;
    ASSERT_EQ(table.opposite[across], c);
    ASSERT_EQ(table.vertex[next(across)], table.vertex[previous(c)]);
    ASSERT_EQ(table.vertex[previous(across)], table.vertex[next(c)]);
  }
  for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
    const uint16_t first = mesh.first_corner(static_cast<uint16_t>(v));
    uint32_t met = 0;
    uint16_t at = first;
    for (; at != kNone<uint16_t> && (met == 0 || at != first); at = table.swing_right(at), ++met)
      ASSERT_EQ(table.vertex[at], v);
    ASSERT_EQ(met, corner_count[v]);
    ASSERT_EQ(mesh.closed[v], met > 0 && at == first);
  }
}

// A device stores rows late. Nothing else differs.
void expect_same_by_rows(const ClersMesh& expected, const ClersMesh& by_rows) {
  ASSERT_EQ(by_rows.fault, expected.fault);
  if (expected.fault != Fault::kNone) return;
  const Connectivity<uint16_t>&mesh = expected.mesh, &other = by_rows.mesh;
  ASSERT_EQ(other.vertex_count, mesh.vertex_count);
  ASSERT_EQ(other.merged_count, mesh.merged_count);
  for (uint32_t c = 0; c < 4 * mesh.counts.face_count; ++c) {
    if (c % 4 == 3) continue;
    ASSERT_EQ(other.table.vertex[c], mesh.table.vertex[c]);
    ASSERT_EQ(other.table.opposite[c], mesh.table.opposite[c]);
  }
  for (uint32_t v = 0; v < mesh.vertex_count; ++v)
    ASSERT_EQ(other.first_corner(static_cast<uint16_t>(v)), mesh.first_corner(static_cast<uint16_t>(v)));
}

TEST(Edgebreaker, MakesASoundMeshOfAnyStringOrRefusesIt) {
  std::mt19937 random(1);
  constexpr size_t kRounds = fewer_with_sanitizers(200'000);
  size_t sound = 0, refused = 0, with_events = 0;
  for (size_t round = 0; round < kRounds; ++round) {
    std::string letters = "E";
    for (size_t length = random() % 12; letters.size() < length;) letters += "CLRCLRES"[random() % 8];
    std::vector<SplitEvent> events;
    for (uint32_t split = 1; split < letters.size(); ++split)
      if (letters[split] == 'S' && random() % 2 == 0)
        events.push_back({static_cast<uint32_t>(random() % split), split, static_cast<uint32_t>(random() % 2)});
    std::sort(events.begin(), events.end(), [](auto& a, auto& b) { return a.source > b.source; });
    const auto holes = static_cast<uint32_t>(random() % 3);
    const ClersMesh decoded(letters, events, holes, 100, /*moves_rows=*/false);
    expect_same_by_rows(decoded, ClersMesh(letters, events, holes, 100, /*moves_rows=*/true));
    if (decoded.fault == Fault::kNone) expect_sound(decoded);
    ++(decoded.fault == Fault::kNone ? sound : refused);
    with_events += decoded.fault == Fault::kNone && !events.empty();
    if (HasFatalFailure()) FAIL() << letters;
  }
  EXPECT_GT(sound, kRounds / 20);
  EXPECT_GT(refused, kRounds / 20);
  EXPECT_GT(with_events, kRounds / 2000);
}

TEST(StandardSymbols, TakeOneBitForCAndThreeForTheOthers) {
  const uint8_t bytes[] = {0b01'001'111, 0b0'101'011'1};  // from the lowest bit: E, S, R, L, R, C
  StandardSymbols symbols(BitReader(bytes, sizeof bytes));
  std::vector<uint32_t> read;
  for (int i = 0; i < 6; ++i) read.push_back(symbols.next(0));
  EXPECT_EQ(read, (std::vector<uint32_t>{kE, kS, kR, kL, kR, kC}));
}

}  // namespace
}  // namespace psplit::core
