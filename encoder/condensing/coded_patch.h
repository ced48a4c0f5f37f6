// What a condensed patch codes, before it is written, and writing it.
#pragma once

#include <algorithm>
#include <array>

#include "encoder/condensing/border_symbols.h"
#include "encoder/condensing/source_stream.h"
#include "src/container/condensed_head.h"

namespace psplit {

// The symbol of a correction, modulo 2^32.
uint32_t folded_difference(int32_t value, int32_t predicted);

// The symbols of one attribute, component after component of each value.
struct CodedValues {
  std::vector<uint32_t> symbols;
  std::vector<uint8_t> table;  // of each value
  uint8_t set = 0;             // of token tables
};

// The number of contexts of Edgebreaker's symbols, by how the head says it: up to kMostHistory symbols before,
// or kValenceContexts.
uint32_t context_count(uint32_t symbol_contexts);

inline bool has_seams(const std::vector<uint8_t>& seams) { return std::ranges::find(seams, 1) != seams.end(); }

// The contexts of all symbols except the first. Empty if the symbols do not form a mesh.
std::vector<uint16_t> contexts_of_symbols(const DracoFields& fields, uint32_t symbol_contexts);

// Draco's corrections, or the raw values, of an attribute in Draco's order.
CodedValues code_in_draco_order(const AttributeFields& fields);
inline constexpr uint8_t kReaches = 3;

// The symbols of one attribute in the order of creation, under every choice of means and of reach.
class CreationSymbols {
 public:
  // `known` are vertices whose values are not coded.
  CreationSymbols(const DecodedSource& source, uint32_t attribute, bool backward, bool two,
                  std::span<const uint32_t> known);

  // The values that are coded.
  uint32_t count() const { return static_cast<uint32_t>(created_.table_of().size()); }
  // The number of parallelograms that predict value i.
  uint32_t parallelograms(uint32_t i) const { return created_.table_of()[i]; }
  // The symbol of a component of value i.
  uint32_t symbol(uint32_t i, uint32_t component, bool mean, uint32_t reach) const;

 private:
  std::unique_ptr<uint8_t[]> memory_;
  core::Attribute<uint32_t> attribute_;  // by vertex
  core::CreatedValues<uint32_t> created_;
};

// The values of an attribute in the order of creation.
CodedValues code_by_creation(const DecodedSource& source, uint32_t attribute, core::ValueCoding coding,
                             std::span<const uint32_t> known);

// The symbols of all attributes of deltas (src/core/condensed/deltas.h).
struct CodedDeltas {
  // A flag that is a bit is 0 or 1. A run of sure flags is kRun more than its length.
  static constexpr uint32_t kRun = 2;
  struct Correction {
    uint32_t symbol;
    uint8_t level;
  };
  std::vector<uint8_t> is_row;  // by attribute of deltas: whether it is not 0 everywhere
  std::vector<uint32_t> flags;
  std::array<std::vector<Correction>, core::kDeltaComponents> corrections;

  bool has_rows() const { return !flags.empty(); }
};

// A patch whose values and symbols are coded. Of its fields it needs everything except the attributes' symbols
// and raw bytes.
struct CodedPatch {
  DracoFields fields;
  uint32_t point_count = 0;
  std::vector<uint16_t> contexts;       // of all symbols except the first
  std::vector<CodedValues> attributes;  // in the order of the stream; empty for attributes of deltas
  CodedDeltas deltas;
  BorderPart border;
};

// Writes the patch: the fields that are not in its skeleton, under the models of the head. Specification: "a
// condensed patch". `head` equals the head that a decoder reads from write_head(models).
std::vector<uint8_t> write_patch(const CodedPatch& patch, const CondensedHead& head);

}  // namespace psplit
