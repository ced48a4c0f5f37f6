// The connectivity of an Edgebreaker stream, as libdraco's encoder writes it at a speed.
//
//   source_table.h      faces of points -> corner table
//   traverse_faces.h    corner table -> symbols, split events, start faces
//   src/core            symbols -> the decoder's corner table, and the lists of the valence traversal
//   here                values of points -> seams; groups of attributes, and the order of their values
//
// The values of attributes are predicted on the tables that a decoder will have.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "encoder/fields/draco_fields.h"
#include "psplit/base.h"
#include "src/core/patch.h"

namespace psplit {

// A mesh as Draco sees it. The spans must outlive only the call.
struct SourceMesh {
  uint32_t point_count = 0;
  std::span<const std::array<uint32_t, 3>> faces;  // points
  // For each attribute with seams of its own (WeldedMesh::seams_of), in the order of the stream, POSITION
  // first, the number of each point's value. Numbers of POSITION are below point_count; others may be any.
  // Equal numbers are equal values.
  std::span<const std::span<const uint32_t>> values;
  std::span<const std::array<uint32_t, 3>> neighbours{};  // as PatchMesh has them, or empty
};

// What libdraco's encoder does at a speed.
struct ConnectivityChoices {
  bool valence = false;    // the valence traversal, otherwise the standard one
  bool one_table = false;  // all attributes have the table of the points, otherwise each its own
  bool by_degree = false;  // POSITION is walked by prediction degree
};
ConnectivityChoices choose_connectivity(int speed, uint64_t face_count);

struct EncodedConnectivity {
  // All fields except attributes and their levels, and the skeleton.
  DracoFields fields;
  // The source's point at each corner of the decoder's tables, 4 * face + k.
  std::vector<uint32_t> point_of_corner;
  // The mesh, the points and the groups as a decoder will have them, with the order of values of each group.
  // It has no attributes.
  core::Patch<uint32_t> patch;
  std::unique_ptr<uint8_t[]> memory;  // of the patch
  size_t table_bytes = 0;             // of the stream, when it is written: tables of probabilities
};

// Errors: kInvalidInput if every face uses a vertex twice, and for meshes that libdraco's decoder refuses;
// kUnsupported for too many faces or attributes. Thread-safe.
Expected<EncodedConnectivity> encode_connectivity(const SourceMesh& mesh, const ConnectivityChoices& choices);

}  // namespace psplit
