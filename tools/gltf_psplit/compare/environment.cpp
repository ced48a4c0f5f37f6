#include <array>
#include <ctime>
#include <fstream>
#include <thread>

#include "decoder_cuda/psplit_cuda.h"
#include "encoder/draco/draco_backend.h"
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
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M", &parts)};
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
          .meshopt_codec = meshopt_codec_version(),
          .compiler = compiler(),
          .command_line = command_line,
          .date = utc_now()};
}

}  // namespace psplit
