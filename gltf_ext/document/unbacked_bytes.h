// Zeros that no bytes stand for: how many an asset may claim.
#pragma once

#include "gltf_ext/document/document.h"

namespace psplit {

// An accessor without a buffer view is all zeros, but for sparse values. Attributes and indices of all
// primitives together may claim kFreeUnbackedBytes of them, and kUnbackedBytesOfAByte for each byte of the
// buffers. Morph targets have a limit of their own, for they count as their points do (read_morph_targets).
inline constexpr uint64_t kFreeUnbackedBytes = uint64_t{1} << 20;
inline constexpr uint64_t kUnbackedBytesOfAByte = 64;

// kInvalidInput, with the place where the limit is passed.
Status check_unbacked_bytes(const Document& document);

}  // namespace psplit
