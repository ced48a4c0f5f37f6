// Small meshes with seams, and attributes of every role, type and coding.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "encoder/coding/quantization.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {

// A sheet of few quads, some of which are missing. Corners at one place are one point or several, so that there
// are seams. Attributes have any role, type and number of components; their values are smooth, few, or
// anything.
struct RandomMesh {
  Mesh mesh;
  std::vector<AttributeCoding> codings;
};
// Makes integers of floats: of the type with this number, 0 to 4. Numbers of signed types have both signs.
inline void make_integers(Attribute& attribute, uint32_t type, bool normalized) {
  const auto convert = [&]<typename T>(ComponentType component_type, float scale, float offset, T) {
    std::vector<T> integers;
    for (const float value : values_of<float>(attribute))
      integers.push_back(static_cast<T>(static_cast<int64_t>(value * scale - offset)));
    attribute =
        make_attribute(attribute.semantic, component_type, attribute.component_count, normalized, integers);
  };
  switch (type) {
    case 0: return convert(ComponentType::kInt8, 12, 60, int8_t{});
    case 1: return convert(ComponentType::kUint8, 25, 0, uint8_t{});
    case 2: return convert(ComponentType::kInt16, 2999, 14999, int16_t{});
    case 3: return convert(ComponentType::kUint16, 5999, 0, uint16_t{});
    default: return convert(ComponentType::kUint32, 9999, 0, uint32_t{});
  }
}
inline RandomMesh random_mesh(std::mt19937& random) {
  const auto below = [&](uint32_t count) { return static_cast<uint32_t>(random()) % count; };
  const auto unit = [&] { return static_cast<float>(below(1u << 24)) / 16777216.0f; };
  const uint32_t columns = 1 + below(9), rows = 1 + below(9), copies = 1 + below(3);
  RandomMesh made;
  Faces faces = make_grid(columns, rows).faces;
  const uint32_t places = (columns + 1) * (rows + 1);
  for (auto& face : faces)
    for (uint32_t& point : face) point += places * (below(4) == 0 ? below(copies) : 0);
  for (uint32_t missing = below(4); missing > 0 && faces.size() > 1; --missing)
    faces.erase(faces.begin() + below(static_cast<uint32_t>(faces.size())));
  const float noise = below(3) == 0 ? 1.0f : 0.05f;
  std::vector<float> at;
  for (uint32_t place = 0; place < places; ++place)
    at.insert(at.end(), {static_cast<float>(place % (columns + 1)) + noise * unit(),
                         static_cast<float>(place / (columns + 1)) + noise * unit(), noise * unit()});
  std::vector<float> positions;
  for (uint32_t copy = 0; copy < copies; ++copy) positions.insert(positions.end(), at.begin(), at.end());
  made.mesh = make_mesh(positions, faces);
  if (below(4) == 0) make_integers(made.mesh.attributes[0], 1 + below(4), false);

  const uint32_t points = made.mesh.point_count;
  const auto add = [&](std::string semantic, uint32_t components, bool is_unit) {
    const uint32_t kind = below(3);  // smooth, few, or anything
    std::vector<float> values(size_t{points} * components);
    for (uint32_t i = 0; i < values.size(); ++i) {
      const uint32_t place = i / components % places;
      values[i] = kind == 0   ? at[3 * place + i % components % 3] / 9.0f
                  : kind == 1 ? static_cast<float>(below(2))
                              : unit();
    }
    for (uint32_t point = 0; is_unit && point < points; ++point) {
      float* const normal = &values[3 * size_t{point}];
      for (uint32_t k = 0; k < 3; ++k) normal[k] = below(5) == 0 ? 0 : normal[k] - 0.5f;
      const float length = std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
      for (uint32_t k = 0; k < 3; ++k) normal[k] = length == 0 ? (k == 2 ? -1.0f : 0.0f) : normal[k] / length;
    }
    made.mesh.attributes.push_back(
        float_attribute(std::move(semantic), static_cast<uint8_t>(components), values));
    if (!is_unit && below(3) == 0) make_integers(made.mesh.attributes.back(), below(5), below(2) == 0);
  };
  if (below(2) == 0) add("NORMAL", 3, true);
  if (below(2) == 0) add("TEXCOORD_0", 2, false);
  if (below(3) == 0) add("COLOR_0", 3 + below(2), false);
  if (below(3) == 0) add("_ANY", 1 + below(16), false);
  for (const Attribute& attribute : made.mesh.attributes) {
    AttributeCoding& coding = made.codings.emplace_back();
    if (attribute.component_type != ComponentType::kFloat32 || below(8) == 0) continue;
    const int bits = 1 + static_cast<int>(below(16));
    if (attribute.semantic == "NORMAL" && bits > 1)
      coding = {bits, true, {}, 0};
    else
      coding = must(fit_grid(attribute, bits));
  }
  return made;
}

}  // namespace psplit
