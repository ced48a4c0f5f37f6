// A document to a .glb or .gltf file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gltf_ext/document/document.h"
#include "src/export.h"

namespace psplit {

// What to do with images that are files.
enum class ImagePlacement {
  kEmbed,      // buffer views
  kCopy,       // files in the output's folder
  kReference,  // the input's files, by URIs that lead to them from the output's folder
};

struct WriteOptions {
  // By default a GLB embeds, and a .gltf copies.
  std::optional<ImagePlacement> images;
  bool replace_read_only = false;  // otherwise a file without permission to write is an error
};

struct WriteReport {
  std::vector<std::string> warnings;         // references that dangle in the output, and data that it loses
  std::vector<std::string> notes;            // files that got another name
  std::vector<std::filesystem::path> files;  // all files of the output, newly written or already there
  size_t embedded_images = 0, copied_images = 0;
  uint64_t image_bytes = 0;  // of embedded and copied images; every file counts once
};

// The bytes of a GLB of the document whose images stay where they are.
PSPLIT_EXPORT uint64_t glb_bytes(const Document& document);

// The extension of `path` gives the format: .glb, or .gltf with its .bin beside it; "-" writes a GLB to stdout.
// The file appears whole or not at all: it is written under another name and then renamed. A .bin is named
// after its content, so that a .gltf and its .bin change together. If a .gltf is replaced, its old .bin files
// are removed, unless `document` was read from it. All buffers become one. A .gltf gets a second buffer for
// data that only the fallback of compressed primitives, or coarse ones, use. No other file is replaced: if the
// name of a copied image is taken, the copy is named after its content. Errors: kUsage, kIo, kUnsupported.
PSPLIT_EXPORT Status write_document(const Document& document, const std::filesystem::path& path,
                                    const WriteOptions& options = {}, WriteReport* report = nullptr);

}  // namespace psplit
