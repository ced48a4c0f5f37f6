#include "tools/gltf_psplit/files/read_input.h"

#include "gltf_ext/mesh_files/read_asset.h"
#include "tools/gltf_psplit/options/backend_choice.h"

namespace psplit {

Expected<Document> read_input(const std::string& path, const Log& log, const std::string& backend,
                              FileAccess access, const std::filesystem::path& spool, const Progress& progress) {
  Expected<std::optional<MappedFile>> spooled = std::optional<MappedFile>();
  if (!spool.empty()) spooled = spool_input(path, spool, progress);
  if (!spooled) return spooled.status();
  Expected<Asset> asset = *spooled ? read_asset(**spooled, path, find_describer(backend))
                                   : read_asset(path, find_describer(backend), access, progress);
  if (!asset) return asset.status();
  for (const std::string& warning : asset->warnings) log.warning(path + ": " + warning);
  return std::move(asset->document);
}

Expected<std::optional<MappedFile>> spool_input(const std::string& path, const std::filesystem::path& folder,
                                                const Progress& progress) {
  std::error_code error;
  if (path != "-" && std::filesystem::is_regular_file(path, error)) return std::optional<MappedFile>();
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
