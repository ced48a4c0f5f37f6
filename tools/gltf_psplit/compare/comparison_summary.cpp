#include "tools/gltf_psplit/compare/comparison_summary.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "tools/gltf_psplit/compare/comparison_figures.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

bool is_own(const DecodeRow& row) { return row.backend != "draco"; }

double best_ms(const SplitRow& row) { return fastest_decoder(row).timing.median_ms; }

// One decoder's time divided by another's.
struct TimeRatio {
  double value = 1;
  double low = 1, high = 1;  // the ratio for times at the quartiles of their rounds
  bool is_noisy = false;     // then low and high are shown
  bool is_rough = false;     // noisy, or of too few rounds to know
};

TimeRatio time_ratio(const Timing& slow, const Timing& fast, int repeat) {
  TimeRatio ratio;
  ratio.value = slow.median_ms / fast.median_ms;
  ratio.is_noisy = is_noisy(slow) || is_noisy(fast);
  ratio.is_rough = ratio.is_noisy || repeat < kFewestRounds;
  ratio.low = slow.lower_quartile_ms / fast.upper_quartile_ms;
  ratio.high = slow.upper_quartile_ms / fast.lower_quartile_ms;
  return ratio;
}

// "3.7 times as fast as", "about 3.7 times (3.1 to 4.6) as fast as"
std::string speed_text(const TimeRatio& ratio) {
  const std::string times = with_decimals(ratio.value, 1), low = with_decimals(ratio.low, 1),
                    high = with_decimals(ratio.high, 1);
  const bool has_spread = ratio.is_noisy && low != high;
  const std::string about = ratio.is_rough ? "about " : "";
  if (times == "1.0" && !has_spread) return about + "as fast as";
  return (ratio.value < 1 && times != "1.0" ? "only " : "") + about + times + " times " +
         (has_spread ? "(" + low + " to " + high + ") " : "") + "as fast as";
}

// "for 2.0 % more bytes"
std::string bytes_text(double overhead) {
  const std::string share = as_share(std::abs(overhead));
  if (share == as_share(0)) return "at the same size";
  return "for " + share + (overhead > 0 ? " more bytes" : " fewer bytes");
}

std::string threads_text(int threads) {
  return threads == 1 ? "one thread" : counted(static_cast<uint64_t>(threads), "thread");
}

// "cpu on 2 threads"
std::string decoder_text(const DecodeRow& row) { return row.backend + " on " + threads_text(row.threads); }

// "on the GPU", "on 2 threads"
std::string where_text(const DecodeRow& row) {
  return row.backend == "cuda" ? "on the GPU" : "on " + threads_text(row.threads);
}

const DecodeRow* on_one_thread(const SplitRow& row, const DecodeRow& like) {
  for (const DecodeRow& decode : row.decode)
    if (decode.backend == like.backend && decode.threads == 1) return &decode;
  return nullptr;
}

// Looks at the splits with at most `most_overhead`, and of these at the ones about as fast as the fastest.
// Returns the index of the one with the fewest patches; of two with the same number, of the smaller one.
// splits.size() if no split has so little overhead.
size_t find_fast(const std::vector<SplitRow>& splits, double most_overhead) {
  double fastest_ms = HUGE_VAL;
  for (const SplitRow& row : splits)
    if (row.overhead <= most_overhead) fastest_ms = std::min(fastest_ms, best_ms(row));
  size_t chosen = splits.size();
  for (size_t i = 0; i < splits.size(); ++i) {
    if (splits[i].overhead > most_overhead || best_ms(splits[i]) > fastest_ms * (1 + kAboutAsFast)) continue;
    const auto cost = [&](size_t row) {
      return std::pair(splits[row].summary.patches, splits[row].summary.total_bytes);
    };
    if (chosen == splits.size() || cost(i) < cost(chosen)) chosen = i;
  }
  return chosen;
}

size_t find_recommended(const std::vector<SplitRow>& splits) {
  const size_t fast = find_fast(splits, kAffordableOverhead);
  if (fast < splits.size()) return fast;
  const auto smallest =
      std::ranges::min_element(splits, {}, [](const SplitRow& row) { return row.summary.total_bytes; });
  return static_cast<size_t>(smallest - splits.begin());
}

std::string speed_text(const DecodeRow& row, const Comparison& comparison, int repeat) {
  return speed_text(time_ratio(comparison.stock.decode, row.timing, repeat));
}

