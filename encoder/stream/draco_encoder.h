// Encodes a mesh as draco::Encoder and draco::ExpertEncoder do for the same calls of libdraco's interface: any
// attributes, in any order, on the caller's grids or on grids that fit the values.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "encoder/stream/attribute_plan.h"
#include "encoder/stream/encode_stream.h"
#include "psplit/base.h"
#include "psplit/encode.h"
#include "psplit/mesh.h"

namespace psplit {

// A mesh as a caller of libdraco builds it. Semantics are unique names; the first attribute whose label says so
// is POSITION.
struct DracoMesh {
  Mesh mesh;
  std::vector<DracoLabel> labels;  // of the mesh's attributes
  // Whether points with equal values of an attribute share one. Otherwise each point has a value of its own,
  // and two faces that share no point share no edge.
  std::vector<uint8_t> share_values;
};

// The type of the mesh's values. Types of 32 bits are unsigned here: the label says whether they are signed or
// floats. Types of 64 bits and bools have none.
inline std::optional<ComponentType> component_type_of(DataType type) {
  switch (type) {
    case DataType::kInt8: return ComponentType::kInt8;
    case DataType::kUint8: return ComponentType::kUint8;
    case DataType::kInt16: return ComponentType::kInt16;
    case DataType::kUint16: return ComponentType::kUint16;
    case DataType::kInt32:
    case DataType::kUint32: return ComponentType::kUint32;
    case DataType::kFloat32: return ComponentType::kFloat32;
    default: return std::nullopt;
  }
}

// What libdraco's DeduplicateAttributeValues and DeduplicatePointIds do: points share equal values, and points
// that are equal in all attributes become the first of them. Errors: kInvalidInput for indices out of range,
// then nothing changed.
Status deduplicate(DracoMesh& mesh);

// The attributes' codings are what the caller asked for: bits, also of integers, and perhaps a grid. A float
// attribute without an origin gets the grid that libdraco finds for its values.
//
// Integer normals are predicted by differences at all speeds. Below 4, libdraco predicts them as if they were
// on an octahedral grid, or fails.
//
// Values below a caller's grid have numbers below 0 on it; libdraco predicts from wrong positions then, and its
// decoder does not read the stream.
//
// Errors: kInvalidInput where libdraco's encoder fails: indices out of range, no face that Edgebreaker can
// encode, values that are not finite or do not fit.
// kUnsupported for more than one POSITION, for none with Edgebreaker, and for values that are 2^31 steps and
// more away from a caller's grid. Thread-safe.
Expected<LabelledStream> encode_as_draco(const DracoMesh& mesh, std::vector<AttributeCoding> codings,
                                         bool is_sequential, int speed);

// The methods of point clouds. The numbers are Draco's.
enum class CloudMethod : uint8_t { kSequential = 0, kTree = 1 };

// Encodes the points of a mesh without faces, as a draco::PointCloud: any attributes, in any order, several
// POSITIONs among them. Without a method, it is the one that libdraco chooses. Equal points stay, unless
// `deduplicate` made one of them.
//
// Errors: kInvalidInput where libdraco's encoder fails: no points, no attributes, a tree of floats that are on
// no grid, values that are not finite or do not fit. kUnsupported for values that are 2^31 steps and more away
// from a caller's grid, and for signed integers of a tree that are 2^31 and more apart: libdraco's decoder
// refuses its encoder's streams of these. Thread-safe.
Expected<LabelledStream> encode_cloud_as_draco(const DracoMesh& cloud, std::vector<AttributeCoding> codings,
                                               std::optional<CloudMethod> method, int speed);

}  // namespace psplit
