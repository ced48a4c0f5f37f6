#include "tools/gltf_psplit/shapes/character.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/reproducible_meshes.h"

namespace psplit {
namespace {

const Character& hero() {
  static const Character made = must(generate_character(12000, 1, ThreadPool(2)));
  return made;
}

using Triple = std::array<float, 3>;
std::vector<Triple> triples(const char* semantic) {
  const std::vector<float> values = values_of<float>(*hero().mesh.find(semantic));
  std::vector<Triple> found(values.size() / 3);
  for (size_t i = 0; i < values.size(); ++i) found[i / 3][i % 3] = values[i];
  return found;
}

TEST(Character, HasAboutTheNumberOfFacesAskedFor) {
  EXPECT_NEAR(static_cast<double>(hero().mesh.faces.size()), 12000, 240);
  EXPECT_EQ(generate_character(7, 1, ThreadPool(1)).status().code(), StatusCode::kUsage);
}

TEST(Character, HasSeamsInNormalsAndInTextureCoordinates) {
  const std::vector<Triple> positions = triples("POSITION"), normals = triples("NORMAL");
  std::map<Triple, std::vector<size_t>> points_at;
  for (size_t i = 0; i < positions.size(); ++i) points_at[positions[i]].push_back(i);
  size_t with_one_normal = 0, with_several = 0;
  for (const auto& entry : points_at) {
    const std::vector<size_t>& points = entry.second;
    if (points.size() == 1) continue;
    const bool is_smooth =
        std::ranges::all_of(points, [&](size_t i) { return normals[i] == normals[points[0]]; });
    ++(is_smooth ? with_one_normal : with_several);
  }
  EXPECT_GT(with_one_normal, positions.size() / 50);  // seams of the texture alone
  EXPECT_GT(with_several, positions.size() / 200);    // where garments meet
  for (const float value : values_of<float>(*hero().mesh.find("TEXCOORD_0")))
    EXPECT_TRUE(value >= 0 && value <= 1) << value;
  for (const Triple& n : normals) EXPECT_NEAR(std::hypot(n[0], n[1], n[2]), 1, 1e-5);
}

TEST(Character, IsClosedAndOriented) {
  std::map<Triple, uint32_t> numbers;
  std::vector<uint32_t> vertex;
  for (const Triple& position : triples("POSITION"))
    vertex.push_back(numbers.try_emplace(position, static_cast<uint32_t>(numbers.size())).first->second);
  std::set<std::pair<uint32_t, uint32_t>> edges;
  for (const auto& face : hero().mesh.faces)
    for (size_t k = 0; k < 3; ++k)
      EXPECT_TRUE(edges.insert({vertex[face[k]], vertex[face[(k + 1) % 3]]}).second);
  for (const auto& [from, to] : edges) EXPECT_TRUE(edges.contains({to, from}));
}

TEST(Character, IsMovedByItsJoints) {
  const std::vector<float> weights = values_of<float>(*hero().mesh.find("WEIGHTS_0"));
  const std::vector<uint8_t> joints = values_of<uint8_t>(*hero().mesh.find("JOINTS_0"));
  std::set<uint8_t> used;
  size_t blended = 0;
  for (size_t i = 0; i < weights.size(); i += 4) {
    EXPECT_NEAR(weights[i] + weights[i + 1] + weights[i + 2] + weights[i + 3], 1, 1e-6);
    blended += weights[i + 1] > 0;
    for (size_t k = 0; k < 4; ++k) {
      ASSERT_LT(joints[i + k], hero().joints.size());
      if (weights[i + k] > 0) used.insert(joints[i + k]);
    }
  }
  EXPECT_EQ(used.size(), hero().joints.size());
  EXPECT_GT(blended, weights.size() / 4 / 5);
  for (size_t j = 0; j < hero().joints.size(); ++j) {
    EXPECT_LT(hero().joints[j].parent, static_cast<int>(j));
    ASSERT_EQ(hero().joints[j].rotations.size(), hero().times.size());
    for (const auto& [x, y, z, w] : hero().joints[j].rotations)
      EXPECT_NEAR(x * x + y * y + z * z + w * w, 1, 1e-5);
  }
  EXPECT_EQ(hero().translations.size(), hero().times.size());
  EXPECT_EQ(hero().weights.size(), hero().times.size() * hero().targets.size());
}

// The normals of a target are those of the moved surface: perpendicular to its moved edges, as before.
TEST(Character, HasTargetsThatMoveSomePoints) {
  const std::vector<Triple> normals = triples("NORMAL");
  for (const CharacterTarget& target : hero().targets) {
    ASSERT_EQ(target.positions.size(), hero().mesh.point_count);
    ASSERT_EQ(target.normals.size(), hero().mesh.point_count);
    size_t moved = 0, turned = 0;
    for (size_t i = 0; i < normals.size(); ++i) {
      moved += target.positions[i] != Triple{};
      turned += target.normals[i] != Triple{};
      const Triple n = {normals[i][0] + target.normals[i][0], normals[i][1] + target.normals[i][1],
                        normals[i][2] + target.normals[i][2]};
      EXPECT_NEAR(std::hypot(n[0], n[1], n[2]), 1, 1e-5) << target.name;
    }
    EXPECT_GT(moved, 10u) << target.name;
    EXPECT_GT(turned, 10u) << target.name;
    EXPECT_LT(moved, normals.size() / 2) << target.name;
  }
}

// A hash of all values, so that a change of the generator shows here.
TEST(Character, IsTheSameForAnyNumberOfThreadsAndOnAnyMachine) {
  for (const int threads : {1, 3}) {
    const Character character = must(generate_character(3000, 2, ThreadPool(threads)));
    std::vector<uint8_t> bytes;
    const auto add = [&](const auto& values) {
      const auto* begin = reinterpret_cast<const uint8_t*>(values.data());
      bytes.insert(bytes.end(), begin, begin + values.size() * sizeof(values[0]));
    };
    add(character.mesh.faces);
    for (const Attribute& attribute : character.mesh.attributes) add(attribute.values);
    for (const CharacterTarget& target : character.targets) {
      add(target.positions);
      add(target.normals);
    }
    for (const CharacterJoint& joint : character.joints) add(joint.rotations);
    add(character.translations);
    add(character.weights);
    EXPECT_EQ(fnv1a(bytes), 14535653108268234819u);
  }
}

}  // namespace
}  // namespace psplit
