#include "encoder/stitching/stitch_map.h"

#include <random>

#include "tests/support/expect.h"
#include "tests/support/mutants.h"

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
PatchContainer two_quads(const std::vector<uint8_t>& stitch) {
  PatchContainer container;
  container.entries = {{1, 2, 4, 0, 0}, {1, 2, 4, 2, static_cast<uint32_t>(stitch.size())}};
  container.stitch = {{}, stitch};
  container.streams.resize(2);
  container.owned_base = {0, 4, 6};
  container.face_base = {0, 2, 4};
  return container;
}

Expected<std::vector<std::vector<uint32_t>>> numbers_with(const StitchMap& map) {
  const std::vector<uint8_t> stitch = write_stitch_map(map, 1, 4);
  const PatchContainer container = two_quads(stitch);
  const std::vector<std::span<const Face>> faces = {kQuad, kQuad};
  return number_points(container, faces, ThreadPool(1));
}

TEST(NumberPoints, FollowsARunBackwards) {
  // Walk of patch 1: 0 1 3 2; of patch 0: 0 1 3 2. Patch 1's points 0 and 1 are patch 0's 2 and 3, at places
  // 3, 2.
  const auto numbers = must(numbers_with({{{0, 2, 0, 3, false}}, {}, {}}));
  EXPECT_EQ(numbers[0], (std::vector<uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ(numbers[1], (std::vector<uint32_t>{2, 3, 4, 5}));
}

TEST(NumberPoints, FollowsARunForwards) {
  const auto numbers = must(numbers_with({{{0, 2, 0, 1, true}}, {}, {}}));
  EXPECT_EQ(numbers[1], (std::vector<uint32_t>{1, 3, 4, 5}));
}

TEST(NumberPoints, FollowsPairs) {
  const auto numbers = must(numbers_with({{}, {}, {{1, 0, 0}, {3, 0, 2}}}));
  EXPECT_EQ(numbers[1], (std::vector<uint32_t>{4, 0, 5, 2}));
}

TEST(NumberPoints, FollowsRepeats) {
  const auto numbers = must(numbers_with({{}, {{2, 0}, {3, 1}}, {}}));
  EXPECT_EQ(numbers[1], (std::vector<uint32_t>{4, 5, 4, 5}));
}

TEST(NumberPoints, FollowsAllKindsTogether) {
  const auto numbers = must(numbers_with({{}, {{3, 2}}, {{1, 0, 3}}}));
  EXPECT_EQ(numbers[1], (std::vector<uint32_t>{4, 3, 5, 5}));
}

TEST(NumberPoints, RefusesWhatContradictsTheDirectory) {
  EXPECT_FALSE(numbers_with({{{0, 1, 0, 3, false}}, {}, {}}).ok()) << "one reference, the directory says two";
  EXPECT_FALSE(numbers_with({{{3, 2, 0, 3, false}}, {}, {}}).ok()) << "leaves the walk";
  EXPECT_FALSE(numbers_with({{{0, 2, 0, 0, false}}, {}, {}}).ok()) << "leaves the owner's walk at its start";
  EXPECT_FALSE(numbers_with({{{0, 2, 0, 3, true}}, {}, {}}).ok()) << "leaves the owner's walk at its end";
  EXPECT_FALSE(numbers_with({{}, {}, {{0, 0, 4}, {1, 0, 0}}}).ok()) << "rank that the owner does not own";
  EXPECT_FALSE(numbers_with({{{0, 1, 0, 3, false}}, {}, {{0, 0, 0}}}).ok()) << "two references of one point";
  EXPECT_FALSE(numbers_with({{{0, 1, 0, 3, false}}, {{1, 0}}, {}}).ok()) << "repeats a reference";
  EXPECT_FALSE(numbers_with({{{2, 1, 0, 3, false}}, {{3, 1}}, {}}).ok()) << "two references of one point";
  EXPECT_FALSE(numbers_with({{{0, 2, 1, 1, false}}, {}, {}}).ok()) << "refers to a reference";
}

TEST(StitchMap, RefusesEveryTruncationAndEveryExtension) {
  const std::vector<StitchMap> maps = {{{{0, 1, 0, 3, false}}, {}, {{1, 0, 3}}}, {{}, {{1, 0}, {3, 2}}, {}}};
  for (const StitchMap& map : maps) {
    std::vector<uint8_t> bytes = write_stitch_map(map, 1, 4);
    ASSERT_TRUE(parse_stitch_map(two_quads(bytes), 1).ok());
    for_each_truncation(bytes, [](const std::vector<uint8_t>& part) {
      const Expected<StitchMap> parsed = parse_stitch_map(two_quads(part), 1);
      ASSERT_FALSE(parsed.ok()) << part.size();
      EXPECT_EQ(parsed.status().place().patch, 1);
    });
    bytes.push_back(0);
    EXPECT_FALSE(parse_stitch_map(two_quads(bytes), 1).ok());
  }
}

TEST(StitchMap, RefusesBitsBehindTheLast) {
  std::vector<uint8_t> bytes = write_stitch_map({{}, {{1, 0}, {3, 2}}, {}}, 1, 4);  // 11 bits
  ASSERT_EQ(bytes.size(), 2u);
  for (int bit = 3; bit < 8; ++bit) {
    bytes[1] ^= static_cast<uint8_t>(1 << bit);
    EXPECT_FALSE(parse_stitch_map(two_quads(bytes), 1).ok()) << bit;
    bytes[1] ^= static_cast<uint8_t>(1 << bit);
  }
  EXPECT_TRUE(parse_stitch_map(two_quads(bytes), 1).ok());
}

// Maps of every size of numbers, of streams that need not be real.
StitchMap random_map(std::mt19937& random, uint32_t patch, uint32_t point_count) {
  const auto below = [&](uint32_t limit) { return static_cast<uint32_t>(random() % limit); };
  StitchMap map;
  uint32_t next = 0;
  const uint32_t gap = 1u << below(20);
  while (next < point_count - gap && map.runs.size() < 20) {
    const uint32_t begin = next + below(gap), length = 1 + below(std::min(gap, point_count - begin));
    const bool forward = length > 1 && below(2) == 0;
    const uint32_t start =
        forward ? below(point_count - length + 1) : length - 1 + below(point_count - length + 1);
    map.runs.push_back({begin, length, below(patch + 1), start, forward});
    next = begin + length;
  }
  next = 1;
  while (next < point_count - gap && map.repeats.size() < 20) {
    const uint32_t point = next + below(gap);
    map.repeats.push_back({point, below(2) == 0 ? below(point) : point - 1 - below(std::min(point, 3u))});
    next = point + 1;
  }
  next = 0;
  while (patch > 0 && next < point_count - gap && map.pairs.size() < 20) {
    const uint32_t point = next + below(gap);
    map.pairs.push_back({point, below(patch), below(point_count)});
    next = point + 1;
  }
  return map;
}

TEST(StitchMap, GivesBackWhatWasWritten) {
  std::mt19937 random(7);
  for (int i = 0; i < 2000; ++i) {
    const auto patch = static_cast<uint32_t>(random() % 3);
    const uint32_t point_count = i % 2 == 0 ? 2'000'000 : 3'000'000'000u;
    const StitchMap map = random_map(random, patch, point_count);
    const std::vector<uint8_t> bytes = write_stitch_map(map, patch, point_count);
    uint32_t references = static_cast<uint32_t>(map.repeats.size() + map.pairs.size());
    for (const StitchRun& run : map.runs) references += run.length;
    PatchContainer container;
    container.entries.assign(patch + 1, {1, point_count / 3, point_count, 0, 0});
    container.entries[patch].reference_count = references;
    container.stitch.assign(patch + 1, {});
    container.stitch[patch] = bytes;
    // Each patch owns as many points as there are. The sum wraps around, which nothing reads here.
    for (uint32_t p = 0; p <= patch + 1; ++p) container.owned_base.push_back(p * point_count);
    const StitchMap parsed = must(parse_stitch_map(container, patch));
    EXPECT_EQ(parsed.runs, map.runs);
    EXPECT_EQ(parsed.repeats, map.repeats);
    EXPECT_EQ(parsed.pairs, map.pairs);
  }
}

}  // namespace
}  // namespace psplit
