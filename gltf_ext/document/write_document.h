// A document to a .glb or .gltf file.
#pragma once

#include <optional>

#include "gltf_ext/document/document.h"
#include "gltf_ext/document/image_placement.h"
#include "gltf_ext/document/write_report.h"
#include "src/export.h"

namespace psplit {

struct WriteOptions {
  // By default a GLB embeds, and a .gltf copies.
  std::optional<ImagePlacement> images;
  bool replace_read_only = false;  // otherwise a file without permission to write is an error
};

// The extension of `path` gives the format: .glb, or .gltf with its .bin beside it; "-" writes a GLB to stdout.
// The file appears whole or not at all: it is written under another name and then renamed. A .bin is named
// after its content, so that a .gltf and its .bin change together. If a .gltf is replaced, its old .bin files
// are removed, unless `document` was read from it. All buffers become one. A .gltf gets a second buffer for
// data that only the fallback of compressed primitives uses. No other file is replaced: if the name of a copied
// image is taken, the copy is named after its content. Errors: kUsage, kIo, kUnsupported.
PSPLIT_EXPORT Status write_document(const Document& document, const std::filesystem::path& path,
                                    const WriteOptions& options = {}, WriteReport* report = nullptr);

}  // namespace psplit
