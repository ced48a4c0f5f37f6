// The border walk of small patches. decode_patch_test compares walks of whole streams with the definition.
#include "src/core/border_walk.h"

#include <gtest/gtest.h>

#include "tests/src/core/clers_mesh.h"

namespace psplit::core {
namespace {

// The walk of a mesh whose points are its vertices. Or `point_at` has the point at each corner; then all
// vertices are said to be on seams.
std::vector<uint32_t> walk_of(ClersMesh&& decoded, std::vector<uint16_t> point_at = {}) {
  Patch<uint16_t> patch;
  decoded.move_up();
  patch.mesh = decoded.mesh;
  patch.face_count = decoded.mesh.counts.face_count;
  patch.point_at = patch.mesh.table.vertex;
  patch.point_count = patch.mesh.vertex_count;
  std::vector<uint16_t> corner_of_point(100);
  bool on_seam[100];
  if (!point_at.empty()) {
    patch.point_at = View<uint16_t>(point_at.data(), point_at.size());
    patch.point_count = 0;
    for (const uint16_t point : point_at)
      if (point + 1u > patch.point_count) patch.point_count = point + 1u;
    patch.corner_of_point = View<uint16_t>(corner_of_point.data(), patch.point_count);
    patch.on_seam = View<bool>(on_seam, patch.mesh.vertex_count);
    fill(patch.on_seam, true);
  }
  std::vector<uint8_t> memory(border_walk_bytes<uint16_t>(patch.point_count));
  Arena arena(memory.data(), memory.size());
  View<uint16_t> walk;
  EXPECT_EQ(walk_border(patch, arena, walk), Fault::kNone);
  return std::vector<uint32_t>(walk.data(), walk.data() + walk.size());
}

using Points = std::vector<uint32_t>;

TEST(BorderWalk, RunsWithTheMeshOnItsLeftFromTheLowestPoint) {
  EXPECT_EQ(walk_of(ClersMesh("E")), (Points{0, 1, 2}));
  EXPECT_EQ(walk_of(ClersMesh("ERRC")), (Points{0, 4, 3, 2}));
  EXPECT_EQ(walk_of(ClersMesh("EERS")), (Points{0, 1, 5, 4, 3, 2}));
}

TEST(BorderWalk, TakesOneLoopAfterTheOther) { EXPECT_EQ(walk_of(ClersMesh("EE")), (Points{0, 1, 2, 3, 4, 5})); }

TEST(BorderWalk, IsEmptyWithoutABorder) { EXPECT_TRUE(walk_of(ClersMesh("ERC", {}, 1)).empty()); }

TEST(BorderWalk, SeamsBetweenPointsAreBorders) {
  // Faces (0, 1, 2) and (2, 1, 3) share an edge. Joined by their points the seam is inside; with points of
  // their own they are two loops.
  EXPECT_EQ(walk_of(ClersMesh("ER"), {0, 1, 2, 0, 2, 1, 3, 0}), (Points{0, 1, 3, 2}));
  EXPECT_EQ(walk_of(ClersMesh("ER"), {0, 1, 2, 0, 5, 4, 3, 0}), (Points{0, 1, 2, 3, 5, 4}));
}

TEST(BorderWalk, IsEmptyIfTwoOfItsEdgesLeaveAPoint) {
  EXPECT_TRUE(walk_of(ClersMesh("EE"), {0, 1, 2, 0, 0, 3, 4, 0}).empty());
}

}  // namespace
}  // namespace psplit::core
