#include "encoder/verify.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

// More points and faces than one thread takes at once.
constexpr uint32_t kPoints = 40'000, kFaces = 60'000;

Mesh many_faces() {
  Mesh mesh;
  mesh.point_count = kPoints;
  std::vector<float> values;
  for (uint32_t i = 0; i < kPoints; ++i)
    values.insert(values.end(), {static_cast<float>(i), 0.5f * static_cast<float>(i % 7), -1.0f});
  mesh.attributes = {float_attribute("POSITION", 3, values)};
  for (uint32_t i = 0; i < kFaces; ++i) mesh.faces.push_back({i % kPoints, (i + 1) % kPoints, i * 7 % kPoints});
  return mesh;
}

struct Checked {
  Mesh mesh = many_faces(), decoded = mesh;
  std::vector<uint32_t> source_point = std::vector<uint32_t>(kPoints);

  // Points and faces in another order, and faces that begin with another corner.
  Checked() {
    for (uint32_t i = 0; i < kPoints; ++i) {
      source_point[i] = kPoints - 1 - i;
      std::copy_n(mesh.attributes[0].values.data() + size_t{12} * source_point[i], 12,
                  decoded.attributes[0].values.data() + size_t{12} * i);
    }
    for (auto& face : decoded.faces) {
      for (uint32_t& point : face) point = kPoints - 1 - point;
      std::rotate(face.begin(), face.begin() + face[0] % 3, face.end());
    }
    std::reverse(decoded.faces.begin(), decoded.faces.end());
  }

  std::string error(int threads, std::optional<double>& position_error) const {
    const std::vector<AttributeCoding> exact(1);
    return verify_mesh(mesh, exact, decoded, source_point, 0, false, ThreadPool(threads), position_error)
        .message();
  }
};

TEST(VerifyMesh, TakesPointsAndFacesInAnyOrder) {
  const Checked checked;
  for (const int threads : {1, 3}) {
    std::optional<double> position_error;
    EXPECT_EQ(checked.error(threads, position_error), "");
    EXPECT_EQ(position_error, 0);
  }
}

TEST(VerifyMesh, NamesAFaceThatDidNotComeBack) {
  for (const int threads : {1, 3}) {
    std::optional<double> position_error;
    Checked turned;
    std::array<uint32_t, 3>& face = turned.decoded.faces[kFaces - 1 - 50'000];  // 10000, 10001, 30000
    std::swap(face[0], face[1]);
    EXPECT_NE(turned.error(threads, position_error).find("face of points 10000, 10001, 30000 did not"),
              std::string::npos)
        << turned.error(threads, position_error);
    Checked repeated;
    repeated.decoded.faces[7] = repeated.decoded.faces[8];
    EXPECT_NE(repeated.error(threads, position_error).find("did not come back"), std::string::npos);
  }
}

TEST(VerifyMesh, NamesThePointOfAWrongValue) {
  for (const int threads : {1, 3}) {
    std::optional<double> position_error;
    Checked checked;
    checked.decoded.attributes[0].values[12 * 30'000] ^= std::byte{1};
    checked.decoded.attributes[0].values[12 * 35'000] ^= std::byte{1};
    EXPECT_NE(checked.error(threads, position_error).find("POSITION of point 9999 came back"),
              std::string::npos)
        << checked.error(threads, position_error);
  }
}

}  // namespace
}  // namespace psplit
