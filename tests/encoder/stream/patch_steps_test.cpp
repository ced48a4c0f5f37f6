// What libdraco's encoder cannot predict.
#include "encoder/stream/patch_steps.h"

#include "encoder/coding/quantization.h"
#include "encoder/encode_mesh.h"
#include "encoder/welding/weld.h"
#include "psplit/encode.h"
#include "tests/support/expect.h"
#include "tests/support/patched_samples.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/stock_stream.h"

namespace psplit {
namespace {

using Positions = std::vector<float>;
constexpr size_t kPositions = 0, kTexcoords = 1;

// One triangle whose grids begin at 0 and have the range 1.
struct Triangle {
  Mesh mesh;
  WeldedMesh welded;
  PatchMesh patch{{0, 1, 2}, {{0, 1, 2}}, {}};

  Triangle(const Positions& positions, const std::vector<float>& texcoords)
      : mesh(make_mesh(positions, {{0, 1, 2}})) {
    mesh.attributes.push_back(
        make_attribute<float>("TEXCOORD_0", ComponentType::kFloat32, 2, false, texcoords));
    welded = weld(mesh, ThreadPool(1));
  }
  static std::vector<AttributeCoding> codings(int bits, int texture_bits) {
    return {{bits, false, {0, 0, 0}, 1}, {texture_bits, false, {0, 0}, 1}};
  }
  bool may_overflow(int bits, int texture_bits) const {
    return texture_prediction_may_overflow(welded, patch, codings(bits, texture_bits), kTexcoords);
  }
};

const Positions kHalfSquare = {0, 0, 0, 1, 0, 0, 0, 1, 0}, kDiagonal = {0, 0, 0, 1, 1, 1, 1, 1, 0.9f},
                kSmall = {0, 0, 0, 0.5f, 0, 0, 0, 0.5f, 0};
const std::vector<float> kTexture = {0, 0, 1, 0, 1, 1};

TEST(TexturePrediction, OverflowsOnlyWithLongEdgesAndManyBits) {
  EXPECT_TRUE(Triangle(kDiagonal, kTexture).may_overflow(21, 12));
  EXPECT_FALSE(Triangle(kDiagonal, kTexture).may_overflow(20, 12));
  // The cube of 2^21 - 1 is just less than 2^63.
  EXPECT_FALSE(Triangle(kHalfSquare, kTexture).may_overflow(21, 12));
  EXPECT_FALSE(Triangle(kSmall, kTexture).may_overflow(21, 21));
  // Here the texture has the bits.
  EXPECT_TRUE(Triangle(kHalfSquare, kTexture).may_overflow(17, 29));
  EXPECT_FALSE(Triangle(kHalfSquare, {0, 0, 0.1f, 0, 0.1f, 0.1f}).may_overflow(17, 29));
  EXPECT_FALSE(Triangle(kSmall, kTexture).may_overflow(17, 29));
}

TEST(TexturePrediction, DoesNotOverflowIfItIsNotUsed) {
  const Triangle triangle(kDiagonal, kTexture);
  EXPECT_FALSE(triangle.may_overflow(0, 29));  // floats are not predicted from
  EXPECT_FALSE(triangle.may_overflow(21, 0));
  // libdraco has other predictions for these.
  EXPECT_FALSE(triangle.may_overflow(22, 12));
  EXPECT_FALSE(triangle.may_overflow(21, 22));
  EXPECT_FALSE(triangle.may_overflow(17, 30));
}

// libdraco's own prediction fails for some of these meshes.
TEST(TexturePrediction, FailsForNoGrid) {
  const ThreadPool pool(1);
  const Mesh mesh = long_edges();
  for (const int bits : {0, 17, 20, 21, 22})
    for (const int texture_bits : {0, 12, 21, 23})
      for (const int speed : {0, 1, 3, 4}) {
        SCOPED_TRACE(std::to_string(bits) + ", " + std::to_string(texture_bits) + " bits, speed " +
                     std::to_string(speed));
        std::vector<AttributeCoding> codings = fine_codings(mesh, 12);
        codings[kPositions] = bits == 0 ? AttributeCoding() : *fit_grid(mesh.attributes[kPositions], bits);
        codings[2] = texture_bits == 0 ? AttributeCoding() : *fit_grid(mesh.attributes[2], texture_bits);
        const auto encoded = must(encode_mesh(mesh, codings, {.patch_count = 2, .encode_speed = speed}, pool));
        const auto stock = must(encode_stock_stream(mesh, codings, speed));
        constexpr size_t kMethodAt = 8;
        EXPECT_EQ(stock.bytes[kMethodAt], 1);  // Edgebreaker: it did not fall back to a sequential stream
      }
}

}  // namespace
}  // namespace psplit
