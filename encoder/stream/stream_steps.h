// The steps of encoding one patch as an Edgebreaker stream, whatever makes the choices: a speed
// (encode_stream.h) or the bytes (smallest_stream.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "encoder/stream/encode_attributes.h"
#include "encoder/stream/encode_connectivity.h"
#include "encoder/stream/patch_mesh.h"
#include "encoder/welding/weld.h"
#include "psplit/base.h"

namespace psplit {

// The connectivity. Seams are where the welded mesh has different values. Errors: as encode_connectivity, and
// kUnsupported for too many points.
Expected<EncodedConnectivity> connect_patch(const WeldedMesh& welded, const PatchMesh& patch,
                                            const ConnectivityChoices& choices);

// The bytes of the stream. The fields of the connectivity become whole: they get the attributes.
Expected<std::vector<uint8_t>> write_stream(EncodedConnectivity& connectivity, EncodedAttributes attributes,
                                            bool is_valence, int symbol_level);

// How many of a stream's bytes are tables of probabilities, for streams that write_stream did not write. 0 if
// it has no fields.
size_t table_bytes_of(std::span<const uint8_t> stream);

// What the stream decodes to. With `with_values`, it is decoded.
Expected<EncodedPatch> describe_stream(const WeldedMesh& welded, const EncodedConnectivity& connectivity,
                                       std::vector<uint8_t> bytes, bool with_values);

}  // namespace psplit
