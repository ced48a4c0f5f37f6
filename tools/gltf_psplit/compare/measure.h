// Times contenders against each other in one run.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "src/container/decode_backend.h"

namespace psplit {

struct Contender {
  std::string name;  // for errors
  std::function<Status()> run;
};

struct Timing {
  double median_ms = 0, min_ms = 0, max_ms = 0;
  double lower_quartile_ms = 0, upper_quartile_ms = 0;  // half of the rounds lie between them
};

// One round untimed, then `repeat` rounds, each of which runs every contender once, in turn: a machine that
// slows down or wakes up does so for all of them alike. One timing per contender. Stops at the first that
// fails.
Expected<std::vector<Timing>> measure_interleaved(std::span<const Contender> contenders, int repeat,
                                                  const Progress& progress = {});

// Milliseconds that one call takes.
double elapsed_ms(const std::function<void()>& work);

// A quantile between two samples is interpolated: the median of an even number is the mean of the middle two.
// `samples_ms` is not empty.
Timing summarize_samples(std::vector<double> samples_ms);

}  // namespace psplit
