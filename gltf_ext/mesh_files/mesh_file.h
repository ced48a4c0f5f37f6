// What a mesh file of any format holds, and the glTF that it becomes.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "gltf_ext/document/document.h"
#include "gltf_ext/mesh_files/triangulate.h"
#include "src/mesh/mesh.h"

namespace psplit {

// The faces of one material: a primitive.
struct MeshFilePart {
  Mesh mesh;
  int64_t material = -1;  // of MeshFile::materials, or none
};

// A named object of the file: a mesh with a node of its own.
struct MeshFileObject {
  std::string name;
  std::vector<MeshFilePart> parts;
};

// What was left out of a file or changed, counted by its words.
class Losses {
 public:
  // "12 faces of fewer than 3 corners are left out": `noun` follows the count, in the singular and the plural.
  void add(const std::string& singular, const std::string& plural, uint64_t count = 1);
  // A sentence of its own, said once.
  void say(const std::string& sentence) { add(sentence, "", 0); }
  std::vector<std::string> sentences() const;

 private:
  std::vector<std::string> order_;
  std::map<std::string, std::pair<std::string, uint64_t>> counts_;  // by the singular
};

struct MeshFile {
  std::vector<MeshFileObject> objects;
  Json materials = Json::array(), textures = Json::array(), images = Json::array();  // as glTF has them
  Losses losses;
};

// Polygons to faces of a mesh.
class PolygonReader {
 public:
  explicit PolygonReader(Losses& losses) : losses_(losses) {}

  // Appends the triangles of a polygon whose corners are `points`, at `positions`. Fewer than 3 corners are a
  // loss.
  void add(std::span<const uint32_t> points, std::span<const Position> positions,
           Array<std::array<uint32_t, 3>>& faces);
  // Counts polygons that cross themselves as losses.
  void finish();

 private:
  Losses& losses_;
  Triangulator triangulator_;
};

// The position of a point; `positions` are the values of a POSITION of floats.
Position position_at(const Attribute& positions, uint32_t point);

// Makes of the values of every part what glTF wants of them, and counts what that changes: normals become unit
// vectors, those of no length are made from the faces around (NORMAL goes where all are so), colours are
// clamped to [0, 1], and numbers that are not finite become 0. Positions are finite already.
void repair_values(MeshFile& file);

// One mesh and one node an object. Takes the values away from `file` as they go into the document. Errors:
// kUnsupported where there are no faces.
Expected<Document> document_from_mesh_file(MeshFile file);

// Text as UTF-8: what is not is read as Latin-1.
std::string as_utf8(const std::string& text);

}  // namespace psplit
