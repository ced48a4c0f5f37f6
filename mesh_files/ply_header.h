// The header of a PLY file: its elements and their properties.
#pragma once

#include <string>
#include <vector>

#include "mesh_files/scanner.h"

namespace psplit {

enum class PlyEncoding { kText, kLittleEndian, kBigEndian };
enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

size_t ply_type_bytes(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;  // of a list: the type of its values
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  // of a list
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kText;
  std::vector<PlyElement> elements;
  std::vector<std::string> textures;  // the files that comments "TextureFile" name
};

// A line that begins with "Created" is a comment too: exporters of Blender 2.4 wrote it without the keyword.
// Reads from "ply" to the end of the line of "end_header". Errors: kInvalidInput with the line.
Expected<PlyHeader> read_ply_header(Scanner& scanner);

}  // namespace psplit
