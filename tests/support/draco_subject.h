// Meshes and options for libdraco's encoder, which can say more than ours: any type, any prediction.
#pragma once

#include <draco/compression/config/compression_shared.h>
#include <draco/mesh/mesh.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tests/support/procedural_meshes.h"

namespace psplit {

using Role = draco::GeometryAttribute::Type;
// The roles of the bitstream: position, normal, colour, texture coordinate, generic.
inline constexpr size_t kRoleCount = 5;
using PerRole = std::array<int, kRoleCount>;

// An attribute of the mesh.
struct Values {
  Role role = Role::GENERIC;
  draco::DataType type = draco::DT_FLOAT32;
  int component_count = 1;
  bool normalized = false;
  std::vector<uint8_t> bytes;  // one value for each point
};

// The mesh to encode.
struct Subject {
  std::string name;
  uint32_t point_count = 0;
  Faces faces = {};
  std::vector<Values> attributes = {};
  bool welded = true;  // equal values of an attribute are merged, so that equal positions are one vertex
  bool metadata = false;
  uint32_t first_id = 0;
  draco::MeshAttributeElementType element = draco::MESH_CORNER_ATTRIBUTE;
};

enum class Pattern { kSmooth, kRandom, kConstant, kFew, kWide, kEnds };

// A number in [0, 1) from the point and the component.
double pattern_value(Pattern pattern, uint32_t point, int component);

// The bytes of values that `convert` makes of the pattern's numbers.
template <typename Convert>
std::vector<uint8_t> filled(uint32_t point_count, int component_count, Pattern pattern, Convert convert) {
  std::vector<uint8_t> bytes;
  for (uint32_t point = 0; point < point_count; ++point)
    for (int i = 0; i < component_count; ++i) {
      const auto value = convert(pattern_value(pattern, point, i));
      const auto* begin = reinterpret_cast<const uint8_t*>(&value);
      bytes.insert(bytes.end(), begin, begin + sizeof value);
    }
  return bytes;
}

// Adds an attribute whose values follow a pattern. Integers use the whole range of their type, but 32-bit
// integers do so only with kWide.
void add(Subject& subject, Role role, draco::DataType type, int component_count, Pattern pattern);

inline constexpr int kAuto = -1;  // libdraco decides
inline constexpr PerRole kUsualBits = {14, 10, 8, 12, 12};
inline constexpr PerRole kRawBits = {0, 0, 0, 0, 0};
inline constexpr PerRole kAutoSchemes = {kAuto, kAuto, kAuto, kAuto, kAuto};
inline constexpr int kStandard = draco::MESH_EDGEBREAKER_STANDARD_ENCODING;
inline constexpr int kValence = draco::MESH_EDGEBREAKER_VALENCE_ENCODING;

// The options of the encoder.
struct Recipe {
  int speed = 5;
  bool sequential = false;  // otherwise Edgebreaker; for a cloud, otherwise a kD-tree
  bool compress_indices = false;
  int connectivity = kAuto;
  int split_on_seams = kAuto;
  bool entropy_coding = true;
  bool given_grid = false;    // an origin and a range that exclude some values
  PerRole bits = kUsualBits;  // 0: floats are not quantized. The second attribute of a role has one bit less.
  PerRole scheme = kAutoSchemes;
};

std::string describe(const Recipe& recipe);
std::unique_ptr<draco::Mesh> build(const Subject& subject);
// Nothing if libdraco cannot encode the mesh so.
std::optional<std::vector<uint8_t>> encode(const draco::Mesh& mesh, const Recipe& recipe);
// As above, for the points of a mesh, as a point cloud. Level l of a kD-tree is speed 10 - l.
std::optional<std::vector<uint8_t>> encode_cloud(const draco::PointCloud& cloud, const Recipe& recipe);
// Encodes by a draco::PointCloudEncodingMethod, or with kAuto as libdraco chooses, with bits for each
// attribute.
std::optional<std::vector<uint8_t>> encode_cloud(const draco::PointCloud& cloud, int method, int speed,
                                                 std::span<const int> bits);

}  // namespace psplit
