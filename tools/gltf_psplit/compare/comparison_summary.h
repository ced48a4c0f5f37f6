// A comparison in a few sentences: how much faster for how many bytes, how many patches to use, and whether the
// times can be trusted.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/gltf_psplit/compare/comparison.h"

namespace psplit {

// The rule for the recommended number of patches. Candidates are the measured counts that take at most
// kAffordableOverhead more bytes than stock Draco. Among those whose time is within kAboutAsFast of the fastest
// candidate, the count with the fewest patches is recommended. Without a candidate, the count with the fewest
// bytes is.
inline constexpr double kAffordableOverhead = 0.03;
inline constexpr double kAboutAsFast = 0.05;
// A time is noisy if the quartiles of its rounds differ by more than this share of the median.
inline constexpr double kNoisySpread = 0.2;
// Fewer rounds do not show how much times vary.
inline constexpr int kFewestRounds = 5;

struct ComparisonSummary {
  // The gain and the cost of the recommended number of patches. It says "about" where times are noisy or few,
  // and what meshoptimizer with zstd gains where that is faster.
  std::string headline;
  std::string recommendation;      // that number, and a faster one if there is one
  std::string rule;                // the rule that chose it
  std::vector<std::string> noise;  // reasons not to trust the times; empty if there are none
  uint64_t recommended_patches = 0, recommended_bytes = 0;
  bool has_recommendation = false;  // false if there are no splits
};

// The meshoptimizer that was measured.
struct MeasuredRival {
  std::string name = "meshoptimizer";
  bool is_old = false;  // its attribute codec is version 0
};

// `name` is the name of the input. Only psplit's own decoders count, unless libdraco alone was timed.
ComparisonSummary summarize_comparison(const Comparison& comparison, const std::string& name, int repeat,
                                       const MeasuredRival& rival = {});

// The fastest of psplit's own decoders for a split, which must have at least one decoder.
const DecodeRow& fastest_decoder(const SplitRow& row);

bool is_noisy(const Timing& timing);

}  // namespace psplit
