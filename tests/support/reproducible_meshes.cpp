#include "tests/support/reproducible_meshes.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/procedural_meshes.h"

namespace psplit {

Mesh make_sheet(uint32_t columns, uint32_t rows) {
  Mesh mesh = make_grid(columns, rows);
  std::vector<float> positions, normals, texcoords, weights, temperatures;
  std::vector<uint8_t> colors, joints;
  for (uint32_t i = 0; i < mesh.point_count; ++i) {
    const uint32_t column = i % (columns + 1), row = i / (columns + 1);
    const float x = static_cast<float>(column), y = static_cast<float>(row);
    const float slope = static_cast<float>(column * row % 7) * 0.125f, length = std::sqrt(slope * slope + 2);
    positions.insert(positions.end(), {x, y, (x * x - y * y) * 0.0625f});
    normals.insert(normals.end(), {slope / length, 1 / length, 1 / length});
    texcoords.insert(texcoords.end(), {x * 0.03125f, y * 0.03125f});
    const float weight = static_cast<float>(i % 9) * 0.125f;
    weights.insert(weights.end(), {weight, 1 - weight, 0, 0});
    temperatures.push_back(static_cast<float>(i * i % 1009) - 300);
    for (uint32_t c = 0; c < 4; ++c) {
      colors.push_back(static_cast<uint8_t>(c == 3 ? 255 : column * (c + 2) + row));
      joints.push_back(static_cast<uint8_t>(i % (c + 3)));
    }
  }
  const auto floats = [](const char* semantic, uint8_t components, const std::vector<float>& values) {
    return make_attribute(semantic, ComponentType::kFloat32, components, false, values);
  };
  mesh.attributes = {floats("POSITION", 3, positions),
                     floats("NORMAL", 3, normals),
                     floats("TEXCOORD_0", 2, texcoords),
                     make_attribute("COLOR_0", ComponentType::kUint8, 4, true, colors),
                     make_attribute("JOINTS_0", ComponentType::kUint8, 4, false, joints),
                     floats("WEIGHTS_0", 4, weights),
                     floats("_TEMPERATURE", 1, temperatures)};
  return mesh;
}

Mesh make_sheet_with_residue() {
  Mesh mesh = make_sheet(40, 30);
  for (uint32_t i = 0; i < 50; ++i) mesh.faces.push_back({i, i, 3 * i + 1});
  for (Attribute& attribute : mesh.attributes) {
    const size_t old_size = attribute.values.size(), added = attribute.stride() * 60;
    attribute.values.resize(old_size + added);
    std::copy_n(attribute.values.begin(), added, attribute.values.begin() + static_cast<ptrdiff_t>(old_size));
  }
  for (uint32_t i = 0; i < 30; ++i) mesh.faces[5 * i][i % 3] = mesh.point_count + i;
  mesh.point_count += 60;
  return mesh;
}

uint64_t fnv1a(std::span<const uint8_t> bytes) {
  uint64_t hash = 0xcbf29ce484222325u;
  for (const uint8_t byte : bytes) hash = (hash ^ byte) * 0x100000001b3u;
  return hash;
}

}  // namespace psplit
