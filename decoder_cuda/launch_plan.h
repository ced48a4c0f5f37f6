// The number of launches that a batch needs. The kernels are compiled with it, and without the rest of the
// plan.
#pragma once

#include <algorithm>
#include <cstdint>

namespace psplit {

// The launches for the streams of one width and one kind. Work beyond the plan is done by the last launch,
// slowly.
struct LaunchPlan {
  // Few streams need more launches. The others should not wait for those.
  static constexpr uint32_t kMostRuns = 64, kMostRounds = 24;

  uint32_t runs = 0;    // the most runs of a stream between two stops
  uint32_t rounds = 0;  // the most ways of a stream from stop to stop
  // The round in which most streams have `chains` runs. In the other rounds they have one or two.
  uint32_t chain_round = 0, chains = 1;
  bool has_steps = false;  // some values may be predicted in steps

  // The launches for the streams of both plans.
  void join(const LaunchPlan& other) {
    runs = std::max(runs, other.runs);
    rounds = std::max(rounds, other.rounds);
    chain_round = std::max(chain_round, other.chain_round);
    chains = std::max(chains, other.chains);
    has_steps |= other.has_steps;
  }
};

}  // namespace psplit
