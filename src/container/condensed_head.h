// The head of a container: what its streams have in common, in sections with a type and a length. Condensed
// streams have tables in it. Specification: "head" (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "psplit/base.h"
#include "src/core/condensed/models.h"

namespace psplit {

// The sections of a head ascend by type. A reader skips unknown types from kMayBeSkipped on, and must know all
// others.
enum class HeadSection : uint8_t { kTables = 1, kBorders = 2, kDeltas = 3, kMayBeSkipped = 128, kBoxes = 128 };
void append_head_section(HeadSection type, std::span<const uint8_t> bytes, std::vector<uint8_t>& head);
// The content of a section of a head that read_condensed_head accepts; empty if there is none.
std::span<const uint8_t> find_head_section(HeadSection type, std::span<const uint8_t> head);

inline constexpr uint32_t kMostSkeletons = 255, kMostSkeletonBytes = 4096;
// Sets of token tables: of an attribute, and of all attributes.
inline constexpr uint32_t kMostTableSets = 8, kMostTableSetsOfAll = 256;

// The token tables that levels of deltas choose from.
inline constexpr uint32_t kMostDeltaTables = 8;

// How contexts of symbols are stored: the number of symbols before, at most kMostHistory, or kValenceContexts.
inline constexpr uint32_t kMostHistory = 5, kValenceContexts = 8;

// All skeletons begin with these bytes, which the head does not have: DRACO, bitstream 2.2, a mesh,
// Edgebreaker.
inline constexpr std::array<uint8_t, 9> kSkeletonFront = {'D', 'R', 'A', 'C', 'O', 2, 2, 1, 1};

// Safe to share between threads.
struct CondensedHead {
  // The literal bytes of the Draco streams. The last byte is not one of them: see the specification. Empty if
  // the head has no tables.
  std::vector<std::vector<uint8_t>> skeletons;
  std::vector<uint8_t> levels;  // by skeleton: libdraco's level of entropy coding, 0 to 11

  // models() returns views of these. The bytes of the head state the lengths of all vectors.
  bool has_valence_contexts = false, has_borders = false;
  std::array<uint16_t, 2> border_tables = {core::kNoTable, core::kNoTable};
  std::vector<core::SymbolContext> contexts;
  std::vector<core::TokenTable> token_tables;
  std::vector<core::TableSet> table_sets;
  std::vector<core::AttributeModel> attributes;
  std::vector<core::SeamModel> seams;
  std::vector<core::DeltaModel> deltas;
  core::DeltaTables delta_tables;

  // Valid as long as the vectors do not change.
  core::CondensedModels models() const;
};

// Any bytes may be given; none are an empty head. Takes memory in proportion to the bytes: at most 5 KiB for
// each table of theirs. Errors: kInvalidInput, and kUnsupported for a section that it must know and does not,
// with "head: " before the cause.
Expected<CondensedHead> read_condensed_head(std::span<const uint8_t> bytes);

}  // namespace psplit
