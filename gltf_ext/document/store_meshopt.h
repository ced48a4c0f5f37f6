// Puts what meshoptimizer compressed into a document, as reading a file would have put it there.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/document.h"

namespace psplit {

// The buffer of a document that has the decoded bytes of views with the extension, and that a file has no bytes
// for. Made if there is none.
size_t meshopt_fallback(Document& document, const std::string& extension);

// Gives a buffer view its rows: compressed in a buffer of the file, and decoded at the end of the buffer that
// the view names. The view has the extension, or an empty object in its place.
void store_meshopt_rows(Document& document, size_t view, const MeshoptRecord& record,
                        std::span<const uint8_t> compressed, std::span<const uint8_t> decoded);

// Makes the views of EXT_meshopt_compression views of KHR_meshopt_compression, of the same values: attributes
// in version 1 of the codec where that is smaller. Nothing changes if a view is unreadable here.
void make_meshopt_khr(Document& document);

}  // namespace psplit
