// PLY: text, and binary of both byte orders.
#pragma once

#include "gltf_ext/mesh_files/mesh_file.h"
#include "gltf_ext/mesh_files/scanner.h"

namespace psplit {

// Polygons (an element "face" with a list vertex_indices or vertex_index) and triangle strips ("tristrips"). Of
// vertices:
//   x y z                              POSITION, as floats
//   nx ny nz                           NORMAL
//   red green blue [alpha]             COLOR_0: floats, or normalized uchar or ushort; diffuse_red ... and r g
//   b a, too s t, u v, texture_u texture_v ...  TEXCOORD_0; PLY counts v from the bottom of the image, glTF
//   from the top
// Every other number of a vertex becomes an attribute of its own, quality for example _QUALITY: 8 and 16 bits
// as they are, all else as floats. Lists of vertices, other properties of faces and other elements are left
// out, which the losses say. A file holds what its header claims, or it is refused. Errors: kInvalidInput with
// the line or byte, kUnsupported for point clouds.
Expected<MeshFile> read_ply(Scanner& scanner);

}  // namespace psplit
