// Times several contenders in one run.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "psplit/decode.h"

namespace psplit {

struct Contender {
  std::string name;  // for errors
  std::function<Status()> run;
  bool decides = true;  // rounds go on until its median is certain
};

// How many rounds are timed.
struct Rounds {
  int count = 0;        // 0: until the medians are certain, or `seconds` are over
  double seconds = 20;  // kFewestRounds may take longer
};
// Fewer rounds do not show how much times vary.
inline constexpr int kFewestRounds = 5;
// A median is certain if it is known to this share of it.
inline constexpr double kCertain = 0.03;

struct Timing {
  double median_ms = 0, min_ms = 0, max_ms = 0;
  double lower_quartile_ms = 0, upper_quartile_ms = 0;  // half of the rounds are between them
};

// How far the median may be from that of endless rounds, in both directions, as a share of it: 1.57 times the
// distance of the quartiles, divided by the root of the number of rounds (McGill, Tukey and Larsen, Variations
// of Box Plots, 1978). If two medians differ by more than both, chance alone explains that in about 5 of 100
// cases. Infinite below kFewestRounds.
double median_uncertainty(const Timing& timing, int rounds);
bool is_certain(const Timing& timing, int rounds);

struct Measured {
  std::vector<Timing> timings;  // one for each contender
  int rounds = 0;               // that were timed
};

// Runs one untimed round, then timed rounds. Each round runs every contender once, in turn, so that a machine
// that slows down or speeds up affects all contenders alike. Returns the first failure, if there is one.
Expected<Measured> measure_interleaved(std::span<const Contender> contenders, const Rounds& rounds,
                                       const Progress& progress = {});

// Runs `work` once and returns its milliseconds.
double elapsed_ms(const std::function<void()>& work);

// A quantile between two samples is interpolated, so the median of an even number of samples is the mean of the
// middle two. `samples_ms` must not be empty.
Timing summarize_samples(std::vector<double> samples_ms);

}  // namespace psplit
