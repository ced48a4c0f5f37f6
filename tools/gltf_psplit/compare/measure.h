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
};

struct Timing {
  double median_ms = 0, min_ms = 0, max_ms = 0;
  double lower_quartile_ms = 0, upper_quartile_ms = 0;  // half of the rounds are between them
};

// Runs one untimed round, then `repeat` timed rounds. Each round runs every contender once, in turn, so that a
// machine that slows down or speeds up affects all contenders alike. Returns one timing for each contender, or
// the first failure.
Expected<std::vector<Timing>> measure_interleaved(std::span<const Contender> contenders, int repeat,
                                                  const Progress& progress = {});

// Runs `work` once and returns its milliseconds.
double elapsed_ms(const std::function<void()>& work);

// A quantile between two samples is interpolated, so the median of an even number of samples is the mean of the
// middle two. `samples_ms` must not be empty.
Timing summarize_samples(std::vector<double> samples_ms);

}  // namespace psplit
