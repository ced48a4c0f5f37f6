// MTL: the materials of OBJ files, as far as glTF can express them.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "gltf_ext/json/json.h"
#include "mesh_files/mesh_file.h"
#include "mesh_files/scanner.h"

namespace psplit {

// Materials by name, with their textures and images, as JSON of glTF. A material gets its index in `file` when
// it is first used, so that materials without faces are left out.
class MaterialLibrary {
 public:
  // Kd, d, Tr, Ke, Ns, Pr and Pm become base colour, alpha, emission, roughness and metalness; map_Kd, map_Ke,
  // norm and map_Bump become textures, if they are PNG or JPEG files with relative paths. -o and -s become
  // KHR_texture_transform, -bm of normals their scale. Everything else is left out. Properties that a viewer
  // would show, and broken lines, are counted in `losses`.
  void read(Scanner& scanner, Losses& losses);

  // The index of a material in file.materials. A material that is in no library is white, and counts as a loss.
  int64_t use(const std::string& name, MeshFile& file);

 private:
  struct Texture {
    std::string path;             // as the file states it
    Json info{};                  // the members of its textureInfo beside the index
    bool may_be_heights = false;  // its statement is that of a bump map
  };
  struct Material {
    Json json = Json::object();               // JSON of glTF, without textures
    std::map<std::string, Texture> textures;  // by the member of glTF
  };
  static std::optional<Texture> read_texture(Scanner& scanner, Losses& losses);

  std::map<std::string, Material> materials_;
  std::map<std::string, int64_t> used_;
};

// The index of the texture of an image, which is added to the file if it is new.
int64_t add_texture(const std::string& path, MeshFile& file);
// Whether glTF can refer to the image: a PNG or a JPEG file with a relative path. If not, that is a loss.
bool can_be_texture(const std::string& path, Losses& losses);

// The URI of a path that an OBJ or MTL file names; empty if the path is not relative.
std::string uri_of_path(const std::string& path);

// The path of an image of the document as the MTL file names it; empty if it has no file.
using PathOfImage = std::function<std::string(size_t image)>;

// The lines of one material: base colour, alpha, emission, roughness, metalness, and textures of these and of
// normals, with offset and scale. What MTL cannot hold is added to `left_out`, by its name in glTF.
std::string mtl_text(const Json& json, int64_t material, const std::string& name,
                     const PathOfImage& path_of_image, std::set<std::string>& left_out);

}  // namespace psplit
