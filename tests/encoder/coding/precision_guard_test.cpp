// Grids that would make equal what a mesh tells apart become finer, or the values exact.
#include "encoder/coding/precision_guard.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include "encoder/coding/grid_places.h"
#include "encoder/coding/quantization.h"
#include "tests/support/choose_codings.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

// A sheet of 40 x 40 cells in the unit square, with texture coordinates.
struct Sheet {
  Mesh mesh = make_grid(40, 40);
  std::vector<float> positions, texture;

  Sheet() {
    for (uint32_t i = 0; i < mesh.point_count; ++i) {
      const auto x = static_cast<float>(i % 41) / 40, y = static_cast<float>(i / 41) / 40;
      positions.insert(positions.end(), {x, y, 0.1f * std::sin(9 * x)});
      texture.insert(texture.end(), {x, y});
    }
  }
  Mesh with(std::vector<Attribute> more = {}) const {
    Mesh result = mesh;
    result.attributes = {make_attribute("POSITION", ComponentType::kFloat32, 3, false, positions),
                         make_attribute("TEXCOORD_0", ComponentType::kFloat32, 2, false, texture)};
    for (Attribute& attribute : more) result.attributes.push_back(std::move(attribute));
    return result;
  }
};

Attribute generic(std::vector<float> values, uint8_t components) {
  return make_attribute("_VALUE", ComponentType::kFloat32, components, false, std::move(values));
}

// The codings without the guard, and what the guard makes of them.
struct Guarded {
  std::vector<AttributeCoding> before, after;
  std::vector<PrecisionNote> notes;
};
Guarded guard(Mesh mesh, const CodingOptions& options = {}) {
  Guarded guarded;
  for (Attribute& attribute : mesh.attributes) guarded.before.push_back(choose_coding(attribute, options));
  guarded.after = guarded.before;
  guarded.notes = guard_codings(mesh, options, guarded.after);
  return guarded;
}

// What decoders make of a value.
std::vector<float> decoded(const std::vector<float>& values, const AttributeCoding& coding) {
  std::vector<float> result = values;
  const size_t width = coding.origin.size();
  for (size_t at = 0; coding.bits > 0 && at < result.size(); at += width)
    round_to_grid({result.data() + at, width}, coding);
  return result;
}
double farthest(const std::vector<float>& values, const AttributeCoding& coding) {
  const std::vector<float> after = decoded(values, coding);
  double most = 0;
  for (size_t i = 0; i < values.size(); ++i)
    most = std::max(most, std::fabs(double{values[i]} - double{after[i]}));
  return most;
}
size_t distinct_positions(const std::vector<float>& values, const AttributeCoding& coding) {
  const std::vector<float> after = decoded(values, coding);
  std::set<std::array<float, 3>> distinct;
  for (size_t at = 0; at < after.size(); at += 3) distinct.insert({after[at], after[at + 1], after[at + 2]});
  return distinct.size();
}

TEST(PrecisionGuard, LeavesOrdinaryMeshesAlone) {
  const Guarded guarded = guard(Sheet().with());
  EXPECT_TRUE(guarded.notes.empty());
  for (size_t i = 0; i < 2; ++i) EXPECT_EQ(guarded.after[i].bits, guarded.before[i].bits);
}

TEST(PrecisionGuard, FarTextureCoordinatesDoNotCoarsenTheOthers) {
  for (const float far : {-100000.0f, 3000.0f, 1e38f, -1e38f}) {
    SCOPED_TRACE(far);
    Sheet sheet;
    for (const size_t at : {0u, 1u, 2u, 3u, 82u, 83u}) sheet.texture[at] = far;
    const Guarded guarded = guard(sheet.with());
    EXPECT_GT(farthest(sheet.texture, guarded.before[1]), 0.1);
    EXPECT_LE(farthest(sheet.texture, guarded.after[1]), kTextureError);
    ASSERT_EQ(guarded.notes.size(), 1u);
    EXPECT_FALSE(guarded.notes[0].is_warning);
    EXPECT_EQ(guarded.notes[0].text.find("TEXCOORD_0"), 0u) << guarded.notes[0].text;
    EXPECT_NE(guarded.notes[0].text.find("bytes"), std::string::npos) << guarded.notes[0].text;
  }
}

