// Where the images of an asset go that is written to another place.
#pragma once

#include <filesystem>
#include <optional>

#include "gltf_ext/document/document.h"
#include "gltf_ext/document/pack_buffers.h"

namespace psplit {

// Embeds, copies or refers to each image that is a file, and says in the report what became of it. `packed` is
// the document to be written, which came of `document`; `output` is the path of its file. Images by data URI,
// by buffer view, by absolute path or on the web stay as they are, and so do files that are missing or hold no
// image; whatever dangles in the output is a warning. No file is replaced.
// kIo where an image cannot be read, or a copy cannot be written.
Status place_images(const Document& document, const std::filesystem::path& output, ImagePlacement placement,
                    PackedDocument& packed, WriteReport& report);

}  // namespace psplit
