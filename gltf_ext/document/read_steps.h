// What reading a document does once its JSON is parsed and its buffers are loaded.
#pragma once

#include "gltf_ext/document/document.h"

namespace psplit {

// Checks the version of glTF, and the kinds of the top-level members and of all extensions. Errors:
// kInvalidInput, kUnsupported (another version of glTF).
Status check_members(const Json& json);

// Checks the types of attributes that glTF defines, that every index of a node, mesh, skin, camera, material,
// texture, image, sampler or scene names one that exists, that no node is its own descendant, and that every
// skin has joints, with as many inverse bind matrices. Unknown members are allowed. Errors: kInvalidInput.
Status check_scene(const Document& document);

// An accessor without a buffer view is all zeros, except for sparse values. The attributes and indices of all
// primitives together may claim kFreeUnbackedBytes of them, plus kUnbackedBytesOfAByte for each byte of the
// buffers. Morph targets have a limit of their own, because their size follows from their points
// (read_morph_targets).
inline constexpr uint64_t kFreeUnbackedBytes = uint64_t{1} << 20;
inline constexpr uint64_t kUnbackedBytesOfAByte = 64;

// Errors: kInvalidInput, with the primitive that exceeds the limit.
Status check_unbacked_bytes(const Document& document);

// Decodes every compressed buffer view, filters included. The views keep the extension and the compressed
// bytes, and refer to the decoded ones. Those take the place of the buffers that the views named: a placeholder
// remains one for writers (is_placeholder). Views whose bitstream is newer than the linked meshoptimizer stay
// as they are. The buffers must be loaded. Decoded data is at most 64 times as large as compressed data, which
// is the most that the codec reaches. Errors: kInvalidInput.
Status decode_meshopt_views(Document& document);

}  // namespace psplit
