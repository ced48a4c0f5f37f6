// MTL: the materials of OBJ files, as far as glTF can express them.
#pragma once

#include <map>
#include <string>

#include "gltf_ext/mesh_files/mesh_file.h"
#include "gltf_ext/mesh_files/scanner.h"

namespace psplit {

// Materials by name, with their textures and images, as JSON of glTF. A material gets its index in `file` when
// it is first used, so that materials without faces are left out.
class MaterialLibrary {
 public:
  // Kd, d, Tr, Ke, Ns, Pr and Pm become base colour, alpha, emission, roughness and metalness; map_Kd, map_Ke
  // and norm become textures, if they are PNG or JPEG files with relative paths. Everything else is left out.
  // Properties that a viewer would show, and broken lines, are counted in `losses`.
  void read(Scanner& scanner, Losses& losses);

  // The index of a material in file.materials. A material that is in no library is white, and counts as a loss.
  int64_t use(const std::string& name, MeshFile& file);

 private:
  struct Material {
    Json json = Json::object();                   // JSON of glTF, without textures
    std::map<std::string, std::string> textures;  // paths as the file states them, by the member of glTF
  };
  static int64_t texture_of(const std::string& path, MeshFile& file);

  std::map<std::string, Material> materials_;
  std::map<std::string, int64_t> used_;
};

// The URI of a path that an OBJ or MTL file names; empty if the path is not relative.
std::string uri_of_path(const std::string& path);

}  // namespace psplit
