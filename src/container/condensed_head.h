// The head of a container with condensed streams: what its streams share. Specification: "head"
// (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "src/core/condensed/models.h"
#include "src/status.h"

namespace psplit {

// Sets of token tables: of an attribute, and of all attributes.
inline constexpr uint32_t kMostTableSets = 8, kMostTableSetsOfAll = 256;

// Safe to share between threads.
struct CondensedHead {
  // The literal bytes of the Draco streams. The last byte is not one of them: see the specification.
  std::vector<std::vector<uint8_t>> skeletons;
  std::vector<uint8_t> levels;  // by skeleton: libdraco's level of entropy coding, 0 to 11

  // What models() has views of. The lengths of all vectors are those that the bytes of the head say.
  bool has_valence_contexts = false, has_borders = false;
  std::array<uint16_t, 2> border_tables = {core::kNoTable, core::kNoTable};
  std::vector<core::SymbolContext> contexts;
  std::vector<core::TokenTable> token_tables;
  std::vector<core::TableSet> table_sets;
  std::vector<core::AttributeModel> attributes;
  std::vector<core::SeamModel> seams;

  // Valid as long as the vectors do not change.
  core::CondensedModels models() const;
};

// Reads a head, which is not empty. Any bytes may be given. Takes memory in proportion to the bytes: at most 5
// KiB for each table of theirs. Errors: kInvalidInput, with "head: " before the cause.
Expected<CondensedHead> read_condensed_head(std::span<const uint8_t> bytes);

}  // namespace psplit
