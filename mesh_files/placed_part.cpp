#include "mesh_files/placed_part.h"

#include <algorithm>
#include <cstring>

#include "mesh_files/origin.h"
#include "src/mesh/number_of.h"

namespace psplit {

const MeshView::Values* PlacedPart::find(std::string_view semantic) const {
  const auto found = std::ranges::find(view.attributes, semantic, &MeshView::Values::semantic);
  return found == view.attributes.end() ? nullptr : &*found;
}

std::array<uint32_t, 3> PlacedPart::face(size_t number) const {
  std::array<uint32_t, 3> face{};
  for (size_t i = 0; i < 3; ++i) face[i] = view.index(3 * number + i);
  if (mirrored) std::swap(face[1], face[2]);
  return face;
}

std::array<float, 4> PlacedPart::floats_at(const MeshView::Values& attribute, size_t point) const {
  const ValuesView& values = attribute.values;
  const size_t count = std::min<size_t>(values.component_count, 4),
               bytes = component_bytes(values.component_type);
  std::array<float, 4> floats{};
  for (size_t i = 0; i < count; ++i) {
    const std::byte* const component = values.at(point) + i * bytes;
    // A conversion to double and back could change the bits of a NaN.
    if (values.component_type == ComponentType::kFloat32)
      std::memcpy(&floats[i], component, sizeof(float));
    else
      floats[i] = static_cast<float>(number_of(component, values.component_type, values.normalized));
  }
  if (!place) return floats;
  const std::array<double, 4> doubles = doubles_at(attribute, point);
  for (size_t i = 0; i < count; ++i) floats[i] = static_cast<float>(doubles[i]);
  return floats;
}

std::array<double, 4> PlacedPart::doubles_at(const MeshView::Values& attribute, size_t point) const {
  const ValuesView& values = attribute.values;
  const size_t count = std::min<size_t>(values.component_count, 4),
               bytes = component_bytes(values.component_type);
  std::array<double, 4> doubles{};
  for (size_t i = 0; i < count; ++i)
    doubles[i] = number_of(values.at(point) + i * bytes, values.component_type, values.normalized);
  if (place) place(attribute.semantic, std::span(doubles).first(count));
  return doubles;
}

PositionSpread position_spread(const PlacedPart& part) {
  const MeshView::Values* const positions = part.find("POSITION");
  PositionSpread spread;
  for_each_block(part, [&](size_t first, size_t end) {
    for (size_t point = first; point < end; ++point) {
      const std::array<double, 4> at = part.doubles_at(*positions, point);
      spread.add(PrecisePosition{at[0], at[1], at[2]});
    }
  });
  return spread;
}

bool need_doubles(std::span<const PlacedPart> parts) {
  std::vector<PositionSpread> spreads;
  for (const PlacedPart& part : parts)
    if (part.place) spreads.push_back(position_spread(part));
  return need_doubles(spreads);
}

bool all_have(std::span<const PlacedPart> parts, std::string_view semantic, int component_count) {
  return std::ranges::all_of(parts, [&](const PlacedPart& part) {
    const MeshView::Values* const found = part.find(semantic);
    return found != nullptr && found->values.component_count == component_count;
  });
}

}  // namespace psplit
