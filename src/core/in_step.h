// In step: one thread takes the steps of several independent runs in turn. Each step of a run waits for the one
// before it, so a processor works on one run while another waits.
#pragma once

#include "src/core/platform.h"

namespace psplit::core {

// The number of runs, or of whole streams, that one thread takes in turn. Three keep a processor busy, and the
// working sets of three streams still fit its cache. Two are as fast as three in WebAssembly, which has fewer
// registers, and their loops are a third smaller.
inline constexpr uint32_t kInStep = PSPLIT_IS_SMALL_CODE ? 2 : 3;
// The number of runs in step for work that takes a small part of the time, at most kRuns.
template <uint32_t kRuns>
inline constexpr uint32_t kRareInStep = PSPLIT_IS_SMALL_CODE ? 1 : kRuns;

// Makes steps ready again, if the run can: it has renew(), which is called when steps_left() is 0.
template <typename Run>
PSPLIT_HD PSPLIT_INLINE void renew_steps(Run& run) {
  if constexpr (requires { run.renew(); })
    if (run.steps_left() == 0) run.renew();
}

// Takes steps of `count` runs, kRuns of them in turn, until fewer are left. Returns their number, and stores
// them in `left`, which has room for kRuns. A run has step() and steps_left(), which may be 0 before all steps
// are taken if it has renew(). If a step has several dependent parts, it has begin_step(), and step_part() for
// each of its kParts, instead of step(): then the parts of all runs are taken in turn. Each run is copied to a
// Run, whose state may be kept in registers, and assigned back when a run of the kRuns in turn ends.
template <uint32_t kRuns, typename Run, typename T>
PSPLIT_HD uint32_t step_most(T* const* runs, uint32_t count, T** left) {
  uint32_t live = 0;
  for (uint32_t next = 0;;) {
    // The next runs replace the runs that ended.
    while (live < kRuns && next < count) left[live++] = runs[next++];
    if (live < kRuns) return live;
    Run local[kRuns];
    for (uint32_t n = 0; n < kRuns; ++n) local[n] = Run(*left[n]);
    for (;;) {
      uint32_t steps = ~uint32_t{0};
      PSPLIT_UNROLL
      for (Run& run : local) {
        renew_steps(run);
        steps = run.steps_left() < steps ? run.steps_left() : steps;
      }
      if (steps == 0) break;
      for (; steps > 0; --steps) {
        if constexpr (requires { Run::kParts; }) {
          PSPLIT_UNROLL
          for (Run& run : local) run.begin_step();
          PSPLIT_UNROLL
          for (uint32_t part = 0; part < Run::kParts; ++part) {
            PSPLIT_UNROLL
            for (Run& run : local) run.step_part();
          }
        } else {
          PSPLIT_UNROLL
          for (Run& run : local) run.step();
        }
      }
    }
    live = 0;
    for (uint32_t n = 0; n < kRuns; ++n) {
      T* const run = left[n];
      const bool is_live = local[n].steps_left() > 0;
      *run = local[n];
      if (is_live) left[live++] = run;
    }
  }
}

// Takes all steps of `count` runs, up to kRuns of them in turn.
template <uint32_t kRuns, typename Run, typename T>
PSPLIT_HD void step_all(T* const* runs, uint32_t count) {
  T* left[kRuns] = {};
  const uint32_t live = step_most<kRuns, Run>(runs, count, left);
  if constexpr (kRuns > 1) step_all<kRareInStep<kRuns - 1>, Run>(left, live);
}

// Sorts runs, so that the longest begin first: then few are left alone at the end.
template <typename T>
PSPLIT_HD void sort_longest_first(T** runs, uint32_t count) {
  if constexpr (PSPLIT_IS_SMALL_CODE) return;
  for (uint32_t i = 1; i < count; ++i)
    for (uint32_t k = i; k > 0 && runs[k - 1]->steps_left() < runs[k]->steps_left(); --k) {
      T* const longer = runs[k];
      runs[k] = runs[k - 1];
      runs[k - 1] = longer;
    }
}

// Takes steps of runs of different kinds in turn, until the first of them ends. Each is copied to a Run and
// assigned back.
template <typename... Run, typename... T>
PSPLIT_HD void step_in_turn_as(T&... runs) {
  const auto step = [&](Run... at) {
    for (;;) {
      uint32_t steps = ~uint32_t{0};
      ((renew_steps(at), steps = at.steps_left() < steps ? at.steps_left() : steps), ...);
      if (steps == 0) break;
      for (; steps > 0; --steps) (at.step(), ...);
    }
    ((runs = at), ...);
  };
  step(Run(runs)...);
}
template <typename... Runs>
PSPLIT_HD void step_in_turn(Runs&... runs) {
  step_in_turn_as<Runs...>(runs...);
}

// The runs of a kind that are left when they are fewer than kInStep: too few to keep a processor busy.
template <typename T>
struct LeftRuns {
  T* at[kInStep] = {};
  uint32_t count = 0;

  // Takes steps as step_most does. Runs that were left before come first.
  template <typename Run>
  PSPLIT_HD void take_most(T* const* runs, uint32_t run_count) {
    finish<Run>();
    count = step_most<kInStep, Run>(runs, run_count, at);
  }
  template <typename Run>
  PSPLIT_HD void finish() {
    step_all<kRareInStep<kInStep - 1>, Run>(at, count);
    count = 0;
  }
  // Whether some are left.
  template <typename Run>
  PSPLIT_HD bool are_left() {
    const uint32_t before = count;
    count = 0;
    for (uint32_t n = 0; n < before; ++n)
      if (Run(*at[n]).steps_left() > 0) at[count++] = at[n];
    return count > 0;
  }
};
// Takes steps of runs of two kinds in turn, until one kind has no runs any more.
template <typename A, typename B, typename T, typename U>
PSPLIT_HD void step_left_in_turn(LeftRuns<T>& a, LeftRuns<U>& b) {
  while (a.template are_left<A>() && b.template are_left<B>()) {
    if (a.count > 1)
      step_in_turn_as<A, A, B>(*a.at[0], *a.at[1], *b.at[0]);
    else if (b.count > 1)
      step_in_turn_as<A, B, B>(*a.at[0], *b.at[0], *b.at[1]);
    else
      step_in_turn_as<A, B>(*a.at[0], *b.at[0]);
  }
}

}  // namespace psplit::core
