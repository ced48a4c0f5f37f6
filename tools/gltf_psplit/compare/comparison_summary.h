// A comparison in a few sentences: how much faster for how many bytes, how many patches to use, and whether the
// times can be trusted.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/gltf_psplit/compare/comparison.h"

namespace psplit {

// The rule for the recommended number of patches. What counts is when the meshes are there: the time of their
// bytes on a line (LoadingModel) and the time to decode them, one after the other. Among the measured counts
// within kAboutAsSoon of the soonest, the one with the fewest patches is recommended, for each number of
// threads on its own.
inline constexpr double kAboutAsSoon = 0.02;
// A decoder is about as fast as another within this share of its time.
inline constexpr double kAboutAsFast = 0.05;
// Sentences have the range of a ratio of medians that are not certain (is_certain); a note says which medians
// may be off by more than this share.
inline constexpr double kTooUncertain = 0.25;
// Tables mark a time if the quartiles of its rounds differ by more than this share of the median.
inline constexpr double kNoisySpread = 0.2;

// How the meshes come to their reader.
struct LoadingModel {
  double line_mbit = 50;  // 10^6 bits a second

  double ms(uint64_t bytes, double decode_ms) const {
    return 8 * static_cast<double>(bytes) / (1000 * line_mbit) + decode_ms;
  }
};

struct ComparisonSummary {
  // The gain and the cost of the recommended number of patches. Where times are uncertain it says "about", with
  // the range of the ratio; it says what meshoptimizer with zstd gains where that is faster.
  std::string headline;
  std::string recommendation;      // that number for each number of threads, and a count that decodes faster
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

// `name` is the name of the input. Only psplit's own decoders count, unless libdraco alone was timed. The
// recommended count is that for the most threads.
ComparisonSummary summarize_comparison(const Comparison& comparison, const std::string& name,
                                       const LoadingModel& loading = {}, const MeasuredRival& rival = {});

// The fastest of psplit's own decoders for a split, which must have at least one decoder.
const DecodeRow& fastest_decoder(const SplitRow& row);

bool is_noisy(const Timing& timing);

}  // namespace psplit
