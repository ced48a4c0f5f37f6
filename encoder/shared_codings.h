// Chooses how the attributes of several meshes are stored. Meshes that must fit together share their grids.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "encoder/coding/choose_codings.h"
#include "encoder/coding/precision_guard.h"
#include "psplit/base.h"
#include "psplit/encode.h"
#include "psplit/mesh.h"
#include "psplit/parallel.h"

namespace psplit {

// Whether the meshes of a group share the attribute's grid, because borders between them must stay closed.
bool is_shared(const std::string& semantic);

// Flags for the points of a mesh: 1 if its values are stored. Empty if all are.
using StoredFlags = std::vector<uint8_t>;

// How the attributes of meshes that share grids are coded. Arrays have an element for each mesh.
struct SharedCodings {
  std::vector<std::vector<AttributeCoding>> codings;  // of each attribute
  std::vector<StoredFlags> stored;
};

// The codings of each attribute of each mesh, and which points they are chosen for. Values that exceed glTF's
// limits by rounding noise are set to the limits (trim_noise). Call round_weights afterwards.
SharedCodings choose_shared_codings(std::span<MeshToEncode* const> meshes, const EncodeOptions& options,
                                    const ThreadPool& pool, std::span<const KeptMesh> kept = {});

// The bits of positions for an error of at most `max_error`, or without it those for the step that the edges
// allow. Errors: as for position_bits.h.
Expected<int> choose_position_bits(const AttributeCoding& coding, std::optional<double> max_error, double step);
// Sets the bits for all meshes of a group together. After an error, `mesh` is the number of the mesh.
Status choose_position_bits(std::span<MeshToEncode* const> meshes, std::optional<double> max_error,
                            std::span<std::vector<AttributeCoding>> codings, size_t& mesh);

// Replaces codings that lose what the meshes tell apart (precision_guard.h), unless their bits are given or the
// attribute has a coding of its own (MeshToEncode::own_codings). A grid that a group shares stays one. Returns
// notes for each mesh. Call it when the bits are chosen.
std::vector<std::vector<PrecisionNote>> guard_precision(std::span<MeshToEncode* const> meshes,
                                                        const EncodeOptions& options, SharedCodings& chosen,
                                                        const ThreadPool& pool);

// The points of a planned mesh whose values encode() stores.
StoredFlags stored_points(const MeshToEncode& mesh, const EncodeOptions& options, const ThreadPool& pool);

}  // namespace psplit
