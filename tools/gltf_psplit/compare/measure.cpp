#include "tools/gltf_psplit/compare/measure.h"

#include <algorithm>
#include <cmath>

#include "src/stopwatch.h"

namespace psplit {

double elapsed_ms(const std::function<void()>& work) {
  const Stopwatch watch;
  work();
  return watch.ms();
}

Timing summarize_samples(std::vector<double> samples_ms) {
  std::ranges::sort(samples_ms);
  const auto quantile = [&](double share) {
    const double at = share * static_cast<double>(samples_ms.size() - 1);
    const auto below = static_cast<size_t>(at);
    const size_t above = std::min(below + 1, samples_ms.size() - 1);
    return std::lerp(samples_ms[below], samples_ms[above], at - static_cast<double>(below));
  };
  return {quantile(0.5), samples_ms.front(), samples_ms.back(), quantile(0.25), quantile(0.75)};
}

double median_uncertainty(const Timing& timing, int rounds) {
  if (rounds < kFewestRounds || !(timing.median_ms > 0)) return HUGE_VAL;
  return 1.57 * (timing.upper_quartile_ms - timing.lower_quartile_ms) / std::sqrt(rounds) / timing.median_ms;
}

bool is_certain(const Timing& timing, int rounds) { return median_uncertainty(timing, rounds) <= kCertain; }

namespace {

constexpr int kMostRounds = 500;

// The number of rounds after which all medians should be certain, as the `done` rounds promise; `done` if they
// are, or if the time is over.
int rounds_needed(std::span<const Contender> contenders, std::span<const std::vector<double>> samples_ms,
                  int done, double elapsed_ms, const Rounds& rounds) {
  if (rounds.count > 0) return rounds.count;
  if (done < kFewestRounds) return kFewestRounds;
  double worst = 0;
  for (size_t i = 0; i < contenders.size(); ++i)
    if (contenders[i].decides)
      worst = std::max(worst, median_uncertainty(summarize_samples(samples_ms[i]), done));
  if (worst <= kCertain) return done;
  const auto in_time = static_cast<int>(rounds.seconds * 1000 / std::max(elapsed_ms / done, 1e-3));
  const int most = std::max(done, std::min(kMostRounds, in_time));
  const double more = std::min(1.0 * kMostRounds, done * (worst / kCertain) * (worst / kCertain));
  return std::min(most, std::max(done + 1, static_cast<int>(more)));
}

}  // namespace

Expected<Measured> measure_interleaved(std::span<const Contender> contenders, const Rounds& rounds,
                                       const Progress& progress) {
  std::vector<std::vector<double>> samples_ms(contenders.size());
  int needed = rounds.count > 0 ? rounds.count : kFewestRounds;
  size_t runs = 0;
  Measured measured;
  Stopwatch watch;
  for (int round = 0; round <= needed; ++round) {
    for (size_t i = 0; i < contenders.size(); ++i) {
      Status status;
      const double ms = elapsed_ms([&] { status = contenders[i].run(); });
      if (!status.ok())
        return Status(status.code(), contenders[i].name + ": " + status.message(), status.place());
      if (round > 0) samples_ms[i].push_back(ms);
      if (progress) progress(++runs, contenders.size() * static_cast<size_t>(needed + 1));
    }
    if (round == 0)
      watch = Stopwatch();
    else
      needed = rounds_needed(contenders, samples_ms, measured.rounds = round, watch.ms(), rounds);
  }
  for (std::vector<double>& samples : samples_ms)
    measured.timings.push_back(summarize_samples(std::move(samples)));
  return measured;
}

}  // namespace psplit
