// Collective algorithms give the results of plain loops, on one lane and on the emulated warp in several
// orders. The emulated warp detects what a warp must not do.
#include "src/core/lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "tests/support/emulated_warp.h"
#include "tests/support/sanitizers.h"

namespace psplit::core {
namespace {

static_assert(Lanes<SerialLanes>);
static_assert(Lanes<EmulatedLanes>);
static_assert(exclusive_scan(SerialLanes(), 7u).before == 0 && exclusive_scan(SerialLanes(), 7u).total == 7);
static_assert(any(SerialLanes(), true) && !any(SerialLanes(), false));

// Calls test(run) for one lane and for warps of every order. run(body) calls body(lanes) on all of them.
template <typename Test>
void for_each_kind_of_lanes(Test test) {
  {
    SCOPED_TRACE("one lane");
    test([](auto body) { body(SerialLanes()); });
  }
  for (const LaneOrder& order : kLaneOrders) {
    SCOPED_TRACE("order " + std::to_string(order.kind) + ", seed " + std::to_string(order.seed));
    test([&](auto body) { run_warp([&](EmulatedLanes lanes) { body(lanes); }, order); });
  }
}

constexpr uint32_t kCounts[] = {0, 1, 2, 31, 32, 33, 63, 64, 65, 1000};

TEST(Lanes, TakeEveryItemOnce) {
  for_each_kind_of_lanes([](auto run) {
    for (const uint32_t count : kCounts) {
      std::vector<uint32_t> visits(count), taker(count);
      uint32_t size = 0;
      run([&](auto lanes) {
        if (lanes.rank() == 0) size = lanes.size();
        for_each_lane_item(lanes, count, [&](uint32_t i) {
          ++visits[i];
          taker[i] = lanes.rank();
        });
      });
      for (uint32_t i = 0; i < count; ++i) {
        ASSERT_EQ(visits[i], 1u);
        ASSERT_EQ(taker[i], i % size);
      }
    }
  });
}

TEST(Lanes, FillWholeViews) {
  for_each_kind_of_lanes([](auto run) {
    for (const uint32_t count : kCounts) {
      std::vector<uint16_t> values(count, 7);
      run([&](auto lanes) {
        fill(lanes, View<uint16_t>(values.data(), count), uint16_t{9});
        EXPECT_EQ(std::count(values.begin(), values.end(), 9), count);  // to every lane
      });
    }
  });
}

TEST(Lanes, ShuffleAndBallot) {
  for_each_kind_of_lanes([](auto run) {
    run([](auto lanes) {
      const uint32_t size = lanes.size(), rank = lanes.rank();
      std::mt19937 random(5);
      for (int round = 0; round < 50; ++round) {
        std::vector<uint32_t> words(size), sources(size);
        std::vector<uint64_t> wides(size);
        uint32_t ballot = 0;
        for (uint32_t r = 0; r < size; ++r) {
          words[r] = static_cast<uint32_t>(random());
          wides[r] = uint64_t{random()} << 32 | random();
          sources[r] = static_cast<uint32_t>(random() % size);
          ballot |= (words[r] & 1) << r;
        }
        const uint32_t one = static_cast<uint32_t>(random() % size);
        EXPECT_EQ(lanes.shuffle(words[rank], sources[rank]), words[sources[rank]]);
        EXPECT_EQ(lanes.shuffle(wides[rank], sources[rank]), wides[sources[rank]]);
        EXPECT_EQ(lanes.ballot((words[rank] & 1) != 0), ballot);
        EXPECT_EQ(broadcast(lanes, words[rank], one), words[one]);
        EXPECT_EQ(broadcast(lanes, wides[rank], one), wides[one]);
        EXPECT_TRUE(any(lanes, rank == one));
        EXPECT_FALSE(any(lanes, rank == size));
      }
    });
  });
}

template <typename Word>
void expect_scan(auto lanes) {
  const uint32_t size = lanes.size(), rank = lanes.rank();
  std::mt19937_64 random(3);
  for (int round = 0; round < 50; ++round) {
    std::vector<Word> words(size);
    for (Word& word : words) word = static_cast<Word>(random());  // sums may wrap
    Word before = 0, total = 0;
    for (uint32_t r = 0; r < size; ++r) {
      if (r < rank) before += words[r];
      total += words[r];
    }
    const Scan<Word> scan = exclusive_scan(lanes, words[rank]);
    EXPECT_EQ(scan.before, before);
    EXPECT_EQ(scan.total, total);
  }
}

TEST(Lanes, ScanTheirWords) {
  for_each_kind_of_lanes([](auto run) {
    run([](auto lanes) { expect_scan<uint32_t>(lanes); });
    run([](auto lanes) { expect_scan<uint64_t>(lanes); });
  });
}

template <typename T>
void expect_array_scan(auto run) {
  for (const uint32_t count : kCounts) {
    std::vector<T> values(count), expected(count);
    uint32_t total = 0;
    for (uint32_t i = 0; i < count; ++i) {
      values[i] = static_cast<T>(i * 7 % 61);
      expected[i] = static_cast<T>(total);
      total += values[i];
    }
    run([&](auto lanes) {
      EXPECT_EQ(scan_array(lanes, View<T>(values.data(), count)), total);
      EXPECT_EQ(values, expected);  // to every lane
    });
  }
}

TEST(Lanes, ScanArrays) {
  for_each_kind_of_lanes([](auto run) {
    expect_array_scan<uint32_t>(run);
    expect_array_scan<uint16_t>(run);
  });
}

// These tests race on purpose, so the thread sanitizer would report them.
#if !defined(PSPLIT_TSAN)
TEST(EmulatedWarp, RunsLanesInTheOrderAsked) {
  std::vector<std::vector<uint32_t>> orders;
  for (const LaneOrder& order : kLaneOrders) {
    // Before, between and after two calls.
    std::vector<uint32_t> ran, again;
    const auto note = [](std::vector<uint32_t>& out) {
      return [&](EmulatedLanes lanes) {
        out.push_back(lanes.rank());
        lanes.sync();
        out.push_back(lanes.rank());
        lanes.ballot(true);
        out.push_back(lanes.rank());
      };
    };
    run_warp(note(ran), order);
    run_warp(note(again), order);
    EXPECT_EQ(ran, again);
    ASSERT_EQ(ran.size(), 96u);
    for (auto part = ran.begin(); part != ran.end(); part += 32) {
      std::vector<uint32_t> sorted(part, part + 32);
      std::sort(sorted.begin(), sorted.end());
      for (uint32_t r = 0; r < 32; ++r) ASSERT_EQ(sorted[r], r);
    }
    orders.push_back(ran);
  }
  for (uint32_t r = 0; r < 32; ++r) {
    EXPECT_EQ(orders[0][r], r);
    EXPECT_EQ(orders[1][r], 31 - r);
  }
  EXPECT_FALSE(std::equal(orders[2].begin(), orders[2].begin() + 32, orders[2].begin() + 32));
  EXPECT_NE(orders[2], orders[3]);
}

// What a warp computes that lacks a sync depends on the order of its lanes, to be seen by running several.
TEST(EmulatedWarp, ShowsMissingSyncs) {
  const auto neighbours = [](bool with_sync, LaneOrder order) {
    std::vector<uint32_t> written(32), read(32);
    run_warp(
        [&](EmulatedLanes lanes) {
          written[lanes.rank()] = lanes.rank() + 1;
          if (with_sync) lanes.sync();
          read[lanes.rank()] = written[lanes.rank() ^ 1];
        },
        order);
    return read;
  };
  for (const LaneOrder& order : kLaneOrders) EXPECT_EQ(neighbours(true, order), neighbours(true, {}));
  EXPECT_NE(neighbours(false, {LaneOrder::kAscending}), neighbours(false, {LaneOrder::kDescending}));
}

#endif

TEST(EmulatedWarp, GivesLanesTheirOwnLocals) {
  std::vector<uint32_t> sums(32);
  run_warp([&](EmulatedLanes lanes) {
    uint32_t own[1000];
    for (uint32_t i = 0; i < 1000; ++i) {
      own[i] = i * lanes.rank();
      if (i % 100 == 0) lanes.sync();
    }
    for (const uint32_t value : own) sums[lanes.rank()] += value;
  });
  for (uint32_t r = 0; r < 32; ++r) EXPECT_EQ(sums[r], 499500 * r);
}

// Outside of the macro, which would put all of it on one line.
void call_from_two_places(EmulatedLanes lanes) {
  if (lanes.rank() < 31)
    lanes.sync();
  else
    lanes.sync();
}

TEST(EmulatedWarpDeathTest, EndsWhereLanesDoNotMeet) {
  EXPECT_DEATH(
      run_warp([](EmulatedLanes lanes) { lanes.rank() == 5 ? (void)lanes.ballot(true) : lanes.sync(); }),
      "lanes do not meet: lane 0 is in sync at .*lanes_test.cpp:.*, lane 5 is in ballot at ");
  EXPECT_DEATH(run_warp([](EmulatedLanes lanes) {
                 if (lanes.rank() >= 5) lanes.sync();
               }),
               "lane 0 has returned, lane 5 is in sync at ");
  EXPECT_DEATH(run_warp([](EmulatedLanes lanes) {
                 if (lanes.rank() < 5) lanes.sync();
               }),
               "lane 0 is in sync at .*, lane 5 has returned");
  EXPECT_DEATH(run_warp([](EmulatedLanes lanes) {
                 lanes.sync();
                 if (lanes.rank() == 3) return (void)lanes.shuffle(uint32_t{1}, 0);
                 lanes.shuffle(uint64_t{1}, 0);
               }),
               "lane 0 is in 64-bit shuffle at .*, lane 3 is in shuffle at ");
  EXPECT_DEATH(run_warp(call_from_two_places), "lane 0 is in sync at .*, lane 31 is in sync at ");
}

TEST(EmulatedWarpDeathTest, EndsAtShufflesFromNowhere) {
  EXPECT_DEATH(run_warp([](EmulatedLanes lanes) { lanes.shuffle(uint32_t{1}, lanes.rank() + 1); }),
               "lane 31 shuffles from lane 32, which is not there, at .*lanes_test.cpp");
}

TEST(EmulatedWarpDeathTest, EndsAtWarpsInWarps) {
  EXPECT_DEATH(run_warp([](EmulatedLanes) { run_warp([](EmulatedLanes) {}); }), "a lane runs another warp");
}

}  // namespace
}  // namespace psplit::core
