// Mesh files as texts in tests, read from memory.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>

#include "gltf_ext/primitive/read_primitives.h"
#include "mesh_files/read_asset.h"
#include "psplit/decode.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {

inline std::span<const uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

// The name decides the format only if the content does not.
inline Expected<Asset> read_text(const std::string& text, const std::string& name = "test") {
  return read_asset(memory_stream(bytes_of(text)), name, describe_stream);
}

inline Mesh mesh_of(const Expected<Asset>& asset, PrimitiveId id = {0, 0}) {
  EXPECT_TRUE(asset.ok()) << asset.status().to_string();
  if (!asset) return {};
  return must(read_primitive(asset->document, id, cpu_backend(), ThreadPool(1)));
}

inline std::string message_of(const std::string& text, const std::string& name = "test",
                              StatusCode code = StatusCode::kInvalidInput) {
  const Expected<Asset> asset = read_text(text, name);
  EXPECT_EQ(asset.status().code(), code) << text.substr(0, 200) << asset.status().to_string();
  return asset.status().message();
}

inline std::vector<float> floats_of(const Mesh& mesh, const std::string& semantic) {
  const Attribute* attribute = mesh.find(semantic);
  if (attribute == nullptr || attribute->component_type != ComponentType::kFloat32) return {};
  return values_of<float>(*attribute);
}

inline std::string warnings_of(const Expected<Asset>& asset) {
  std::string text;
  if (asset)
    for (const std::string& warning : asset->warnings) text += warning + "\n";
  return text;
}

inline double area_of(const Mesh& mesh) {
  const std::vector<float> p = floats_of(mesh, "POSITION");
  double area = 0;
  for (const auto& face : mesh.faces) {
    const uint32_t a = face[0], b = face[1], c = face[2];
    double cross[3];
    for (size_t axis = 0; axis < 3; ++axis) {
      const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
      const auto edge = [&](uint32_t to, size_t along) { return double{p[3 * to + along]} - p[3 * a + along]; };
      cross[axis] = edge(b, u) * edge(c, v) - edge(b, v) * edge(c, u);
    }
    area += std::sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]) / 2;
  }
  return area;
}

}  // namespace psplit
