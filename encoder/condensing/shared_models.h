// The models that all condensed streams of a primitive share, as write_head writes them, and the statistics
// that they are made from.
#pragma once

#include <array>
#include <bit>

#include "encoder/condensing/coded_patch.h"
#include "encoder/condensing/frequencies.h"
#include "encoder/condensing/section_writer.h"
#include "src/container/bit_string.h"
#include "src/core/condensed/models.h"

namespace psplit {

// The flags of an attribute: creases with 1 to 4 parallelograms, orientations, flips.
inline constexpr uint32_t kFlagKinds = AttributeFields::kCreaseLists + 2;
inline const std::vector<uint8_t>& flags_of_kind(const AttributeFields& fields, uint32_t kind) {
  constexpr uint32_t kOrientations = AttributeFields::kCreaseLists;
  return kind < kOrientations    ? fields.creases[kind]
         : kind == kOrientations ? fields.same_orientations
                                 : fields.flips;
}

inline uint32_t flag_probability(const core::AttributeModel& model, uint32_t kind) {
  constexpr uint32_t kOrientations = AttributeFields::kCreaseLists;
  return kind < kOrientations ? model.creases[kind] : kind == kOrientations ? model.orientations : model.flips;
}

// The frequencies of tokens in the tables of an attribute: two, or three by creation.
using TokenTables = std::vector<std::vector<uint16_t>>;
using TokenCounts = std::array<uint64_t, core::kTokenCount>;
inline TokenCounts& operator+=(TokenCounts& to, const TokenCounts& from) {
  for (uint32_t token = 0; token < core::kTokenCount; ++token) to[token] += from[token];
  return to;
}
using BitCounts = std::array<uint64_t, 2>;
using ClersCounts = std::array<uint64_t, core::SymbolContext::kCount>;

// How often each symbol is coded with each table.
struct AttributeCounts {
  std::array<TokenCounts, 3> tokens{};
  void add(const CodedValues& values, uint32_t components);
  AttributeCounts& operator+=(const AttributeCounts& other);
};
using SymbolCounts = std::vector<ClersCounts>;  // by context
SymbolCounts& operator+=(SymbolCounts& to, const SymbolCounts& from);
void add_symbols(const DracoFields& fields, std::span<const uint16_t> contexts, SymbolCounts& counts);
using FlagCounts = std::array<BitCounts, kFlagKinds>;
using SeamCounts = std::array<BitCounts, 2>;  // after no seam, and after a seam

// How often deltas have each symbol: flags that are bits, runs, and corrections by their level.
struct DeltaCounts {
  BitCounts some{};
  TokenCounts runs{};
  std::array<TokenCounts, core::DeltaTables::kLevels> corrections{};
  void add(const CodedDeltas& deltas);
  DeltaCounts& operator+=(const DeltaCounts& other);
};
struct DeltaTables {
  uint32_t some = 0;  // the probability of a 1
  std::vector<uint16_t> runs;
  // Level l has a table of its own if `begins` has bit l, otherwise the table of the level before.
  uint32_t begins = 1;
  std::vector<std::vector<uint16_t>> corrections;
};

// The bits in which a patch says which of `set_count` sets it uses.
inline uint32_t set_bits(size_t set_count) { return static_cast<uint32_t>(std::bit_width(set_count - 1)); }

// How all streams code the values of one attribute.
struct AttributeTables {
  core::ValueCoding coding;
  std::vector<TokenTables> sets;
  bool has_flags = false;
  std::array<uint32_t, kFlagKinds> flag_probability{};
};

struct SkeletonModel {
  std::vector<uint8_t> literals;
  int symbol_level = 0;
};

struct Models {
  std::vector<SkeletonModel> skeletons;
  uint32_t symbol_contexts = 0;
  std::vector<std::array<uint16_t, core::SymbolContext::kCount>> symbol_tables;
  std::vector<AttributeTables> attributes;
  bool has_borders = false;
  std::array<std::vector<uint16_t>, 2>
      border_tables;  // for the first value of a border part, and for the others
  std::vector<std::array<uint32_t, 2>> seam_probability;  // by attribute data
  std::vector<core::DeltaModel> deltas;
  DeltaTables delta_tables;
};

// Tables that fit counts.
std::vector<std::array<uint16_t, core::SymbolContext::kCount>> symbol_tables(const SymbolCounts& counts);
TokenTables token_tables(const AttributeCounts& counts, core::ValueCoding coding);

// The bits that symbols with these counts take, without their tables.
double symbol_bits(const SymbolCounts& counts,
                   std::span<const std::array<uint16_t, core::SymbolContext::kCount>> tables);
double token_bits(const TokenCounts& counts, std::span<const uint16_t> table);

void write_symbol_tables(std::span<const std::array<uint16_t, core::SymbolContext::kCount>> tables,
                         BitStringWriter& out);
inline core::NumberKind used_kind() { return core::NumberKind(5); }
void write_token_table(std::span<const uint16_t> table, core::NumberKind& used_kind, BitStringWriter& out);
void write_deltas(const Models& models, BitStringWriter& out);
// The head of a container. read_condensed_head reads it.
std::vector<uint8_t> write_head(const Models& models);

}  // namespace psplit
