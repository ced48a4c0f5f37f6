// Successive hues are a golden section of the circle apart. So they never repeat, and any few successive hues
// are well spread. Colours are mixed in OKLab (Björn Ottosson, "A perceptual color space for image processing",
// 2020), where hues of one lightness look equally light.
#include <algorithm>
#include <numbers>

#include "tools/gltf_psplit/preview/picture.h"

namespace psplit {
namespace {

constexpr double kLightness = 0.77, kChroma = 0.115;
constexpr size_t kCandidates = 32;
constexpr double kClearlyApart = 0.13;  // share of the circle

// A full turn is 1.
double hue(size_t number) {
  constexpr double kBlue = 0.68;
  const double turns = kBlue + static_cast<double>(number) / std::numbers::phi;
  return turns - std::floor(turns);
}

double hue_distance(double a, double b) {
  const double d = std::abs(a - b);
  return std::min(d, 1 - d);
}

Color color_of_hue(double hue) {
  const double angle = 2 * std::numbers::pi * hue;
  const double a = kChroma * std::cos(angle), b = kChroma * std::sin(angle);
  const auto cube = [](double v) { return v * v * v; };
  const double l = cube(kLightness + 0.3963377774 * a + 0.2158037573 * b);
  const double m = cube(kLightness - 0.1055613458 * a - 0.0638541728 * b);
  const double s = cube(kLightness - 0.0894841775 * a - 1.2914855480 * b);
  const auto in_gamut = [](double v) { return std::clamp(v, 0.0, 1.0); };
  return {in_gamut(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
          in_gamut(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
          in_gamut(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

// Sorted pairs (higher, lower) of neighbours. If more than three patches meet at a point, pairs that share only
// that point may be missing.
std::vector<std::array<uint32_t, 2>> neighbours(std::span<const std::array<uint32_t, 3>> faces,
                                                uint32_t point_count, std::span<const uint32_t> face_base) {
  constexpr uint32_t kNoPatch = UINT32_MAX;
  std::vector<uint32_t> lowest(point_count, kNoPatch),
      latest(point_count, kNoPatch);  // the lowest and the latest patch that uses a point
  std::vector<std::array<uint32_t, 2>> pairs;
  for (uint32_t patch = 0; patch + 1 < face_base.size(); ++patch)
    for (uint32_t face = face_base[patch]; face < face_base[patch + 1]; ++face)
      for (const uint32_t point : faces[face]) {
        if (latest[point] == patch) continue;
        if (lowest[point] == kNoPatch) lowest[point] = patch;
        for (const uint32_t other : {lowest[point], latest[point]})
          if (other != patch && other != kNoPatch) pairs.push_back({patch, other});
        latest[point] = patch;
      }
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace

std::vector<Color> patch_colors(std::span<const std::array<uint32_t, 3>> faces, uint32_t point_count,
                                std::span<const uint32_t> face_base, size_t first) {
  const size_t patch_count = face_base.size() - 1;
  const auto pairs = neighbours(faces, point_count, face_base);
  std::vector<double> hues;
  std::vector<Color> colors;
  size_t begin = 0;
  for (size_t patch = 0; patch < patch_count; ++patch) {
    size_t end = begin;
    while (end < pairs.size() && pairs[end][0] == patch) ++end;
    double best = 0, best_distance = -1;
    // The next hue of the series that is clearly different from all coloured neighbours, or else the most
    // different.
    for (size_t k = 0; k < kCandidates && best_distance < kClearlyApart; ++k) {
      const double candidate = hue(first + patch + k);
      double distance = 1;
      for (size_t i = begin; i < end; ++i)
        distance = std::min(distance, hue_distance(candidate, hues[pairs[i][1]]));
      if (distance <= best_distance) continue;
      best = candidate;
      best_distance = distance;
    }
    hues.push_back(best);
    colors.push_back(color_of_hue(best));
    begin = end;
  }
  return colors;
}

}  // namespace psplit
