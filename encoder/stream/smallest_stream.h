// Encodes one patch, or a whole mesh, as the Edgebreaker stream of fewest bytes: by choices that a Draco
// decoder understands, and that libdraco's encoder makes by its speed (encode_stream.h).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "encoder/fields/draco_fields.h"
#include "encoder/stream/attribute_plan.h"
#include "encoder/stream/patch_mesh.h"
#include "encoder/welding/weld.h"
#include "psplit/base.h"
#include "psplit/encode.h"

namespace psplit {

// As encode_stream, for the same decoded mesh. The following are tried, and the smallest are taken:
//
//   of the connectivity    the standard and the valence traversal
//   of each attribute      each of its possible schemes; if it has no seams, on the walk depth first and on the
//                          one by prediction degree
//   of the stream          the levels of libdraco's symbol encoder, which all attributes share
//
// So it takes at most the bytes of any speed below kSpeedOfOneTable.
//
// in_creation_order is for streams that are to be condensed: POSITION and morph targets have only the schemes
// that condensed streams code in order of creation, on the walk depth first. The traversal and the level are as
// at speed 5: condensed streams do not depend on them, and share the bytes that are equal in all.
Expected<EncodedPatch> encode_smallest_stream(const WeldedMesh& welded, const PatchMesh& patch,
                                              std::span<const AttributeCoding> codings,
                                              bool with_values = false, bool in_creation_order = false);

// The prediction schemes that a Draco decoder understands for an attribute, the fastest to decode first.
// Normals on an octahedral grid keep their transform. Texture coordinates and normals are predicted from
// positions whose numbers are integers. `texture_bits` are the bits of texture coordinates; for
// texture_may_overflow see plan_attributes.
std::vector<core::Scheme> possible_schemes(const AttributePlan& plan, int texture_bits,
                                           const AttributePlan& positions,
                                           const std::function<bool(size_t)>& texture_may_overflow);

}  // namespace psplit
