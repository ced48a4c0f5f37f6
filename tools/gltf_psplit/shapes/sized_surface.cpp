#include "tools/gltf_psplit/shapes/sized_surface.h"

#include <algorithm>
#include <cmath>

namespace psplit {
namespace {

constexpr double kCloseEnough = 0.019;

// Keeps the first 14 bits. The last bits of std::pow differ between machines, and the whole mesh depends on the
// cell.
double drop_last_bits(double value) {
  int exponent = 0;
  const double mantissa = std::frexp(value, &exponent);
  return std::ldexp(std::round(mantissa * 16384), exponent - 14);
}

}  // namespace

// The number of faces is proportional to the inverse square of the cell. Two coarse attempts determine the cell
// for the requested number.
Expected<double> find_cell(uint64_t faces, const std::function<Expected<uint64_t>(double cell)>& count_faces) {
  constexpr double kCoarseFaces = 5000;
  const auto wanted = static_cast<double>(faces);
  const auto target = [&](int attempt) {
    const double part = attempt == 0 ? wanted / 64 : attempt == 1 ? wanted / 8 : wanted;
    return std::clamp(part, std::min(wanted, kCoarseFaces), wanted);
  };
  double cell = std::sqrt(40 / target(0));
  double best = 0, best_miss = HUGE_VAL;
  for (int attempt = 0; attempt < 16 && best_miss > kCloseEnough; ++attempt) {
    const Expected<uint64_t> count = count_faces(cell);
    if (!count) return count.status();
    if (*count == 0) {
      cell *= 0.7;
      continue;
    }
    const auto found = static_cast<double>(*count);
    const double miss = std::fabs(found - wanted) / wanted;
    if (miss < best_miss) {
      best = cell;
      best_miss = miss;
    }
    // For small meshes the count jumps as the cell shrinks. Shorter steps later on stop it from oscillating.
    cell = drop_last_bits(cell * std::pow(found / target(attempt + 1), attempt < 6 ? 0.5 : 0.3));
  }
  if (best == 0) return runtime_failure("the shape has no faces");
  return best;
}

Expected<SizedSurface> extract_about(const Field& field, uint64_t faces, uint64_t seed,
                                     const ThreadPool& pool) {
  SizedSurface result;
  const auto extract = [&](double cell) -> Expected<uint64_t> {
    result = {cell, {}};
    Surface& surface = result.surface;
    const auto append = [&](Surface&& slab) -> Status {
      surface.positions.insert(surface.positions.end(), slab.positions.begin(), slab.positions.end());
      surface.faces.insert(surface.faces.end(), slab.faces.begin(), slab.faces.end());
      return {};
    };
    if (Status status = stream_surface(field, cell, seed, pool, append); !status.ok()) return status;
    return surface.faces.size();
  };
  const Expected<double> cell = find_cell(faces, extract);
  if (!cell) return cell.status();
  if (result.cell != *cell)
    if (const Expected<uint64_t> again = extract(*cell); !again) return again.status();
  return result;
}

std::array<float, 3> normal_at(const Field& field, const std::array<float, 3>& position, double step) {
  const Vec3 p = {position[0], position[1], position[2]};
  constexpr double kEverywhere = 1e9;
  const auto along = [&](Vec3 axis) {
    return field.at(p + axis, kEverywhere) - field.at(p - axis, kEverywhere);
  };
  const Vec3 gradient = {along({step, 0, 0}), along({0, step, 0}), along({0, 0, step})};
  const double size = length(gradient);
  if (!(size > 0)) return {0, 1, 0};
  return {static_cast<float>(gradient.x / size), static_cast<float>(gradient.y / size),
          static_cast<float>(gradient.z / size)};
}

}  // namespace psplit
