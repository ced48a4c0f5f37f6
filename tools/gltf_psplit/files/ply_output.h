// A generated mesh as a binary PLY file, written piece by piece.
#pragma once

#include <string>

#include "gltf_ext/files/files.h"
#include "src/parallel.h"
#include "src/status.h"
#include "tools/gltf_psplit/report/progress.h"
#include "tools/gltf_psplit/shapes/shapes.h"

namespace psplit {

// Writes little-endian PLY: x y z and, if the shape has normals, nx ny nz as floats; faces as a uchar 3 and
// three ints. The file appears whole or not at all (gltf_ext/files/files.h). It must be a regular file, because
// points and faces are written to two places alternately. `progress` counts faces. Errors: those of write_file.
Status write_ply(const std::string& path, const ShapeStream& shape, bool normals, const ThreadPool& pool,
                 const Progress& progress, IfReadOnly if_read_only);

}  // namespace psplit
