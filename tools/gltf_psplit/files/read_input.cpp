#include "tools/gltf_psplit/files/read_input.h"

#include "psplit/decode.h"
#include "system/operating_system.h"
#include "tools/gltf_psplit/options/backend_choice.h"

namespace psplit {
namespace {

Expected<Mesh> decode_draco_points(std::span<const uint8_t> stream, StreamDescription& description) {
  return decode_draco(stream, &description);
}

}  // namespace

Expected<Document> read_input(const std::string& path, const Session& session, const std::string& backend,
                              FileAccess access, const std::filesystem::path& spool, const Progress& progress,
                              PointClouds clouds, const OriginChoice& origin) {
  Expected<Asset> asset = read_input_asset(path, session, backend, access, spool, progress, clouds, origin);
  if (!asset) return asset.status();
  log_warnings(*asset, path, origin, session.log);
  return std::move(asset->document);
}

void log_warnings(const Asset& asset, const std::string& path, const OriginChoice& origin, const Log& log) {
  for (const std::string& warning : asset.warnings) log.warning(path + ": " + warning);
  if (origin.by != OriginChoice::By::kNeed && !asset.is_mesh_file)
    log.warning(path + ": --origin is for PLY, OBJ, STL and OFF, and has no effect here");
}

Expected<Asset> read_input_asset(const std::string& path, const Session& session, const std::string& backend,
                                 FileAccess access, const std::filesystem::path& spool,
                                 const Progress& progress, PointClouds clouds, const OriginChoice& origin) {
  Expected<std::optional<MappedFile>> spooled = std::optional<MappedFile>();
  if (!spool.empty()) spooled = spool_input(path, spool, progress);
  if (!spooled) return spooled.status();
  const DecodePoints decode_points = clouds == PointClouds::kRead ? decode_draco_points : DecodePoints();
  return *spooled
             ? read_asset(**spooled, path, find_describer(backend), decode_points, session.pool, origin)
             : read_asset(path, find_describer(backend), access, progress, decode_points, session.pool, origin);
}

Expected<std::optional<MappedFile>> spool_input(const std::string& path, const std::filesystem::path& folder,
                                                const Progress& progress) {
  if (path != "-" && is_disk_file(path)) return std::optional<MappedFile>();
  const Place place{.file = path == "-" ? "stdin" : path};
  Expected<std::unique_ptr<ByteStream>> stream = open_byte_stream(path, progress);
  if (!stream) return stream.status().at(place);
  Expected<Scanner> scanner = open_scanner(std::move(*stream));
  if (!scanner) return scanner.status().at(place);
  Expected<SpooledBytes> spooled = spool_bytes(*scanner, folder);
  if (!spooled) return spooled.status().at(place);
  return std::optional(std::move(spooled->bytes));
}

}  // namespace psplit