TEST(PrecisionGuard, StripsAndTilesAreCountedInTextures) {
  for (const auto& [u, v] : {std::pair(1.0f, 2000.0f), std::pair(4096.0f, 4096.0f)}) {
    Sheet sheet;
    for (size_t at = 0; at < sheet.texture.size(); at += 2) {
      sheet.texture[at] *= u;
      sheet.texture[at + 1] *= v;
    }
    const Guarded guarded = guard(sheet.with());
    EXPECT_GT(farthest(sheet.texture, guarded.before[1]), 0.1);
    EXPECT_LE(farthest(sheet.texture, guarded.after[1]), kTextureError);
    EXPECT_LE(guarded.after[1].bits, 22);  // not more than it takes
    EXPECT_GT(guarded.after[1].bits, 0);
    EXPECT_EQ(guarded.notes.size(), 1u);
  }
}

TEST(PrecisionGuard, ScalesOfTexturesCount) {
  const Mesh mesh = Sheet().with();
  std::vector<AttributeCoding> codings = guard(mesh).after;
  const GuardedMesh scaled{[&](const GuardedMesh::VisitPart& visit) {
                             visit(mesh, {});
                             return Status();
                           },
                           {1, 1000}};
  const auto notes =
      must(guard_codings(scaled, mesh.attributes, {}, std::vector{14, 12}, ThreadPool(1), codings));
  EXPECT_EQ(notes.size(), 1u);
  EXPECT_LE(1000 * farthest(Sheet().texture, codings[1]), kTextureError);
}

TEST(PrecisionGuard, ThinPipesKeepTheirFaces) {
  // 400 rings of 8 points.
  Mesh mesh = make_grid(7, 399);
  std::vector<float> positions;
  for (uint32_t i = 0; i < mesh.point_count; ++i) {
    const float angle = static_cast<float>(i % 8) * 0.7853982f;
    positions.insert(positions.end(),
                     {2.5f * static_cast<float>(i / 8), 0.003f * std::cos(angle), 0.003f * std::sin(angle)});
  }
  mesh.attributes = {make_attribute("POSITION", ComponentType::kFloat32, 3, false, positions)};
  const Guarded guarded = guard(mesh);
  ASSERT_EQ(guarded.notes.size(), 1u);
  EXPECT_NE(guarded.notes[0].text.find("faces would have no area"), std::string::npos) << guarded.notes[0].text;
  EXPECT_EQ(distinct_positions(positions, guarded.after[0]), mesh.point_count);
  EXPECT_LE(grid_step(guarded.after[0]), 0.003 / 4);
  EXPECT_LE(guarded.after[0].bits, 24);
}

TEST(PrecisionGuard, CloseSheetsStayApart) {
  Sheet sheet;
  Mesh mesh = sheet.mesh;
  const uint32_t count = mesh.point_count;
  std::vector<float> positions = sheet.positions;
  for (size_t at = 0; at < sheet.positions.size(); at += 3)
    positions.insert(positions.end(),
                     {sheet.positions[at], sheet.positions[at + 1], sheet.positions[at + 2] + 1e-5f});
  const std::vector<std::array<uint32_t, 3>> faces(mesh.faces.begin(), mesh.faces.end());
  for (const auto& face : faces) mesh.faces.push_back({face[0] + count, face[1] + count, face[2] + count});
  mesh.point_count = 2 * count;
  mesh.attributes = {make_attribute("POSITION", ComponentType::kFloat32, 3, false, positions)};
  const Guarded guarded = guard(mesh);
  EXPECT_EQ(guarded.notes.size(), 1u);
  EXPECT_EQ(distinct_positions(positions, guarded.after[0]), mesh.point_count);
}

TEST(PrecisionGuard, AFarPositionThatIsUsedDoesNotCoarsenTheOthers) {
  for (const float far : {1e6f, -1e6f, 1e38f}) {
    SCOPED_TRACE(far);
    Sheet sheet;
    sheet.positions[0] = far;
    const Guarded guarded = guard(sheet.with());
    EXPECT_LT(distinct_positions(sheet.positions, guarded.before[0]), 500u);
    EXPECT_EQ(distinct_positions(sheet.positions, guarded.after[0]), 41u * 41u);
    EXPECT_EQ(guarded.notes.size(), 1u);
  }
}

