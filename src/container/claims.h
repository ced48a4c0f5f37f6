// The claims of streams and directories, checked before memory is taken for them.
#pragma once

#include <span>

#include "psplit/decode.h"
#include "src/container/patch_container.h"

namespace psplit {

// kVersion and kRequest are kUnsupported, all others are kInvalidInput.
Status status_of(core::Fault fault);

// Errors: as for status_of, and kInvalidInput for counts that the stream's bytes do not justify.
Expected<core::StreamHeader> read_stream_header(std::span<const uint8_t> stream);

// Reads and checks the header of a container's stream, of either kind. Also compares it with the stream's row,
// and with the header of patch `first`, which it reads, unless that is the patch itself.
Expected<core::StreamHeader> header_of_stream(const PatchContainer& container, uint32_t patch,
                                              uint32_t first = 0);

// Whether the bytes justify the memory for all faces and points. open_container checks this. Of a stock stream,
// callers check it that take memory for the largest number of points that it may have.
Status check_claims(const PatchContainer& container);

// Whether `stored_bytes` justify the memory that indices and requested values take.
Status check_results(uint64_t point_count, uint64_t face_count, std::span<const AttributeRequest> requests,
                     uint64_t stored_bytes);
// An overload for values of `point_bytes` for each point.
Status check_results(uint64_t point_count, uint64_t face_count, uint64_t point_bytes, uint64_t stored_bytes);

// Whether an attribute of a stream has the components that are requested. 0 stands for a stream without that
// attribute.
Status check_request(const AttributeRequest& request, uint32_t components);

// The largest amount of such memory that `stored_bytes` justify, for one mesh or for many together.
uint64_t justified_result_bytes(uint64_t stored_bytes);

// "the stream has 7 points, the directory says 8"
Status differs_from_directory(const char* what, uint32_t stream, uint32_t directory);

}  // namespace psplit
