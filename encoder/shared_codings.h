// Chooses how the attributes of several meshes are stored. Meshes that must fit together share their grids.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "encoder/coding/choose_codings.h"
#include "src/mesh/mesh.h"
#include "src/parallel.h"
#include "src/status.h"

namespace psplit {

struct MeshToCode {
  Mesh* mesh = nullptr;
  size_t group = 0;  // meshes of a group get one grid for each semantic
  // For each point of the mesh 1 if its values will be stored (stored_points). Called when its noise is
  // trimmed.
  std::function<std::vector<uint8_t>()> stored_points{};
};

// The codings of each attribute of each mesh. Values that exceed glTF's limits by rounding noise are set to the
// limits (trim_noise). Call round_weights afterwards.
std::vector<std::vector<AttributeCoding>> choose_shared_codings(std::span<const MeshToCode> meshes,
                                                                const CodingOptions& options,
                                                                const std::set<std::string>& exact,
                                                                const ThreadPool& pool);

// The bits of positions for an error of at most `max_error`, or without it those for the step that the edges
// allow. Errors: those of position_bits.h.
Expected<int> choose_position_bits(const AttributeCoding& coding, std::optional<double> max_error, double step);
// Sets the bits for all meshes of a group together. `mesh` is the number of the mesh of an error.
Status choose_position_bits(std::span<const MeshToCode> meshes, std::optional<double> max_error,
                            std::span<std::vector<AttributeCoding>> codings, size_t& mesh);

}  // namespace psplit