// What meshoptimizer with zstd costs where it is faster than the patches. Empty if it is not.
std::string rival_text(const SplitRow& row, const Comparison& comparison, int repeat,
                       const MeasuredRival& rival) {
  const TimeRatio ratio = time_ratio(fastest_decoder(row).timing, comparison.meshopt.decode, repeat);
  if (!(ratio.value > 1) || with_decimals(ratio.value, 1) == "1.0") return "";
  const double overhead = static_cast<double>(comparison.meshopt.bytes) /
                              static_cast<double>(std::max<uint64_t>(row.summary.total_bytes, 1)) -
                          1;
  return " " + rival.name + " with zstd decodes " + speed_text(ratio) + " these patches, on one thread, " +
         bytes_text(overhead) + (rival.is_old ? "; its current releases make smaller files." : ".");
}

std::string headline_text(const SplitRow& row, const Comparison& comparison, const std::string& name,
                          int repeat) {
  const DecodeRow& best = fastest_decoder(row);
  std::string text = "In " + ComparisonFigures::patches_name(row) + ", " + name + " decodes " +
                     speed_text(best, comparison, repeat) + " stock Draco " + where_text(best) + ", " +
                     bytes_text(row.overhead);
  const DecodeRow* one = on_one_thread(row, best);
  if (one == nullptr || one == &best || best.backend == "cuda") return text + ".";
  const std::string speed = speed_text(*one, comparison, repeat);
  return text + "; on one thread it is " + speed.substr(0, speed.rfind(" as")) + ".";
}

// The options with which `encode` cuts as in this row. The number of patches may differ from that of --patches,
// for example if the asset has more primitives.
std::string option_text(const PatchRule& rule) {
  const std::string condense = rule.condense ? "--condense" : "";
  const std::string more = rule.condense ? " " + condense : "";
  if (rule.patches > 0) return "--patches " + std::to_string(rule.patches) + more;
  if (rule.patch_faces > 0) return "--patch-faces " + std::to_string(rule.patch_faces) + more;
  return rule.condense ? condense : "the default";
}

std::string recommendation_text(const Comparison& comparison, size_t recommended, int repeat) {
  const std::vector<SplitRow>& splits = comparison.splits;
  const SplitRow& row = splits[recommended];
  if (splits.size() == 1)
    return "Only " + ComparisonFigures::patches_name(row) + " " + (row.summary.patches == 1 ? "was" : "were") +
           " measured, so nothing can be recommended: --patches takes several counts, as in --patches 1,8,64.";
  std::string text = "Take " + ComparisonFigures::patches_name(row) + " (" + option_text(row.rule) + ").";
  const SplitRow& fastest = splits[find_fast(splits, HUGE_VAL)];
  if (best_ms(row) <= best_ms(fastest) * (1 + kAboutAsFast)) return text;
  const DecodeRow& decode = fastest_decoder(fastest);
  return text + " If time counts for more than bytes, take " + ComparisonFigures::patches_name(fastest) + ": " +
         speed_text(decode, comparison, repeat) + " stock Draco " + where_text(decode) + ", " +
         bytes_text(fastest.overhead) + ".";
}

std::string rule_text(const std::vector<SplitRow>& splits) {
  const bool is_any_affordable =
      std::ranges::any_of(splits, [](const SplitRow& row) { return row.overhead <= kAffordableOverhead; });
  const std::string percent = with_decimals(100 * kAffordableOverhead, 0) + " %";
  if (!is_any_affordable)
    return "The rule: every measured count takes over " + percent +
           " more bytes than stock Draco, so the count with the fewest bytes is recommended.";
  return "The rule: candidates are the measured counts that take at most " + percent +
         " more bytes than stock Draco. Among those within " + with_decimals(100 * kAboutAsFast, 0) +
         " % of the fastest candidate's time, the count with the fewest patches is recommended.";
}

// "a; b; c; d; and 3 more"
std::string first_of(const std::vector<std::string>& names) {
  constexpr size_t kNamed = 4;
  std::string text;
  for (size_t i = 0; i < names.size() && i < kNamed; ++i) text += (i == 0 ? "" : "; ") + names[i];
  if (names.size() > kNamed) text += "; and " + with_separators(names.size() - kNamed) + " more";
  return text;
}

