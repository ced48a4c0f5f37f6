// The input of a command.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "gltf_ext/document/document.h"
#include "mesh_files/byte_stream.h"
#include "mesh_files/read_asset.h"
#include "tools/gltf_psplit/options/session.h"

namespace psplit {

enum class PointClouds : bool { kRefuse, kRead };

// Reads any file that read_asset supports (mesh_files/read_asset.h); "-" is stdin. Its warnings go to
// the session's log. Large glTF files are mapped, unless `access` says otherwise. The document of a Draco file
// holds the file's stream, which the named backend described; that of a Draco file of points holds the points,
// and is refused with PointClouds::kRefuse. `origin` is for mesh files. If `spool` is a folder, the content of
// a pipe is put into a temporary file there, and is not in memory as a whole.
Expected<Document> read_input(const std::string& path, const Session& session,
                              const std::string& backend = "auto", FileAccess access = FileAccess::kMap,
                              const std::filesystem::path& spool = {}, const Progress& progress = {},
                              PointClouds clouds = PointClouds::kRefuse, const OriginChoice& origin = {});
// Reads the input without writing to the log.
Expected<Asset> read_input_asset(const std::string& path, const Session& session, const std::string& backend,
                                 FileAccess access, const std::filesystem::path& spool,
                                 const Progress& progress, PointClouds clouds, const OriginChoice& origin);
// Logs the asset's warnings, and one if `origin` has no effect on it.
void log_warnings(const Asset& asset, const std::string& path, const OriginChoice& origin, const Log& log);

// The content of an input that can be read only once, such as stdin, in a temporary file in `folder`. Nothing
// if the input is a regular file.
Expected<std::optional<MappedFile>> spool_input(const std::string& path, const std::filesystem::path& folder,
                                                const Progress& progress = {});

}  // namespace psplit
