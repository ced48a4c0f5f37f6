#include "encoder/coding/grid_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "encoder/coding/quantization.h"
#include "src/core/octahedral.h"

namespace psplit {
namespace {

bool decides_no_topology(const Attribute& attribute, const AttributeCoding& coding) {
  return coding.bits > 0 && attribute.semantic != "POSITION";
}

// The unit vector of the nearest place of an octahedral grid of `bits`.
std::array<float, 3> round_direction(const std::array<float, 3>& vector, int bits) {
  const int32_t center = (1 << (bits - 1)) - 1;
  const double sum = std::fabs(double{vector[0]}) + std::fabs(double{vector[1]}) + std::fabs(double{vector[2]});
  constexpr double kLeastSum = 1e-6;  // a shorter vector is taken as (1, 0, 0)
  std::array<double, 3> share{1, 0, 0};
  const double scale = 1 / sum;
  for (size_t i = 0; i < 3 && sum > kLeastSum && std::isfinite(sum); ++i) share[i] = double{vector[i]} * scale;
  const auto nearest = [&](double x) { return static_cast<int32_t>(std::floor(x * center + 0.5)); };
  const int32_t x = nearest(share[0]);
  int32_t y = nearest(share[1]), z = center - std::abs(x) - std::abs(y);
  if (z < 0) {  // both were rounded up
    y += y > 0 ? z : -z;
    z = 0;
  }
  const core::OctahedralGrid grid(bits);
  std::array<float, 3> unit{};
  grid.unit_vector(grid.project({x, y, share[2] < 0 ? -z : z}, false), unit.data());
  return unit;
}

Array<std::byte> places_of(const Attribute& attribute, const AttributeCoding& coding) {
  Array<std::byte> places(attribute.values.size());
  std::vector<float> value(attribute.component_count);
  for (size_t at = 0; at < places.size(); at += attribute.stride()) {
    std::memcpy(value.data(), attribute.values.data() + at, attribute.stride());
    if (coding.octahedral)
      round_to_grid(value, coding);
    else
      for (size_t c = 0; c < value.size(); ++c)
        value[c] = coding.range > 0 ? grid_place(value[c], coding.origin[c], coding.range, coding.bits) : 0;
    std::memcpy(places.data() + at, value.data(), attribute.stride());
  }
  return places;
}

}  // namespace

void round_to_grid(Span<float> value, const AttributeCoding& grid) {
  if (grid.octahedral) {
    std::ranges::copy(round_direction({value[0], value[1], value[2]}, grid.bits), value.begin());
    return;
  }
  const float step = grid.range / static_cast<float>((1u << grid.bits) - 1);
  for (size_t c = 0; c < value.size(); ++c)
    value[c] = grid.range > 0
                   ? grid_place(value[c], grid.origin[c], grid.range, grid.bits) * step + grid.origin[c]
                   : grid.origin[c];
}

std::function<Array<std::byte>(size_t)> places_on_grids(const Mesh& mesh, Span<const AttributeCoding> codings) {
  if (std::ranges::equal(mesh.attributes, codings, std::not_fn(decides_no_topology))) return {};
  return [&mesh, codings](size_t i) {
    const bool is_rounded = decides_no_topology(mesh.attributes[i], codings[i]);
    return is_rounded ? places_of(mesh.attributes[i], codings[i]) : Array<std::byte>();
  };
}

}  // namespace psplit
