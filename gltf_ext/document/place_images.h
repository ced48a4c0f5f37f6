// Places the images of an asset that is written to another folder.
#pragma once

#include <filesystem>

#include "gltf_ext/document/document.h"
#include "gltf_ext/document/pack_buffers.h"
#include "psplit/document.h"

namespace psplit {

// Embeds, copies or refers to each image that is a file, and adds to the report what became of it. `packed` is
// the document to be written, made from `document`; `output` is the path of its file. An image stays as it is
// if it is a data URI, a buffer view, an absolute path or on the web, if its file is missing, or if the file
// holds no image. A reference that dangles in the output is a warning. No file is replaced.
// Errors: kIo if an image cannot be read or a copy cannot be written.
Status place_images(const Document& document, const std::filesystem::path& output, ImagePlacement placement,
                    PackedDocument& packed, WriteReport& report);

}  // namespace psplit
