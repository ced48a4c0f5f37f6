// A limit on the zeros that an asset may claim without storing them.
#pragma once

#include "gltf_ext/document/document.h"

namespace psplit {

// An accessor without a buffer view is all zeros, except for sparse values. The attributes and indices of all
// primitives together may claim kFreeUnbackedBytes of them, plus kUnbackedBytesOfAByte for each byte of the
// buffers. Morph targets have a limit of their own, because their size follows from their points
// (read_morph_targets).
inline constexpr uint64_t kFreeUnbackedBytes = uint64_t{1} << 20;
inline constexpr uint64_t kUnbackedBytesOfAByte = 64;

// Errors: kInvalidInput, with the primitive that exceeds the limit.
Status check_unbacked_bytes(const Document& document);

}  // namespace psplit
