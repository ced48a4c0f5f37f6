// Measuring milliseconds.
#pragma once

#include <chrono>

namespace psplit {

class Stopwatch {
 public:
  // Milliseconds since its construction.
  double ms() const { return std::chrono::duration<double, std::milli>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

// Adds the milliseconds of its lifetime to a sum.
class ScopedStopwatch {
 public:
  explicit ScopedStopwatch(double& sum_ms) : sum_ms_(sum_ms) {}
  ~ScopedStopwatch() { sum_ms_ += watch_.ms(); }
  ScopedStopwatch(const ScopedStopwatch&) = delete;
  ScopedStopwatch& operator=(const ScopedStopwatch&) = delete;

 private:
  double& sum_ms_;
  const Stopwatch watch_;
};

}  // namespace psplit
