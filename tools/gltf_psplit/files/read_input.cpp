#include "tools/gltf_psplit/files/read_input.h"

#include <CLI/CLI.hpp>

#include "gltf_ext/mesh_files/read_asset.h"
#include "tools/gltf_psplit/options/backend_choice.h"

namespace psplit {

void add_input_option(CLI::App& command, std::string& path) {
  command
      .add_option(
          "IN", path,
          "The input: a .gltf, .glb, .drc, .ply, .obj, .stl or .off file, optionally gzipped; - reads stdin")
      ->required();
}

Expected<Document> read_input(const std::string& path, const Log& log, const std::string& backend,
                              FileAccess access) {
  Expected<Asset> asset = read_asset(path, find_describer(backend), access);
  if (!asset) return asset.status();
  for (const std::string& warning : asset->warnings) log.warning(path + ": " + warning);
  return std::move(asset->document);
}

}  // namespace psplit
