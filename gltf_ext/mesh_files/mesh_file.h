// The content of a mesh file of any format, and its conversion to glTF.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "gltf_ext/document/document.h"
#include "gltf_ext/mesh_files/triangulate.h"
#include "src/mesh/mesh.h"

namespace psplit {

// The faces of one material: they become a primitive.
struct MeshFilePart {
  Mesh mesh;
  int64_t material = -1;  // index into MeshFile::materials, or -1
};

// A named object of the file: it becomes a mesh with a node.
struct MeshFileObject {
  std::string name;
  std::vector<MeshFilePart> parts;
};

// The data of a file that is left out or changed, as sentences with counts.
class Losses {
 public:
  // "12 faces of fewer than 3 corners are left out": the text that follows the count, for one and for several.
  void add(const std::string& singular, const std::string& plural, uint64_t count = 1);
  // A sentence without a count. It appears once.
  void say(const std::string& sentence) { add(sentence, "", 0); }
  std::vector<std::string> sentences() const;

 private:
  std::vector<std::string> order_;
  std::map<std::string, std::pair<std::string, uint64_t>> counts_;  // by the singular
};

inline constexpr const char* kTextureTransform = "KHR_texture_transform";

struct MeshFile {
  std::vector<MeshFileObject> objects;
  Json materials = Json::array(), textures = Json::array(), images = Json::array();  // JSON of glTF
  std::set<std::string> bump_maps;  // URIs of textures of normals that may be of heights
  Losses losses;
};

// Converts polygons to faces of a mesh.
class PolygonReader {
 public:
  explicit PolygonReader(Losses& losses) : losses_(losses) {}

  // Appends the triangles of the polygon with the corners `points` at `positions`. A polygon of fewer than 3
  // corners is a loss.
  void add(std::span<const uint32_t> points, std::span<const Position> positions,
           Array<std::array<uint32_t, 3>>& faces);
  // Adds a loss for polygons that cross themselves. Call it after the last add().
  void finish();

 private:
  Losses& losses_;
  Triangulator triangulator_;
};

// The position of a point; `positions` must be a POSITION of floats.
Position position_at(const Attribute& positions, uint32_t point);

// One mesh and one node for each object. The values are moved from `file` into the document one after the
// other. Errors: kUnsupported if there are no faces.
Expected<Document> document_from_mesh_file(MeshFile file);

// The text as UTF-8. Text that is not valid UTF-8 is read as Latin-1.
std::string as_utf8(const std::string& text);

}  // namespace psplit
