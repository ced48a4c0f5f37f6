// The content of a mesh file of any format, and its conversion to glTF.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "gltf_ext/document/document.h"
#include "gltf_ext/json/json.h"
#include "mesh_files/origin.h"
#include "mesh_files/triangulate.h"
#include "psplit/base.h"
#include "psplit/mesh.h"

namespace psplit {

// The faces of one material: they become a primitive.
struct MeshFilePart {
  Mesh mesh;
  int64_t material = -1;  // index into MeshFile::materials, or -1
  // The positions of a file that may say more than floats can. POSITION, the first attribute, has no values
  // until settle_positions.
  std::vector<PrecisePosition> positions{};
};

// A named object of the file: it becomes a mesh with a node.
struct MeshFileObject {
  std::string name;
  std::vector<MeshFilePart> parts;
  PrecisePosition origin{};  // the translation of its node
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
  void add(std::span<const uint32_t> points, std::span<const PrecisePosition> positions,
           Array<std::array<uint32_t, 3>>& faces);
  // Adds a loss for polygons that cross themselves. Call it after the last add().
  void finish();

 private:
  Losses& losses_;
  Triangulator triangulator_;
  std::vector<PrecisePosition> rounded_;  // of one polygon
};

// The position of a point; `positions` must be a POSITION of floats.
Position position_at(const Attribute& positions, uint32_t point);
bool is_finite(const Position& position);
PrecisePosition precise(const Position& position);

// Pairs of floats. Mesh files count v from the bottom of the image, glTF from the top.
void flip_v(Array<std::byte>& texcoords);

// The reader stops at the first error that a call returns. Not thread-safe.
class MeshSink {
 public:
  virtual ~MeshSink() = default;

  // Comes first. `layout` has the attributes without values; POSITION is the first, and holds floats.
  // `expected_points` is a number of points that the size of the file justifies memory for. `are_precise`: the
  // positions of points come as doubles.
  virtual Status begin(std::span<const Attribute> layout, size_t expected_points, bool are_precise) = 0;
  // The next `count` points: the attributes of `layout` with the values of these points. `positions` has
  // doubles in the place of POSITION, if begin() said so.
  virtual Status add_points(std::span<const Attribute> block, size_t count,
                            std::span<const PrecisePosition> positions) = 0;
  // A number of faces that the size of the file justifies memory for.
  virtual void expect_faces(size_t count) = 0;
  // Faces of points that were added before.
  virtual Status add_faces(std::span<const std::array<uint32_t, 3>> faces) = 0;
  // The position of a point that was added before.
  virtual Expected<PrecisePosition> position(uint32_t point) = 0;
};

// A mesh in memory.
class MeshBuilder : public MeshSink {
 public:
  Status begin(std::span<const Attribute> layout, size_t expected_points, bool are_precise) override;
  Status add_points(std::span<const Attribute> block, size_t count,
                    std::span<const PrecisePosition> positions) override;
  void expect_faces(size_t count) override { mesh_.faces.reserve(mesh_.faces.size() + count); }
  Status add_faces(std::span<const std::array<uint32_t, 3>> faces) override;
  Expected<PrecisePosition> position(uint32_t point) override;

  MeshFilePart take() { return {std::move(mesh_), -1, std::move(positions_)}; }

 private:
  Mesh mesh_;
  bool are_precise_ = false;
  std::vector<PrecisePosition> positions_;
};

// Whether no object of the file has faces.
bool has_only_points(const MeshFile& file);

// One mesh and one node for each object. The values are moved from `file` into the document one after the
// other. With `takes_points`, a file without any faces becomes primitives of points. Errors: kUnsupported if
// there is nothing to draw.
Expected<Document> document_from_mesh_file(MeshFile file, bool takes_points = false);
// Makes a document without checks: meshes may be empty, for values that are stored elsewhere.
Document document_of_objects(MeshFile file, bool are_points = false);

// The text as UTF-8. Text that is not valid UTF-8 is read as Latin-1.
std::string as_utf8(const std::string& text);

}  // namespace psplit