void note_wide_spreads(const Comparison& comparison, std::vector<std::string>& noise) {
  std::vector<std::string> names;
  size_t decoder_count = 0;
  const auto look_at = [&](const std::string& name, const Timing& timing) {
    ++decoder_count;
    if (is_noisy(timing))
      names.push_back(name + " (" + as_duration(timing.lower_quartile_ms) + " to " +
                      as_duration(timing.upper_quartile_ms) + ")");
  };
  for (const StockRow& row : comparison.stock_speeds)
    look_at("stock Draco at speed " + std::to_string(row.speed), row.decode);
  look_at("meshoptimizer", comparison.meshopt_plain.decode);
  look_at("meshoptimizer and zstd", comparison.meshopt.decode);
  if (comparison.meshopt_brotli) look_at("meshoptimizer and brotli", comparison.meshopt_brotli->decode);
  for (const SplitRow& row : comparison.splits)
    for (const DecodeRow& decode : row.decode)
      look_at(ComparisonFigures::patches_name(row) + " with " + decoder_text(decode), decode.timing);
  if (names.empty()) return;
  noise.push_back("Times varied by more than " + with_decimals(100 * kNoisySpread, 0) + " % for " +
                  with_separators(names.size()) + " of " + counted(decoder_count, "decoder") +
                  " (marked ~). Half of the rounds were within: " + first_of(names) + ".");
}

// A single patch has no work for a second thread, so it is skipped.
void note_useless_threads(const Comparison& comparison, std::vector<std::string>& noise) {
  std::vector<std::string> names;
  for (const SplitRow& row : comparison.splits)
    for (const DecodeRow& decode : row.decode) {
      const DecodeRow* one = on_one_thread(row, decode);
      if (decode.threads == 1 || one == nullptr || row.summary.patches < 2) continue;
      if (decode.timing.median_ms > one->timing.median_ms)
        names.push_back(ComparisonFigures::patches_name(row) + " with " + decoder_text(decode) + " (" +
                        as_duration(decode.timing.median_ms) + " instead of " +
                        as_duration(one->timing.median_ms) + ")");
    }
  if (names.empty()) return;
  noise.push_back("More threads were slower than one: " + first_of(names) +
                  ". Either the machine was busy, or the mesh is too small for several threads.");
}

std::vector<std::string> find_noise(const Comparison& comparison, int repeat) {
  std::vector<std::string> noise;
  note_useless_threads(comparison, noise);
  if (repeat >= kFewestRounds)
    note_wide_spreads(comparison, noise);
  else
    noise.push_back("Each decoder was timed " +
                    (repeat == 1 ? std::string("only once")
                                 : "in only " + counted(static_cast<uint64_t>(repeat), "round")) +
                    ": too few to see how much times vary.");
  if (!noise.empty())
    noise.push_back(
        "Before you quote times, measure again on an idle machine with --repeat 15. Bytes do not vary.");
  return noise;
}

}  // namespace

const DecodeRow& fastest_decoder(const SplitRow& row) {
  // A single patch has no work for a second thread. If it was faster there, that is chance.
  const bool is_shared = row.summary.patches > 1;
  const auto rank = [&](const DecodeRow& decode) {
    return std::tuple(!is_own(decode), is_shared ? 0 : decode.threads, decode.timing.median_ms);
  };
  return *std::ranges::min_element(row.decode, {}, rank);
}

bool is_noisy(const Timing& timing) {
  return timing.upper_quartile_ms - timing.lower_quartile_ms > kNoisySpread * timing.median_ms;
}

ComparisonSummary summarize_comparison(const Comparison& comparison, const std::string& name, int repeat,
                                       const MeasuredRival& rival) {
  ComparisonSummary summary;
  summary.noise = find_noise(comparison, repeat);
  if (comparison.splits.empty()) return summary;
  summary.has_recommendation = true;
  const size_t recommended = find_recommended(comparison.splits);
  summary.recommended_patches = comparison.splits[recommended].summary.patches;
  summary.recommended_bytes = comparison.splits[recommended].summary.total_bytes;
  const SplitRow& row = comparison.splits[recommended];
  summary.headline = headline_text(row, comparison, name, repeat) + rival_text(row, comparison, repeat, rival);
  summary.recommendation = recommendation_text(comparison, recommended, repeat);
  if (comparison.splits.size() > 1) summary.rule = rule_text(comparison.splits);
  return summary;
}

}  // namespace psplit
