// The formats of assets that psplit reads, and how they are told apart.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "mesh_files/scanner.h"

namespace psplit {

enum class AssetFormat { kGltf, kDraco, kPly, kObj, kStl, kOff };

// The content decides the format. If it does not show one (an OBJ with unusual lines, broken files), the name
// decides. Nothing for another format.
std::optional<AssetFormat> format_of(Scanner& scanner, const std::filesystem::path& source);

// A scanner of the stream, unpacked if it is gzip, and without the byte order mark that some programs write
// before UTF-8. Errors: as for the stream, kInvalidInput if it is empty, kUnsupported for text in UTF-16 or
// UTF-32.
Expected<Scanner> open_scanner(std::unique_ptr<ByteStream> stream);

// Whether the extension of a name is one of these formats, in any case: ".ply" and ".ply.gz", for example.
bool is_asset_name(const std::filesystem::path& path);
// The name without ".gz" and without the extension of a format before it: "a.ply.gz" becomes "a".
std::filesystem::path without_asset_extensions(const std::filesystem::path& path);
// ".gltf, .glb, .drc, .ply, .obj, .stl or .off", for help texts and messages.
std::string asset_extensions_text();

}  // namespace psplit
