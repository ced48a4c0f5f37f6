#include <array>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <thread>

#include "psplit/cuda.h"
#include "psplit/encode.h"
#include "tools/gltf_psplit/compare/comparison_report.h"
#include "tools/gltf_psplit/compare/meshopt_rival.h"

namespace psplit {
namespace {

std::string without_spaces_around(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

// The model as Linux names it. Other systems, and some processors, have no such name.
std::string cpu_model() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const size_t colon = line.find(':');
    if (!line.starts_with("model name") || colon == std::string::npos) continue;
    if (std::string model = without_spaces_around(line.substr(colon + 1)); !model.empty()) return model;
  }
  return "unknown";
}

std::string compiler() {
#if defined(__clang__)
  std::string text = "clang " __clang_version__;
#elif defined(__GNUC__)
  std::string text = "g++ " __VERSION__;
#else
  std::string text = "unknown";
#endif
#if defined(__GNUC__) && !defined(__OPTIMIZE__)
  text += ", without optimization";
#endif
  return without_spaces_around(text);
}

std::string utc_now() {
  const auto now = std::chrono::floor<std::chrono::minutes>(std::chrono::system_clock::now());
  const auto midnight = std::chrono::floor<std::chrono::days>(now);
  const std::chrono::year_month_day day(midnight);
  const std::chrono::hh_mm_ss time(now - midnight);
  std::array<char, 64> text{};
  const int size =
      std::snprintf(text.data(), text.size(), "%04d-%02u-%02u %02d:%02d", static_cast<int>(day.year()),
                    static_cast<unsigned>(day.month()), static_cast<unsigned>(day.day()),
                    static_cast<int>(time.hours().count()), static_cast<int>(time.minutes().count()));
  return {text.data(), static_cast<size_t>(size)};
}

}  // namespace

Environment describe_environment(const std::string& version, const std::string& command_line) {
  return {.cpu = cpu_model(),
          .threads = static_cast<int>(std::thread::hardware_concurrency()),
          .gpu = cuda_device_name(),
          .psplit = version,
          .draco = draco_version(),
          .meshoptimizer = meshopt_version(),
          .zstd = zstd_version(),
          .brotli = brotli_version(),
          .meshopt_codec = meshopt_codec_version(),
          .compiler = compiler(),
          .command_line = command_line,
          .date = utc_now()};
}

}  // namespace psplit
