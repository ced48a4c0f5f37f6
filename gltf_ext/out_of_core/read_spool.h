// Reads a mesh file of any size into temporary files.
#pragma once

#include <filesystem>
#include <functional>

#include "gltf_ext/out_of_core/mesh_spool.h"
#include "gltf_ext/out_of_core/temporary_space.h"
#include "mesh_files/asset_format.h"
#include "mesh_files/read_asset.h"
#include "psplit/parallel.h"

namespace psplit {

// Whether read_spool reads the format: PLY, STL and OBJ.
bool can_be_spooled(AssetFormat format);

// Gets what the header of the file states, before the points are read. `is_certain`: the size of the file is
// known and has room for it. Without that, the header of a pipe may state anything. An error ends the reading.
using CheckSizes = std::function<Status(const ExpectedSizes& sizes, bool is_certain)>;

// Reads the file to its end. The document (Document::spooled) has one mesh of one primitive, with the values
// that read_asset gives. Facets of an STL have no common points and no indices, and its solids share the mesh.
// Corners of an OBJ are one point as long as they follow each other soon. Errors: as for the readers,
// MeshSpool, `check` and obj_spool.h; kUnsupported for other formats.
Expected<Asset> read_spool(Scanner& scanner, AssetFormat format, const std::filesystem::path& source,
                           SpoolOptions options, const CheckSizes& check = {},
                           const ThreadPool& pool = ThreadPool(1));

}  // namespace psplit
