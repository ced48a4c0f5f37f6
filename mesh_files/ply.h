// PLY: text, and binary in both byte orders.
#pragma once

#include "mesh_files/mesh_file.h"
#include "mesh_files/ply_header.h"
#include "mesh_files/scanner.h"
#include "psplit/parallel.h"

namespace psplit {

// Reads polygons (an element "face" with a list vertex_indices or vertex_index), triangle strips ("tristrips")
// and these properties of vertices:
//   x y z                              POSITION: floats, and doubles of doubles and 32-bit integers
//   nx ny nz                           NORMAL
//   red green blue [alpha]             COLOR_0: floats, or normalized uchar or ushort; also diffuse_red ... and
//                                      r g b a
//   s t, u v, texture_u texture_v ...  TEXCOORD_0; PLY counts v from the bottom of the image, glTF from the top
// A comment "TextureFile NAME" becomes a material with that texture. A list "texcoord" of a face has two
// numbers for each corner; its points are then split at seams, and a "texnumber" names one of several textures.
// Every other number of a vertex becomes an attribute, for example quality becomes _QUALITY: integers of 8 and
// 16 bits keep their type, all others become floats. Lists of vertices, other properties of faces and other
// elements are left out and count as losses. A file that does not hold what its header claims is an error.
// Errors: kInvalidInput with the line or byte, kUnsupported for point clouds.
Expected<MeshFile> read_ply(Scanner& scanner, const ThreadPool& pool);

// Reads a PLY as a stream: `sink` gets the points and faces, without textures and texture coordinates of faces.
// Call read_ply_header first. The sink's errors are returned as well.
Status read_ply(Scanner& scanner, const PlyHeader& header, MeshSink& sink, Losses& losses,
                const ThreadPool& pool);

}  // namespace psplit
