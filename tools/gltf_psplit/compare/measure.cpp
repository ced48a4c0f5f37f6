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

Expected<std::vector<Timing>> measure_interleaved(std::span<const Contender> contenders, int repeat,
                                                  const Progress& progress) {
  std::vector<std::vector<double>> samples_ms(contenders.size());
  const size_t total = contenders.size() * static_cast<size_t>(repeat + 1);
  size_t done = 0;
  for (int round = 0; round <= repeat; ++round) {
    for (size_t i = 0; i < contenders.size(); ++i) {
      Status status;
      const double ms = elapsed_ms([&] { status = contenders[i].run(); });
      if (!status.ok())
        return Status(status.code(), contenders[i].name + ": " + status.message(), status.place());
      if (round > 0) samples_ms[i].push_back(ms);
      if (progress) progress(++done, total);
    }
  }
  std::vector<Timing> timings;
  for (std::vector<double>& samples : samples_ms) timings.push_back(summarize_samples(std::move(samples)));
  return timings;
}

}  // namespace psplit
