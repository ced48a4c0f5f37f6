// Wavefront OBJ: polygons with texture coordinates, normals, objects and materials.
#pragma once

#include <functional>
#include <span>

#include "mesh_files/mesh_file.h"
#include "mesh_files/mtl.h"
#include "mesh_files/scanner.h"

namespace psplit {

// Opens the file that a mtllib line names, relative to the OBJ file.
using OpenLibrary = std::function<Expected<std::unique_ptr<ByteStream>>(const std::string& path)>;

// The indices of a corner of a face, counted from 0; UINT32_MAX if it names none.
struct ObjCorner {
  uint32_t position = UINT32_MAX, texcoord = UINT32_MAX, normal = UINT32_MAX;
  bool operator==(const ObjCorner& other) const = default;
};

// What the corners of faces name. A position may have a colour, which has the same index.
enum class ObjValues { kPosition, kColor, kTexcoord, kNormal };

// Takes an OBJ statement by statement. The reader stops at the first error that a call returns.
class ObjSink {
 public:
  virtual ~ObjSink() = default;
  virtual Status add_position(const PrecisePosition& position) = 0;
  virtual Status add_value(ObjValues kind, std::span<const float> value) = 0;  // all others
  // Texture coordinates and normals may follow the faces that name them, and so may positions.
  virtual Status add_face(std::span<const ObjCorner> corners) = 0;
};

// The object of an OBJ without its geometry, and its material in `file`, or -1.
struct ObjHead {
  MeshFile file;
  int64_t material = -1;
};

// Says how many corners name texture coordinates and normals that do not exist.
void say_missing(Losses& losses, uint64_t texcoords, uint64_t normals);

// Reads an OBJ whose faces are all in one object and have one material; others are kUnsupported. read_obj
// describes the rest. All faces name positions that exist.
Expected<ObjHead> read_obj_into(Scanner& scanner, const OpenLibrary& open_library, ObjSink& sink);

// One object for each "o" statement. An object has one part for each material and each set of attributes,
// because faces with normals and faces without normals cannot share a primitive. Corners with equal position,
// texture coordinates and normal are one point; points are in the order of the faces. Vertices that no face
// uses are left out. Six numbers of a "v" are a position and a colour. OBJ counts v from the bottom of the
// image, glTF from the top. A library that cannot be opened is a loss, and so are lines, points, curves and
// surfaces. Errors: kInvalidInput with the line (a word that is not a number, a position that is not finite, a
// vertex that does not exist), kUnsupported (many more objects or materials than the file's bytes justify).
Expected<MeshFile> read_obj(Scanner& scanner, const OpenLibrary& open_library);

}  // namespace psplit
