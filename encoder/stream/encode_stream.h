// Encodes one patch, or a whole mesh, as one Edgebreaker stream: the bytes that libdraco's encoder writes.
//
//   encode_connectivity.h  faces -> the fields of the connectivity, and the tables that a decoder will have
//   encode_attributes.h    values -> the fields of the attributes, which are predicted on these tables
//   encoder/fields          all fields -> bytes
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/stream/attribute_plan.h"
#include "encoder/stream/patch_mesh.h"
#include "encoder/welding/weld.h"
#include "psplit/base.h"
#include "psplit/decode.h"
#include "psplit/encode.h"

namespace psplit {

// How to request each attribute of the mesh, in order, from a decoder of any stream of it. Draco's unique id of
// POSITION is 0; the other attributes' ids follow in order.
std::vector<AttributeRequest> stream_requests(const Mesh& mesh);

// Decodes a stream of the mesh, or of a part of it. Errors: kRuntimeFailure.
Expected<Mesh> decode_stream(const Mesh& mesh, std::span<const uint8_t> bytes);

// Faces that use a vertex twice are left out. With `with_values`, the stream is decoded. Errors: kInvalidInput
// if there are no others; kUnsupported for values that no decoder would read back, as in libdraco. Thread-safe.
Expected<EncodedPatch> encode_stream(const WeldedMesh& welded, const PatchMesh& patch,
                                     std::span<const AttributeCoding> codings, int encode_speed,
                                     bool with_values = false);

// The bytes alone, for attributes with labels (attribute_plan.h), and the connectivity that they came from.
struct LabelledStream {
  std::vector<uint8_t> bytes;
  uint32_t point_count = 0, face_count = 0;  // as decoded
};
Expected<LabelledStream> encode_labelled(const WeldedMesh& welded, const PatchMesh& patch,
                                         std::span<const AttributeCoding> codings,
                                         std::span<const DracoLabel> labels, int encode_speed);

}  // namespace psplit
