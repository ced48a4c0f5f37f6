#include "tools/gltf_psplit/compare/comparison_summary.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <span>
#include <tuple>

#include "tools/gltf_psplit/compare/comparison_figures.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

double best_ms(const SplitRow& row) { return fastest_decoder(row).timing.median_ms; }

// One decoder's time divided by another's.
struct TimeRatio {
  double value = 1;
  double low = 1, high = 1;  // by how much the medians may be off
  bool is_certain = true;
};

// How far the median of endless rounds may be: at most as far as the quartiles.
std::pair<double, double> median_range_ms(const Timing& timing, int rounds) {
  const double off_ms = median_uncertainty(timing, rounds) * timing.median_ms;
  return {std::max(timing.lower_quartile_ms, timing.median_ms - off_ms),
          std::min(timing.upper_quartile_ms, timing.median_ms + off_ms)};
}

TimeRatio time_ratio(const Timing& slow, const Timing& fast, int rounds) {
  TimeRatio ratio;
  ratio.value = slow.median_ms / fast.median_ms;
  ratio.is_certain = is_certain(slow, rounds) && is_certain(fast, rounds);
  if (rounds < kFewestRounds) return ratio;
  const auto [slow_low, slow_high] = median_range_ms(slow, rounds);
  const auto [fast_low, fast_high] = median_range_ms(fast, rounds);
  ratio.low = slow_low / fast_high;
  ratio.high = slow_high / fast_low;
  return ratio;
}

