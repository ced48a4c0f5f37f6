#include "encoder/kept_grids.h"

#include <cmath>
#include <cstring>
#include <vector>

#include "encoder/coding/grid_places.h"
#include "encoder/shared_codings.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

// A flat grid of points whose first coordinates are the lowest, some, and the last place of `grid`.
Mesh mesh_on(const AttributeCoding& grid) {
  Mesh mesh = make_grid(4, 4);
  const float places = static_cast<float>((1u << grid.bits) - 1), step = grid.range / places;
  std::vector<float> values(3 * mesh.point_count);
  for (size_t i = 0; i < values.size(); ++i) {
    const float place = i == values.size() - 3 ? places : static_cast<float>(i);
    values[i] = place * step + grid.origin[i % 3];
  }
  std::memcpy(mesh.attributes[0].values.data(), values.data(), values.size() * sizeof(float));
  return mesh;
}

// By how much the last place is decoded beyond the range.
double excess(const AttributeCoding& grid) {
  const float places = static_cast<float>((1u << grid.bits) - 1), step = grid.range / places;
  const float last = places * step + grid.origin[0];
  return double{last} - double{grid.origin[0]} - double{grid.range};
}

AttributeCoding chosen_for(Mesh mesh, const AttributeCoding& stated) {
  mesh.attributes.resize(1);
  MeshToEncode source{std::move(mesh)};
  source.stated = {stated};
  MeshToEncode* const meshes[] = {&source};
  EncodeOptions options;
  options.keep_unused = true;
  return choose_shared_codings(meshes, options, ThreadPool(1)).codings[0][0];
}

// A stream with a value beyond the range states a larger range, so that it cannot be on the stated grid.
TEST(KeptGrids, AGridIsKeptUnlessItsLastPlaceIsBeyondItsRange) {
  int kept = 0, beyond = 0;
  for (int i = 0; i < 400 && (kept < 20 || beyond < 20); ++i) {
    AttributeCoding grid;
    grid.bits = 14;
    grid.origin = {0.3f + 0.01f * static_cast<float>(i), -1.0f, 0.25f};
    grid.range = 1.7f + 0.003f * static_cast<float>(i);
    const Mesh mesh = mesh_on(grid);
    ASSERT_TRUE(is_on_grid(mesh.attributes[0], grid, std::vector<uint8_t>(mesh.point_count, 1)));
    const AttributeCoding chosen = chosen_for(mesh, grid);
    const bool is_kept = chosen.origin == grid.origin && chosen.range == grid.range && chosen.bits == grid.bits;
    EXPECT_EQ(is_kept, excess(grid) <= 0) << grid.origin[0] << " " << grid.range;
    ++(excess(grid) > 0 ? beyond : kept);
  }
  EXPECT_GE(kept, 20);
  EXPECT_GE(beyond, 20);
}

}  // namespace
}  // namespace psplit
