// What a comparison comes to, in sentences for people who read no tables: how much faster for how many bytes,
// which number of patches to take, and how far its times can be trusted.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/gltf_psplit/compare/comparison.h"

namespace psplit {

// The rule by which a number of patches is recommended, among those that were measured: of what takes at most
// kAffordableOverhead more bytes than stock Draco the fastest; of what is about as fast, within kAboutAsFast,
// that with the fewest patches. Where nothing is affordable, what takes the fewest bytes.
inline constexpr double kAffordableOverhead = 0.03;
inline constexpr double kAboutAsFast = 0.05;
// A time is noisy where the quartiles of its rounds lie further apart than this share of the median.
inline constexpr double kNoisySpread = 0.2;
// Fewer rounds do not show how far times swing.
inline constexpr int kFewestRounds = 5;

struct ComparisonSummary {
  std::string headline;            // what the recommended number of patches gains, and what it costs
  std::string recommendation;      // that number, and a faster one where there is one
  std::string rule;                // by which it was found
  std::vector<std::string> noise;  // why times are not to be trusted; empty where they are
  uint64_t recommended_patches = 0, recommended_bytes = 0;
  bool has_recommendation = false;  // false where there are no splits
};

// `name` is the input's. Only psplit's own decoders count, unless libdraco alone was timed.
ComparisonSummary summarize_comparison(const Comparison& comparison, const std::string& name, int repeat);

// What decodes a split fastest, of psplit's own decoders; a split has at least one decoder.
const DecodeRow& fastest_decoder(const SplitRow& row);

// "cpu on 2 threads"
std::string decoder_text(const DecodeRow& row);

bool is_noisy(const Timing& timing);

}  // namespace psplit
