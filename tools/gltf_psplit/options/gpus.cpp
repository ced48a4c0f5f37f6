#include "tools/gltf_psplit/options/gpus.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <string_view>

namespace psplit {
namespace {

struct Gpu {
  std::string_view name;
  uint32_t multiprocessors;
};

// From NVIDIA's data sheets. If a GPU has several variants, the one with the most multiprocessors.
constexpr Gpu kGpus[] = {{"B200", 148},    {"H200", 132},    {"H100", 132},     {"A100", 108},
                         {"V100", 80},     {"L40S", 142},    {"L40", 142},      {"L4", 58},
                         {"A10", 72},      {"T4", 40},       {"RTX 5090", 170}, {"RTX 4090", 128},
                         {"RTX 4080", 76}, {"RTX 4070", 46}, {"RTX 4060", 24},  {"RTX 3090", 82},
                         {"RTX 3080", 68}, {"RTX 3070", 46}, {"RTX 3060", 28},  {"RTX 2080", 46}};

// The letters and digits of a name, in lower case.
std::string plain(std::string_view name) {
  std::string text;
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      text += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

std::optional<uint32_t> multiprocessors(const std::string& gpu) {
  constexpr uint32_t kMost = 4096;
  uint32_t number = 0;
  const auto read = std::from_chars(gpu.data(), gpu.data() + gpu.size(), number);
  if (read.ec == std::errc() && read.ptr == gpu.data() + gpu.size())
    return number > 0 && number <= kMost ? std::optional(number) : std::nullopt;
  for (const Gpu& known : kGpus)
    if (plain(known.name) == plain(gpu)) return known.multiprocessors;
  return std::nullopt;
}

std::string known_gpus() {
  std::string names;
  for (const Gpu& known : kGpus) names += (names.empty() ? "" : ", ") + std::string(known.name);
  return names;
}

uint32_t patches_in_flight(uint32_t multiprocessors) {
  constexpr uint32_t kEach = 4 * 32, kMultiple = 512;
  return std::max(1u, (multiprocessors * kEach + kMultiple / 2) / kMultiple) * kMultiple;
}

}  // namespace psplit
