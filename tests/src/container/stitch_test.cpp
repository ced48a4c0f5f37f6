#include "src/container/stitch.h"

#include <gtest/gtest.h>

#include "src/container/varint.h"

namespace psplit {
namespace {

// Two triangles that share the edge 1-2 and have a border of four edges.
//
//   0 --- 2
//   |  /  |
//   1 --- 3
const std::vector<Face> kQuad = {{0, 1, 2}, {2, 1, 3}};

TEST(BorderWalk, GoesAroundFromTheLowestPoint) {
  EXPECT_EQ(border_walk(kQuad, 4), (std::vector<uint32_t>{0, 1, 3, 2}));
}

TEST(BorderWalk, ListsLoopsOneAfterTheOther) {
  const std::vector<Face> faces = {{3, 4, 5}, {2, 1, 0}};
  EXPECT_EQ(border_walk(faces, 6), (std::vector<uint32_t>{0, 2, 1, 3, 4, 5}));
}

TEST(BorderWalk, ClosedSurfaceHasNone) {
  const std::vector<Face> tetrahedron = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
  EXPECT_TRUE(border_walk(tetrahedron, 4).empty());
}

TEST(BorderWalk, PatchWithTwoBorderEdgesLeavingAPointHasNone) {
  const std::vector<Face> two_tips = {{0, 1, 2}, {0, 3, 4}};
  EXPECT_TRUE(border_walk(two_tips, 5).empty());
}

TEST(BorderWalk, HubOfManySpokesIsFast) {
  std::vector<Face> fan;
  constexpr uint32_t kSpokes = 200000;
  for (uint32_t i = 1; i < kSpokes; ++i) fan.push_back({0, i, i + 1});
  EXPECT_EQ(border_walk(fan, kSpokes + 1).size(), kSpokes + 1);
}

// Two quads side by side as two patches: patch 1 refers to two points of patch 0.
//
//   0 --- 2  0 --- 2        numbers   0 --- 2 --- 5
//   |  /  |  |  /  |                  |  /  |  /  |
//   1 --- 3  1 --- 3                  1 --- 3 --- 4
Container two_quads(const std::vector<uint8_t>& stitch) {
  Container container;
  container.entries = {{1, 2, 4, 0, 0}, {1, 2, 4, 2, static_cast<uint32_t>(stitch.size())}};
  container.stitch = {{}, stitch};
  container.streams.resize(2);
  container.owned_base = {0, 4, 6};
  container.face_base = {0, 2, 4};
  return container;
}

Expected<std::vector<std::vector<uint32_t>>> numbers_with(const StitchMap& map) {
  const std::vector<uint8_t> bytes = write_stitch_map(map, 1);
  const Container container = two_quads(bytes);
  const std::vector<std::span<const Face>> faces = {kQuad, kQuad};
  return number_points(container, faces, ThreadPool(1));
}

TEST(NumberPoints, FollowsARunBackwards) {
  // Walk of patch 1: 0 1 3 2; of patch 0: 0 1 3 2. Patch 1's points 0 and 1 are patch 0's 2 and 3, at places
  // 3, 2.
  const auto numbers = numbers_with({{{0, 2, 0, 3, false}}, {}});
  ASSERT_TRUE(numbers.ok()) << numbers.status().to_string();
  EXPECT_EQ((*numbers)[0], (std::vector<uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ((*numbers)[1], (std::vector<uint32_t>{2, 3, 4, 5}));
}

TEST(NumberPoints, FollowsARunForwards) {
  const auto numbers = numbers_with({{{0, 2, 0, 1, true}}, {}});
  ASSERT_TRUE(numbers.ok());
  EXPECT_EQ((*numbers)[1], (std::vector<uint32_t>{1, 3, 4, 5}));
}

TEST(NumberPoints, FollowsPairs) {
  const auto numbers = numbers_with({{}, {{1, 0, 0}, {3, 0, 2}}});
  ASSERT_TRUE(numbers.ok());
  EXPECT_EQ((*numbers)[1], (std::vector<uint32_t>{4, 0, 5, 2}));
}

TEST(NumberPoints, FollowsAPairWithinThePatch) {
  const auto numbers = numbers_with({{}, {{2, 1, 0}, {3, 0, 1}}});
  ASSERT_TRUE(numbers.ok());
  EXPECT_EQ((*numbers)[1], (std::vector<uint32_t>{4, 5, 4, 1}));
}

TEST(NumberPoints, RefusesWhatContradictsTheDirectory) {
  EXPECT_FALSE(numbers_with({{{0, 1, 0, 3, false}}, {}}).ok()) << "one reference, the directory says two";
  EXPECT_FALSE(numbers_with({{{3, 2, 0, 3, false}}, {}}).ok()) << "leaves the walk";
  EXPECT_FALSE(numbers_with({{{0, 2, 0, 0, false}}, {}}).ok()) << "leaves the owner's walk at its start";
  EXPECT_FALSE(numbers_with({{{0, 2, 0, 3, true}}, {}}).ok()) << "leaves the owner's walk at its end";
  EXPECT_FALSE(numbers_with({{}, {{0, 0, 4}, {1, 0, 0}}}).ok()) << "rank that the owner does not own";
  EXPECT_FALSE(numbers_with({{{0, 1, 0, 3, false}}, {{0, 0, 0}}}).ok()) << "two references of one point";
  EXPECT_FALSE(numbers_with({{{0, 2, 1, 1, false}}, {}}).ok()) << "refers to a reference";
}

TEST(StitchMap, RefusesEveryTruncation) {
  const StitchMap map = {{{0, 1, 0, 3, false}}, {{1, 0, 3}}};
  const std::vector<uint8_t> bytes = write_stitch_map(map, 1);
  ASSERT_TRUE(parse_stitch_map(two_quads(bytes), 1).ok());
  for (size_t length = 0; length < bytes.size(); ++length) {
    const std::vector<uint8_t> part(bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(length));
    const Expected<StitchMap> parsed = parse_stitch_map(two_quads(part), 1);
    ASSERT_FALSE(parsed.ok()) << length;
    EXPECT_EQ(parsed.status().place().patch, 1);
  }
}

TEST(Varint, RoundTripsAndRefusesOverflow) {
  for (uint32_t value : {0u, 1u, 127u, 128u, 16383u, 16384u, 0x7fffffffu, 0xffffffffu}) {
    std::vector<uint8_t> bytes;
    append_varint(bytes, value);
    VarintReader reader(bytes);
    EXPECT_EQ(reader.read(), value);
    EXPECT_EQ(reader.remaining(), 0u);
    EXPECT_EQ(reader.read(), std::nullopt);
  }
  const std::vector<uint8_t> too_large = {0xff, 0xff, 0xff, 0xff, 0x1f};
  EXPECT_EQ(VarintReader(too_large).read(), std::nullopt);
}

}  // namespace
}  // namespace psplit
