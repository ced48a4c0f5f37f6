// The core's numbering gives the same numbers as the reference numbering, which knows only faces and points,
// and refuses the same maps. It runs on one lane and on warps.
#include "src/core/stitch.h"

#include <gtest/gtest.h>

#include <random>

#include "encoder/stitching/stitch_map.h"
#include "tests/support/emulated_warp.h"

namespace psplit {
namespace {

// Three strips of 40 triangles each. Stream 1 refers to points of 0 and its own, stream 2 to points of all.
constexpr uint32_t kStreams = 3, kPoints = 42;

std::vector<Face> strip() {
  std::vector<Face> faces;
  for (uint32_t i = 0; i + 2 < kPoints; ++i)
    faces.push_back(i % 2 == 0 ? Face{i, i + 1, i + 2} : Face{i + 1, i, i + 2});
  return faces;
}

struct Stitched {
  std::vector<std::vector<uint8_t>> parts;
  PatchContainer container;
};

// Most maps are valid: each point is a reference at most once, and refers to a point that is not a reference.
StitchMap random_map(std::mt19937& random, uint32_t stream, bool has_repeats) {
  StitchMap map;
  std::vector<uint8_t> taken(kPoints, 0);
  const auto below = [&](size_t limit) { return static_cast<uint32_t>(random() % limit); };
  const std::vector<uint32_t> walk = border_walk(strip(), kPoints);
  for (uint32_t begin = below(9); stream > 0 && begin + 6 < walk.size() && below(4) > 0;
       begin += 6 + below(9)) {
    const uint32_t length = 1 + below(6);
    const bool forward = length > 1 && below(2) == 0;
    map.runs.push_back({begin, length, below(stream), forward ? below(9) : 5 + below(9), forward});
    for (uint32_t k = 0; k < length; ++k) taken[walk[begin + k]] = 1;
  }
  for (uint32_t point = 1; has_repeats && point < kPoints; point += 1 + below(7)) {
    const uint32_t target = point - 1 - below(std::min(point, 4u));
    if (taken[point] != 0 || (taken[target] != 0 && below(50) > 0)) continue;
    taken[point] = 1;
    map.repeats.push_back({point, target});
  }
  for (uint32_t point = below(5); stream > 0 && point < kPoints; point += 1 + below(7)) {
    if (taken[point] != 0 && below(50) > 0) continue;
    taken[point] = 1;
    map.pairs.push_back({point, below(stream), below(12)});
  }
  return map;
}

Stitched random_container(std::mt19937& random) {
  Stitched made;
  PatchContainer& container = made.container;
  container.owned_base = {0};
  const bool has_repeats = random() % 3 != 0;
  for (uint32_t stream = 0; stream < kStreams; ++stream) {
    const StitchMap map = random_map(random, stream, has_repeats);
    std::vector<uint8_t> part = write_stitch_map(map, stream, kPoints);
    if (!part.empty() && random() % 4 == 0)
      part[random() % part.size()] ^= static_cast<uint8_t>(1 << random() % 8);
    size_t references = map.repeats.size() + map.pairs.size();
    for (const StitchRun& run : map.runs) references += run.length;
    container.entries.push_back(
        {1, kPoints - 2, kPoints, static_cast<uint32_t>(references), static_cast<uint32_t>(part.size())});
    container.owned_base.push_back(container.owned_base.back() + kPoints - static_cast<uint32_t>(references));
    made.parts.push_back(std::move(part));
  }
  for (const std::vector<uint8_t>& part : made.parts) container.stitch.emplace_back(part);
  return made;
}

// The numbers that the core gives to a container's points; empty if it refuses the container.
template <typename Run>
std::vector<std::vector<uint32_t>> number_by_core(const PatchContainer& container, Run run) {
  using core::Fault;
  const uint32_t total = container.point_count();
  const std::vector<uint32_t> border = border_walk(strip(), kPoints);
  std::vector<std::vector<uint32_t>> numbers(kStreams), references(kStreams);
  bool is_right = true;
  for (uint32_t stream = 0; stream < kStreams; ++stream) {
    numbers[stream].resize(kPoints);
    references[stream].assign(container.entries[stream].reference_count, core::kNoPoint);
    run([&](auto lanes) {
      const Fault fault = core::number_mesh_points(
          lanes, container.stitch_row(stream), core::View<const uint32_t>(border.data(), border.size()),
          core::View<uint32_t>(numbers[stream].data(), kPoints),
          core::View<uint32_t>(references[stream].data(), references[stream].size()));
      if (lanes.rank() == 0) is_right = is_right && fault == Fault::kNone;
    });
  }
  if (!is_right) return {};
  const auto walk_of = [&](uint32_t stream, uint32_t place) {
    const uint32_t number = place < border.size() ? numbers[stream][border[place]] : core::kNoPoint;
    return number < total ? number : core::kNoPoint;
  };
  const auto owned_of = [&](uint32_t stream, uint32_t rank) {
    const uint32_t base = container.owned_base[stream];
    return rank < container.owned_base[stream + 1] - base ? base + rank : core::kNoPoint;
  };
  for (uint32_t stream = 0; stream < kStreams; ++stream)
    run([&](auto lanes) {
      const Fault fault =
          core::resolve_references(lanes, container.stitch_row(stream), walk_of, owned_of,
                                   core::View<uint32_t>(references[stream].data(), references[stream].size()));
      if (lanes.rank() == 0) is_right = is_right && fault == Fault::kNone;
    });
  if (!is_right) return {};
  for (uint32_t stream = 0; stream < kStreams; ++stream)
    for (uint32_t& number : numbers[stream])
      if (number >= total) number = references[stream][number - total];
  return numbers;
}

TEST(Stitch, NumbersPointsAsTheContainerDoes) {
  std::mt19937 random(3);
  const ThreadPool pool(1);
  const std::vector<Face> faces = strip();
  const std::vector<std::span<const Face>> all_faces(kStreams, faces);
  size_t right = 0, wrong = 0;
  for (int i = 0; i < 5000; ++i) {
    const Stitched stitched = random_container(random);
    const auto expected = number_points(stitched.container, all_faces, pool);
    const std::vector<std::vector<uint32_t>> wanted =
        expected ? *expected : std::vector<std::vector<uint32_t>>();
    ++(expected ? right : wrong);
    ASSERT_EQ(number_by_core(stitched.container, [](auto body) { body(core::SerialLanes()); }), wanted)
        << i << ": " << expected.status().to_string();
    const LaneOrder order = kLaneOrders[static_cast<size_t>(i) % kLaneOrders.size()];
    ASSERT_EQ(number_by_core(stitched.container,
                             [&](auto body) { run_warp([&](EmulatedLanes lanes) { body(lanes); }, order); }),
              wanted)
        << i << ": " << expected.status().to_string();
  }
  EXPECT_GT(right, 300u);
  EXPECT_GT(wrong, 500u);
}

}  // namespace
}  // namespace psplit
