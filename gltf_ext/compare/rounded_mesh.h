// A mesh whose values were rounded to the grids of another file, as an encoder rounds them.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "gltf_ext/compare/declared_grids.h"
#include "gltf_ext/files/mapped_file.h"
#include "gltf_ext/primitive/mesh_view.h"
#include "src/parallel.h"

namespace psplit {

// psplit rounds the weights of a point together, so that they keep their sum. Other encoders round each alone.
enum class WeightRounding { kTogether, kAlone };

struct RoundedMesh {
  MeshView view;  // points to the values that stay, and to `memory`
  FileMemory memory;
};

// Rounds the attributes that have a grid in `grids`: floats, with as many components as the grid. The results
// are the values that libdraco decodes, bit for bit, and are in a temporary file in `folder`. Before, values
// that exceed glTF's limits by rounding noise are set to the limits (trim_noise). Errors: those of FileMemory.
Expected<RoundedMesh> round_to_grids(const MeshView& mesh, const std::map<std::string, DeclaredGrid>& grids,
                                     WeightRounding weights, const std::filesystem::path& folder,
                                     const ThreadPool& pool);

// The value that a decoder makes of a component's nearest place on a grid that is not one of directions.
float round_to_step(float value, const DeclaredGrid& grid, size_t component);

}  // namespace psplit
