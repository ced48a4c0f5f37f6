#include "encoder/coding/grid_places.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "encoder/coding/octahedral_place.h"
#include "encoder/coding/quantization.h"

namespace psplit {
namespace {

bool decides_no_topology(const Attribute& attribute, const AttributeCoding& coding) {
  return coding.bits > 0 && attribute.semantic != "POSITION";
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
    const core::OctahedralGrid places(grid.bits);
    const float direction[] = {value[0], value[1], value[2]};
    places.unit_vector(octahedral_place(places, direction), value.data());
    return;
  }
  const float step = grid.range / static_cast<float>((1u << grid.bits) - 1);
  for (size_t c = 0; c < value.size(); ++c)
    value[c] = grid.range > 0
                   ? grid_place(value[c], grid.origin[c], grid.range, grid.bits) * step + grid.origin[c]
                   : grid.origin[c];
}

bool is_on_grid(const Attribute& attribute, const AttributeCoding& grid, Span<const uint8_t> stored) {
  std::vector<float> value(attribute.component_count), rounded;
  if (value.size() != (grid.octahedral ? 3 : grid.origin.size())) return false;
  for (size_t i = 0; i * attribute.stride() < attribute.values.size(); ++i) {
    if (!stored.empty() && stored[i] == 0) continue;
    std::memcpy(value.data(), attribute.values.data() + i * attribute.stride(), attribute.stride());
    // Places of other values may be no numbers.
    if (!std::ranges::all_of(value, [](float component) { return std::isfinite(component); })) return false;
    rounded = value;
    round_to_grid(rounded, grid);
    if (rounded != value) return false;
  }
  return true;
}

std::function<Array<std::byte>(size_t)> places_on_grids(const Mesh& mesh, Span<const AttributeCoding> codings) {
  if (std::ranges::equal(mesh.attributes, codings, std::not_fn(decides_no_topology))) return {};
  return [&mesh, codings](size_t i) {
    const bool is_rounded = decides_no_topology(mesh.attributes[i], codings[i]);
    return is_rounded ? places_of(mesh.attributes[i], codings[i]) : Array<std::byte>();
  };
}

}  // namespace psplit
