// How libdraco's encoder codes the attributes of a mesh, and the bytes that say so.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "psplit/decode.h"
#include "psplit/encode.h"
#include "psplit/mesh.h"
#include "src/core/attributes.h"
#include "src/core/prediction_data.h"

namespace psplit {

// Draco's attribute type, which selects the prediction. Normals that are not on the octahedral grid, and
// texture coordinates that are not pairs, must not get the schemes of their types, which cannot handle them. In
// a cloud the type selects nothing, and normals always have their own.
DracoSemantic draco_semantic(const Attribute& attribute, const AttributeCoding& coding, bool is_cloud = false);

// Indices of the mesh's attributes in the order of their unique ids, which is that of the stream: POSITION
// first.
std::vector<size_t> attribute_order(const Mesh& mesh);

// How a caller of Draco's own interface describes an attribute, whatever glTF would call it.
struct DracoLabel {
  DracoSemantic semantic = DracoSemantic::kGeneric;
  DataType type = DataType::kFloat32;  // kInt32: signed numbers, which the mesh has as kUint32
};

// What the choices depend on, besides the attributes.
struct StreamTraits {
  int speed = 5;             // 0 to 10
  uint32_t point_count = 0;  // of the mesh to encode, before vertices are split
  bool is_sequential = false;
  bool is_cloud = false;  // without faces
  // The labels of the mesh's attributes, if given. Attributes are then in the order of unique ids, and the
  // stream uses the codings' grids. If empty, labels follow from glTF's semantics, and POSITION comes first.
  std::span<const DracoLabel> labels{};
};

// The speed from which on Edgebreaker cuts the mesh at all seams, and attributes share a table and a group.
inline constexpr int kSpeedOfOneTable = 6;
// The speed from which on nothing is predicted from positions.
inline constexpr int kSpeedWithoutPositions = 4;

// The only speed at which the group of POSITION is walked by prediction degree.
inline constexpr int kSpeedByDegree = 0;

// Integers that are stored as they are have at most this many.
inline constexpr int kMostBitsOfIntegers = 16;

// Whether libdraco predicts texture coordinates of this many bits from positions of these. Positions without
// bits are integers.
constexpr bool predicts_texture(int position_bits, int texture_bits) {
  constexpr int kMostBits = 21, kMostProductBits = 63;
  return position_bits == 0 ||
         (position_bits <= kMostBits && 2 * position_bits + texture_bits <= kMostProductBits);
}

// How an attribute is stored.
struct AttributePlan {
  size_t source = 0;   // its index in the mesh
  uint32_t group = 0;  // of the connectivity: 0 is that of POSITION, and of all attributes that share one table
  // semantic, type, components, normalized, unique_id, coding, bits; and range, with `origin`.
  core::Attribute<uint32_t> description;
  std::vector<float> origin;  // of kQuantized
  core::Scheme scheme = core::Scheme::kNone;
  core::Transform transform = core::Transform::kWrap;
  bool by_degree = false;  // its group is walked by prediction degree, otherwise depth first

  bool is_predicted() const { return scheme != core::Scheme::kNone; }
};

// The plans of the attributes in the order of the stream, group after group. `seams_of` comes from the welded
// mesh (weld.h). kQuantized attributes have the codings' grids: set_stream_grid (attribute_values.h) makes them
// libdraco's, if there are no labels. texture_may_overflow(i) says for an attribute of the mesh that has
// texture coordinates whether to predict them by parallelogram, because products with positions may exceed 64
// bits.
std::vector<AttributePlan> plan_attributes(const Mesh& mesh, std::span<const size_t> seams_of,
                                           std::span<const AttributeCoding> codings, const StreamTraits& traits,
                                           const std::function<bool(size_t)>& texture_may_overflow);

// The level of compression that libdraco's symbol encoder is told (DracoFields::symbol_level).
constexpr int symbol_level_of(int speed) { return 10 - speed; }

// The literal bytes of an attribute in a stream. Each function appends to `out`.
void append_description(const AttributePlan& plan, std::vector<uint8_t>& out);
// append_scheme writes the bytes before the symbols, append_prediction_grid the octahedral grid after the
// fields of a prediction. Nothing if values are raw.
void append_scheme(const AttributePlan& plan, std::vector<uint8_t>& out);
void append_prediction_grid(const AttributePlan& plan, std::vector<uint8_t>& out);
// Writes the transform from integers to values.
void append_transform(const AttributePlan& plan, std::vector<uint8_t>& out);

// The skeleton of an Edgebreaker stream without metadata (DracoFields::skeleton). has_seams says for each
// attribute data whether any edge is on one of its seams. Below kSpeedOfOneTable each group after the first is
// an attribute data; from that speed on there is none, and has_seams is empty.
std::vector<uint8_t> edgebreaker_skeleton(std::span<const AttributePlan> plans, bool is_valence,
                                          std::span<const uint8_t> has_seams);

}  // namespace psplit
