// What streams and directories claim, checked before memory is taken for it.
#pragma once

#include <span>

#include "src/container/container.h"
#include "src/container/decode_backend.h"
#include "src/core/stream_header.h"

namespace psplit {

// kVersion and kRequest are kUnsupported, all others kInvalidInput.
Status status_of(core::Fault fault);

// kUnsupported, and says which bitstream it is. `stream` is one of which the header says kVersion.
Status wrong_version(std::span<const uint8_t> stream);

// Errors: those of status_of, and kInvalidInput for claims that the stream's bytes do not justify.
Expected<core::StreamHeader> read_stream_header(std::span<const uint8_t> stream);

// The directory against the streams' own headers, and both against the number of bytes. The headers, which
// point into the streams. Errors name the patch.
Expected<std::vector<core::StreamHeader>> check_claims(const Container& container);

// The memory that so many points and faces take with these attributes, against the number of bytes that claim
// them.
Status check_results(uint64_t point_count, uint64_t face_count, std::span<const AttributeRequest> requests,
                     uint64_t stream_bytes);

// The most of it that any number of meshes may take together.
uint64_t justified_result_bytes(uint64_t stream_bytes);

// A Draco stream as the only patch of a container. Its row has the most points that it can decode to, and no
// more than there is room for. Errors: those of read_stream_header.
Expected<Container> container_of_stream(std::span<const uint8_t> stream, uint32_t room = 0xfffffffeu);

// Only the residue is sequential.
Status wrong_coding(bool is_residue);

Status differs_from_directory(const char* what, uint32_t stream, uint32_t directory);

}  // namespace psplit
