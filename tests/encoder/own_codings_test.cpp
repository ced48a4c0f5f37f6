// Codings that the caller states for single attributes (MeshToEncode::own_codings).
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "psplit/encode.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

constexpr int kOwnBits = 20;

// A sheet of 40 x 40 cells. Its texture coordinates are in the unit square, but for one that is far away: a
// grid of the usual bits would make the others equal.
Mesh sheet_with_far_texture() {
  Mesh mesh = make_grid(40, 40);
  std::vector<float> texture;
  for (uint32_t i = 0; i < mesh.point_count; ++i)
    texture.insert(texture.end(), {static_cast<float>(i % 41) / 40, static_cast<float>(i / 41) / 40});
  texture[0] = 100000;
  mesh.attributes.push_back(make_attribute("TEXCOORD_0", ComponentType::kFloat32, 2, false, texture));
  return mesh;
}

MeshToEncode planned(Mesh mesh, std::map<size_t, OwnCoding> own_codings) {
  MeshToEncode source{std::move(mesh)};
  source.own_codings = std::move(own_codings);
  MeshToEncode* const meshes[] = {&source};
  const Status status = plan(meshes, {}, ThreadPool(1));
  EXPECT_TRUE(status.ok()) << status.to_string();
  return source;
}

TEST(OwnCodings, ThePrecisionGuardSaysNothingOfThem) {
  const MeshToEncode chosen = planned(sheet_with_far_texture(), {});
  ASSERT_EQ(chosen.notes.size(), 1u);
  EXPECT_NE(chosen.notes[0].text.find("TEXCOORD_0"), std::string::npos);
  const MeshToEncode own = planned(sheet_with_far_texture(), {{1, {kOwnBits}}});
  EXPECT_TRUE(own.notes.empty()) << own.notes[0].text;
  EXPECT_EQ(own.codings[1].bits, kOwnBits);
}

TEST(OwnCodings, DoNotRefineTheGridThatOtherMeshesShare) {
  // Two sheets whose distance is far below a step, in a large box.
  Mesh thin = make_grid(40, 40);
  std::vector<float> positions = values_of<float>(thin.attributes[0]);
  for (size_t at = 2; at < positions.size(); at += 3) positions[at] = 1e-5f;
  Mesh other = thin;
  other.attributes[0] = make_attribute("POSITION", ComponentType::kFloat32, 3, false, positions);
  append_mesh(thin, other);
  const auto bits_of_neighbour = [&](std::map<size_t, OwnCoding> own_codings) {
    MeshToEncode close{thin}, neighbour{make_grid(40, 40)};
    close.own_codings = std::move(own_codings);
    MeshToEncode* const meshes[] = {&close, &neighbour};
    EXPECT_TRUE(plan(meshes, {}, ThreadPool(1)).ok());
    return neighbour.codings[0].bits;
  };
  const int usual = CodingOptions{}.position_bits;
  EXPECT_GT(bits_of_neighbour({}), usual);
  EXPECT_EQ(bits_of_neighbour({{0, {kOwnBits}}}), usual);
}

}  // namespace
}  // namespace psplit