// "3.7 times as fast as", "about 3.7 times (3.1 to 4.6) as fast as"
std::string speed_text(const TimeRatio& ratio) {
  const std::string times = with_decimals(ratio.value, 1), low = with_decimals(ratio.low, 1),
                    high = with_decimals(ratio.high, 1);
  const bool has_spread = !ratio.is_certain && ratio.low < ratio.high && low != high;
  const std::string about = ratio.is_certain ? "" : "about ";
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

// Of the splits whose `cost_ms` is within `about` of the least, the index of the one with the fewest patches;
// of two with the same number, of the smaller one. There must be a split.
size_t find_cheapest(const std::vector<SplitRow>& splits, double about,
                     const std::function<double(const SplitRow&)>& cost_ms) {
  double least = HUGE_VAL;
  for (const SplitRow& row : splits) least = std::min(least, cost_ms(row));
  size_t chosen = splits.size();
  for (size_t i = 0; i < splits.size(); ++i) {
    if (cost_ms(splits[i]) > least * (1 + about)) continue;
    const auto rank = [&](size_t row) {
      return std::pair(splits[row].summary.patches, splits[row].summary.total_bytes);
    };
    if (chosen == splits.size() || rank(i) < rank(chosen)) chosen = i;
  }
  return chosen;
}

size_t find_fast(const std::vector<SplitRow>& splits) { return find_cheapest(splits, kAboutAsFast, best_ms); }

// The recommended split for a number of threads or the GPU, and when its meshes are there.
struct Choice {
  std::string where;  // "on 2 threads"
  size_t split = 0;
  double there_ms = 0;
};

// The fastest of psplit's own decoders, or of libdraco's if it alone was timed; null if there is none. A single
// patch has no work for more threads; if it was faster with them, that is chance.
const DecodeRow* fastest_on(const SplitRow& row, bool on_gpu, int threads) {
  const bool has_own = std::ranges::any_of(row.decode, [](const DecodeRow& decode) { return is_own(decode); });
  const DecodeRow* fastest = nullptr;
  for (const DecodeRow& decode : row.decode) {
    if (is_own(decode) != has_own || (decode.backend == "cuda") != on_gpu) continue;
    if (!on_gpu && decode.threads != (row.summary.patches < 2 ? 1 : threads)) continue;
    if (fastest == nullptr || decode.timing.median_ms < fastest->timing.median_ms) fastest = &decode;
  }
  return fastest;
}

// For the GPU, if there is one, and for each number of threads that was measured, the most first.
std::vector<Choice> choose_splits(const Comparison& comparison, const LoadingModel& loading) {
  std::set<std::pair<bool, int>> settings;
  for (const DecodeRow& row : comparison.splits.front().decode)
    settings.emplace(row.backend == "cuda", row.backend == "cuda" ? 1 : row.threads);
  std::vector<Choice> choices;
  for (auto setting = settings.rbegin(); setting != settings.rend(); ++setting) {
    const bool on_gpu = setting->first;
    const int threads = setting->second;
    const auto there_ms = [&](const SplitRow& row) {
      const DecodeRow* fastest = fastest_on(row, on_gpu, threads);
      return fastest == nullptr ? HUGE_VAL : loading.ms(row.summary.total_bytes, fastest->timing.median_ms);
    };
    const SplitRow& soonest = *std::ranges::min_element(comparison.splits, {}, there_ms);
    if (!(there_ms(soonest) < HUGE_VAL)) continue;
    // One file serves all, unless it costs more than the rule allows and noise does not explain that.
    const auto is_about_as_soon = [&](const SplitRow& row) {
      const DecodeRow* fastest = fastest_on(row, on_gpu, threads);
      if (fastest == nullptr) return false;
      const double least_ms = median_range_ms(fastest->timing, comparison.rounds).first,
                   most_ms =
                       median_range_ms(fastest_on(soonest, on_gpu, threads)->timing, comparison.rounds).second;
      return loading.ms(row.summary.total_bytes, least_ms) <=
             loading.ms(soonest.summary.total_bytes, most_ms) * (1 + kAboutAsSoon);
    };
    const size_t split = !choices.empty() && is_about_as_soon(comparison.splits[choices.front().split])
                             ? choices.front().split
                             : find_cheapest(comparison.splits, kAboutAsSoon, there_ms);
    choices.push_back(
        {on_gpu ? "on the GPU" : "on " + threads_text(threads), split, there_ms(comparison.splits[split])});
  }
  return choices;
}

std::string speed_text(const DecodeRow& row, const Comparison& comparison, int rounds) {
  return speed_text(time_ratio(comparison.stock.decode, row.timing, rounds));
}

// What meshoptimizer with zstd costs where it is faster than the patches. Empty if it is not.
std::string rival_text(const SplitRow& row, const Comparison& comparison, int rounds,
                       const MeasuredRival& rival) {
  const TimeRatio ratio = time_ratio(fastest_decoder(row).timing, comparison.meshopt.decode, rounds);
  if (!(ratio.value > 1) || with_decimals(ratio.value, 1) == "1.0") return "";
  const double overhead = static_cast<double>(comparison.meshopt.bytes) /
                              static_cast<double>(std::max<uint64_t>(row.summary.total_bytes, 1)) -
                          1;
  return " " + rival.name + " with zstd decodes " + speed_text(ratio) + " these patches, on one thread, " +
         bytes_text(overhead) + (rival.is_old ? "; its current releases make smaller files." : ".");
}

std::string headline_text(const SplitRow& row, const Comparison& comparison, const std::string& name,
                          int rounds) {
  const DecodeRow& best = fastest_decoder(row);
  std::string text = "In " + ComparisonFigures::patches_name(row) + ", " + name + " decodes " +
                     speed_text(best, comparison, rounds) + " stock Draco " + where_text(best) + ", " +
                     bytes_text(row.overhead);
  const DecodeRow* one = on_one_thread(row, best);
  if (one == nullptr || one == &best || best.backend == "cuda") return text + ".";
  const std::string speed = speed_text(*one, comparison, rounds);
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

// "45 patches (--patches 45)"
std::string named_choice(const SplitRow& row) {
  return ComparisonFigures::patches_name(row) + " (" + option_text(row.rule) + ")";
}

std::string line_text(const LoadingModel& loading) { return with_digits(loading.line_mbit, 6) + " Mbit/s"; }

// When the meshes are downloaded and decoded, and when the rivals' meshes are.
std::string there_text(const Choice& choice, const Comparison& comparison, const LoadingModel& loading,
                       const MeasuredRival& rival) {
  const double meshopt_ms = loading.ms(comparison.meshopt.bytes, comparison.meshopt.decode.median_ms);
  std::string text = " Over a line of " + line_text(loading) + " the meshes are there and decoded after " +
                     as_duration(choice.there_ms) + " " + choice.where + ", with stock Draco after " +
                     as_duration(loading.ms(comparison.stock.bytes, comparison.stock.decode.median_ms));
  if (meshopt_ms < choice.there_ms)
    text += ", and with " + rival.name + " and zstd after " + as_duration(meshopt_ms);
  return text + ".";
}

std::string recommendation_text(const Comparison& comparison, std::span<const Choice> choices,
                                const LoadingModel& loading, const MeasuredRival& rival) {
  const std::vector<SplitRow>& splits = comparison.splits;
  const SplitRow& row = splits[choices.front().split];
  if (splits.size() == 1)
    return "Only " + ComparisonFigures::patches_name(row) + " " + (row.summary.patches == 1 ? "was" : "were") +
           " measured, so nothing can be recommended: --patches takes several counts, as in --patches 1,8,64.";
  // "Take A on 4 threads and on one thread", "Take A on 4 threads, and B on one thread"
  std::string text = "Take ";
  for (size_t i = 0; i < choices.size(); ++i) {
    const bool is_same = i > 0 && choices[i].split == choices[i - 1].split;
    if (i > 0) text += is_same ? " and " : ", and ";
    if (!is_same) text += named_choice(splits[choices[i].split]) + " ";
    text += choices[i].where;
  }
  text += "." + there_text(choices.front(), comparison, loading, rival);
  const SplitRow& fastest = splits[find_fast(splits)];
  if (best_ms(row) <= best_ms(fastest) * (1 + kAboutAsFast)) return text;
  const DecodeRow& decode = fastest_decoder(fastest);
  return text + " If only decoding counts, as from a disk, take " + ComparisonFigures::patches_name(fastest) +
         ": " + speed_text(decode, comparison, comparison.rounds) + " stock Draco " + where_text(decode) +
         ", " + bytes_text(fastest.overhead) + ".";
}

std::string rule_text(const LoadingModel& loading) {
  return "The rule: the time of the bytes over a line of " + line_text(loading) +
         " (--line) and the time to decode them are added. Among the measured counts within " +
         with_decimals(100 * kAboutAsSoon, 0) +
         " % of the least sum, the one with the fewest patches is recommended, for all "
         "numbers of threads for which it is among these.";
}

// "a; b; c; d; and 3 more"
std::string first_of(const std::vector<std::string>& names) {
  constexpr size_t kNamed = 4;
  std::string text;
  for (size_t i = 0; i < names.size() && i < kNamed; ++i) text += (i == 0 ? "" : "; ") + names[i];
  if (names.size() > kNamed) text += "; and " + with_separators(names.size() - kNamed) + " more";
  return text;
}

// Of the decoders that the sentences are about.
void note_uncertain_medians(const Comparison& comparison, std::vector<std::string>& noise) {
  std::string worst_name;
  double worst = kTooUncertain;
  size_t decoder_count = 0, uncertain_count = 0;
  const auto look_at = [&](const std::string& name, const Timing& timing) {
    ++decoder_count;
    const double uncertainty = median_uncertainty(timing, comparison.rounds);
    if (uncertainty <= kTooUncertain) return;
    ++uncertain_count;
    if (uncertainty <= worst) return;
    worst = uncertainty;
    worst_name = name;
  };
  look_at(ComparisonFigures::stock_name(comparison.stock), comparison.stock.decode);
  look_at("meshoptimizer and zstd", comparison.meshopt.decode);
  for (const SplitRow& row : comparison.splits)
    for (const DecodeRow& decode : row.decode)
      if (is_own(decode))
        look_at(ComparisonFigures::patches_name(row) + " with " + decoder_text(decode), decode.timing);
  if (uncertain_count == 0) return;
  noise.push_back("Times varied very much: after " +
                  counted(static_cast<uint64_t>(comparison.rounds), "round") + " the medians of " +
                  with_separators(uncertain_count) + " of " + counted(decoder_count, "decoder") +
                  " may be off by over " + with_decimals(100 * kTooUncertain, 0) + " %, most of all that of " +
                  worst_name + ".");
}

// A single patch has no work for a second thread, so it is skipped.
void note_useless_threads(const Comparison& comparison, std::vector<std::string>& noise) {
  std::vector<std::string> names;
  for (const SplitRow& row : comparison.splits)
    for (const DecodeRow& decode : row.decode) {
      const DecodeRow* one = on_one_thread(row, decode);
      if (!is_own(decode) || decode.threads == 1 || one == nullptr || row.summary.patches < 2) continue;
      if (time_ratio(decode.timing, one->timing, comparison.rounds).low > 1)
        names.push_back(ComparisonFigures::patches_name(row) + " with " + decoder_text(decode) + " (" +
                        as_duration(decode.timing.median_ms) + " instead of " +
                        as_duration(one->timing.median_ms) + ")");
    }
  if (names.empty()) return;
  noise.push_back("More threads were slower than one: " + first_of(names) +
                  ". Either the machine was busy, or the mesh is too small for several threads.");
}

std::vector<std::string> find_noise(const Comparison& comparison) {
  std::vector<std::string> noise;
  const int rounds = comparison.rounds;
  note_useless_threads(comparison, noise);
  if (rounds >= kFewestRounds)
    note_uncertain_medians(comparison, noise);
  else
    noise.push_back("Each decoder was timed " +
                    (rounds == 1 ? std::string("only once")
                                 : "in only " + counted(static_cast<uint64_t>(rounds), "round")) +
                    ": too few to see how much times vary.");
  if (!noise.empty())
    noise.push_back(
        "Before you quote times, measure again on an idle machine, without --repeat, or longer (--seconds). "
        "Bytes do not vary.");
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

ComparisonSummary summarize_comparison(const Comparison& comparison, const std::string& name,
                                       const LoadingModel& loading, const MeasuredRival& rival) {
  ComparisonSummary summary;
  summary.noise = find_noise(comparison);
  if (comparison.splits.empty()) return summary;
  summary.has_recommendation = true;
  const std::vector<Choice> choices = choose_splits(comparison, loading);
  const SplitRow& row = comparison.splits[choices.front().split];
  summary.recommended_patches = row.summary.patches;
  summary.recommended_bytes = row.summary.total_bytes;
  summary.headline = headline_text(row, comparison, name, comparison.rounds) +
                     rival_text(row, comparison, comparison.rounds, rival);
  summary.recommendation = recommendation_text(comparison, choices, loading, rival);
  if (comparison.splits.size() > 1) summary.rule = rule_text(loading);
  return summary;
}

}  // namespace psplit
