// MTL: the materials of OBJ files, as far as glTF has them.
#pragma once

#include <map>
#include <string>

#include "gltf_ext/mesh_files/mesh_file.h"
#include "gltf_ext/mesh_files/scanner.h"

namespace psplit {

// Materials by name, with their textures and images, as glTF's JSON. Indices into `file` are given when a
// material is first used, so that what no face uses is left out.
class MaterialLibrary {
 public:
  // Kd, d, Tr, Ke, Ns, Pr and Pm become base colour, alpha, emission, roughness and metalness; map_Kd, map_Ke
  // and norm become textures, of PNG and JPEG files with relative paths. Everything else is left out; what a
  // viewer would show otherwise, and lines that are broken, are counted in `losses`.
  void read(Scanner& scanner, Losses& losses);

  // The index of a material in file.materials. One that no library has is white, and counted as a loss.
  int64_t use(const std::string& name, MeshFile& file);

 private:
  struct Material {
    Json json = Json::object();                   // as glTF has it, but for textures
    std::map<std::string, std::string> textures;  // by glTF's member: paths as the file has them
  };
  static int64_t texture_of(const std::string& path, MeshFile& file);

  std::map<std::string, Material> materials_;
  std::map<std::string, int64_t> used_;
};

// A path of a file as it stands in an OBJ or MTL file, as glTF's URI; empty where it is not relative.
std::string uri_of_path(const std::string& path);

}  // namespace psplit
