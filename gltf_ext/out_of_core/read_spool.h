// Reads a mesh file of any size into temporary files.
#pragma once

#include <functional>
#include <memory>

#include "gltf_ext/mesh_files/asset_format.h"
#include "gltf_ext/mesh_files/obj.h"
#include "gltf_ext/out_of_core/mesh_spool.h"
#include "gltf_ext/out_of_core/temporary_space.h"

namespace psplit {

// Whether read_spool reads the format: PLY, STL and OBJ.
bool can_be_spooled(AssetFormat format);

// Gets what the header of the file states, before the points are read. `is_certain`: the size of the file is
// known and has room for it. Without that, the header of a pipe may state anything. An error ends the reading.
using CheckSizes = std::function<Status(const ExpectedSizes& sizes, bool is_certain)>;

// Where the materials of an OBJ come from, and what it has besides the geometry.
struct ObjSource {
  OpenLibrary open_library;
  ObjHead head{};
};

// Reads the file to its end. `losses` must outlive the result. Only OBJ needs `obj`. Errors: those of the
// readers, of MeshSpool, of `check` and of obj_spool.h; kUnsupported for other formats.
Expected<std::unique_ptr<MeshSpool>> read_spool(Scanner& scanner, AssetFormat format, SpoolOptions options,
                                                Losses& losses, const CheckSizes& check = {},
                                                ObjSource* obj = nullptr);

}  // namespace psplit
