// Writes PLY, OBJ and STL. Each function streams: it holds blocks of points or faces, not a mesh.
#pragma once

#include <filesystem>
#include <set>

#include "mesh_files/asset_format.h"
#include "mesh_files/placed_part.h"
#include "system/files.h"

namespace psplit {

// The names of attributes that the format (PLY, OBJ or STL) cannot hold, or cannot hold because only some parts
// have them.
std::set<std::string> attributes_left_out(AssetFormat format, std::span<const PlacedPart> parts);

// kUnsupported for positions that are not three finite numbers: the readers refuse these, as glTF does.
Status check_positions(std::span<const PlacedPart> parts);

// Writes the parts without those attributes. read_asset reads floats back to the same bits, except v of texture
// coordinates, which these formats count from the bottom of the image: it is the float nearest to 1 - v in PLY,
// and 1 - v in double precision in OBJ.
//   PLY  one mesh, binary and little-endian: positions, normals and texture coordinates as floats, colours as
//        they are stored if all parts store them so, and otherwise as floats; an attribute _NAME of one number
//        as the property "name"
//   (positions are doubles in PLY, and have their digits in OBJ, where need_doubles)
//   OBJ  objects, and the materials of the MTL file `library`; colours as floats after the positions
//   STL  one solid, binary; a facet's normal is computed from its corners
// The file appears whole or not at all. Errors: kIo; kUnsupported for positions that are not three finite
// numbers, and for more points or faces than the format can count.
Status write_mesh_file(const std::filesystem::path& path, AssetFormat format, std::span<const PlacedPart> parts,
                       const std::string& library = {}, IfReadOnly if_read_only = IfReadOnly::kFail);

// The header of a binary PLY file with triangles, or of points. `properties` has the lines of a vertex's
// properties. A face is a uchar 3 and three indices of 32 bits.
std::string ply_header_text(uint64_t point_count, const std::string& properties, uint64_t face_count);

}  // namespace psplit