TEST(PrecisionGuard, GivenBitsOnlyWarn) {
  Sheet sheet;
  sheet.texture[0] = 3000;
  CodingOptions options;
  options.given.texcoord = true;
  const Guarded guarded = guard(sheet.with(), options);
  EXPECT_EQ(guarded.after[1].bits, 12);
  ASSERT_EQ(guarded.notes.size(), 1u);
  EXPECT_TRUE(guarded.notes[0].is_warning);
  EXPECT_NE(guarded.notes[0].text.find("as given"), std::string::npos) << guarded.notes[0].text;
  options = {};
  options.texcoord_bits = 11;
  options.give_changed_bits();
  EXPECT_EQ(guard(sheet.with(), options).after[1].bits, 11);
}

TEST(PrecisionGuard, SmallComponentsKeepTheirBits) {
  std::vector<float> values;
  for (size_t i = 0; i < 41 * 41; ++i) {
    const auto t = static_cast<float>(i) / (41 * 41);
    values.insert(values.end(), {1000 * t, 2 + std::sin(7 * t), 7});
  }
  const Guarded guarded = guard(Sheet().with({generic(values, 3)}));
  ASSERT_EQ(guarded.notes.size(), 1u);
  EXPECT_NE(guarded.notes[0].text.find("component 1"), std::string::npos) << guarded.notes[0].text;
  EXPECT_LE(grid_step(guarded.after[2]), 2 / 4000.0);
  EXPECT_LE(guarded.after[2].bits, 22);
}

TEST(PrecisionGuard, OutliersOfOtherAttributesDoNotCoarsenThem) {
  for (const float far : {20000.0f, 1e38f}) {
    std::vector<float> values;
    for (size_t i = 0; i < 41 * 41; ++i) values.push_back(std::sin(static_cast<float>(i) / 100));
    values[77] = far;
    const Guarded guarded = guard(Sheet().with({generic(values, 1)}));
    EXPECT_EQ(guarded.notes.size(), 1u);
    EXPECT_LE(farthest(values, guarded.after[2]), 3.0 / 4096);
  }
}

TEST(PrecisionGuard, ValuesWithoutAGridAreNamed) {
  for (const float odd : {NAN, INFINITY}) {
    Sheet sheet;
    sheet.texture[7] = odd;
    const Guarded guarded = guard(sheet.with());
    EXPECT_EQ(guarded.after[1].bits, 0);
    ASSERT_EQ(guarded.notes.size(), 1u);
    EXPECT_EQ(
        guarded.notes[0].text,
        "TEXCOORD_0 is kept exactly, in at most 13448 bytes instead of 5043: 1 of 1681 points have a value "
        "that is not finite");
  }
}

TEST(PrecisionGuard, UnstoredPointsDoNotCount) {
  Sheet sheet;
  sheet.texture[0] = NAN;
  const Mesh mesh = sheet.with();
  std::vector<uint8_t> stored(mesh.point_count, 1);
  stored[0] = 0;
  const CodingOptions options;
  std::vector<AttributeCoding> codings;
  for (const Attribute& attribute : mesh.attributes)
    codings.push_back(choose_coding(attribute, wanted_bounds(attribute, options, stored), options));
  const GuardedMesh guarded{[&](const GuardedMesh::VisitPart& visit) {
    visit(mesh, stored);
    return Status();
  }};
  EXPECT_TRUE(
      must(guard_codings(guarded, mesh.attributes, {}, std::vector{14, 12}, ThreadPool(1), codings)).empty());
  EXPECT_EQ(codings[1].bits, 12);
}

TEST(PrecisionGuard, IndicesOutOfRangeAreNotItsErrors) {
  Mesh mesh = Sheet().with();
  mesh.faces[5][1] = mesh.point_count;
  mesh.faces[6] = {UINT32_MAX, UINT32_MAX, UINT32_MAX};
  EXPECT_TRUE(guard(mesh).notes.empty());
}

}  // namespace
}  // namespace psplit
