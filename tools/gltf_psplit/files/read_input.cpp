#include "tools/gltf_psplit/files/read_input.h"

#include "gltf_ext/mesh_files/read_asset.h"
#include "tools/gltf_psplit/options/backend_choice.h"

namespace psplit {

Expected<Document> read_input(const std::string& path, const Log& log, const std::string& backend) {
  Expected<Asset> asset = read_asset(path, find_describer(backend));
  if (!asset) return asset.status();
  for (const std::string& warning : asset->warnings) log.warning(path + ": " + warning);
  return std::move(asset->document);
}

}  // namespace psplit
