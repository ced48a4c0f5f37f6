// The models that all condensed streams of a container share, from the container's head. Read-only views, which
// a driver may also point to copies in the memory of a device. src/container/condensed_head.h reads them.
//
// All tables have probabilities in 1 / 4096. A table gives a number below 4096, the slot, to a symbol: the
// first symbol has the first slots, as many as its frequency, and so on.
#pragma once

#include "src/core/view.h"

namespace psplit::core {

inline constexpr uint32_t kSlotBits = 12, kSlots = 1u << kSlotBits;

// The slots of a symbol. One with a frequency of 0 is never used.
struct alignas(8) Share {
  uint32_t frequency = 0, first = 0;
};

// The probabilities of the next of Edgebreaker's symbols, C, S, L, R or E, in one context.
struct alignas(16) SymbolContext {
  static constexpr uint32_t kCount = 5;
  // The code in a context that is never used. It is not a symbol, and add_faces refuses it.
  static constexpr uint32_t kInvalid = 6;

  // By symbol, in this order; core::Clers has the codes.
  Share shares[kCount] = {};
  uint32_t next = 0;  // the next context after symbol s is next + s, except for valence contexts
  uint8_t codes[kCount] = {};
};

inline constexpr uint32_t kTokenCount = 116;

// Two small arrays: the tables that a mesh uses fit the L1 cache.
struct TokenTable {
  uint8_t token_of[kSlots] = {};   // by slot
  Share shares[kTokenCount] = {};  // by token
};
inline constexpr uint16_t kNoTable = 0xffff;  // the number of a table that is never used

// The numbers of the token tables of an attribute's values: three by creation, otherwise two.
struct TableSet {
  static constexpr uint32_t kTables = 3;
  uint16_t tables[kTables] = {kNoTable, kNoTable, kNoTable};
};

// How the integers of an attribute's values are stored.
struct ValueCoding {
  bool by_creation = false;  // in order of creation, with our prediction; otherwise as in the Draco stream
  bool backward = false;     // by creation: from the last decoded face to the first
  bool two = false;          // by creation: up to two parallelograms predict a value, otherwise one
  bool mean = false;         // by creation: a value without parallelogram is predicted from two values
  uint8_t reach = 0;         // by creation: how far parallelograms reach out, 0 to 2
};

// How an attribute is stored.
struct AttributeModel : ValueCoding {
  static constexpr uint32_t kCreaseContexts = 4;

  bool is_delta = false;  // by creation: its values are coded together with other attributes' (deltas.h)
  bool has_flags = false;
  // Each stream chooses one of these sets of token tables, in CondensedModels::table_sets.
  uint16_t first_set = 0, set_count = 1;
  // The probabilities of a 1, if has_flags.
  uint16_t creases[kCreaseContexts] = {}, orientations = 0, flips = 0;
};

// The probabilities of a seam, after an edge without a seam and after one with a seam.
struct SeamModel {
  uint16_t after[2] = {};
};

// An attribute of deltas, such as a morph target's (deltas.h).
struct DeltaModel {
  static constexpr uint16_t kNoReference = 0xffff;

  uint16_t attribute = 0;
  uint16_t reference = kNoReference;  // the number of an earlier one of these, which it resembles
  int16_t factor = 0;                 // times the reference, in 1 / 64
  bool is_even = false;               // all sources have the same weight
  int32_t zero[3] = {};               // the value that stands for a delta of 0
};

// What all deltas share. Levels say how large corrections are around a value.
struct DeltaTables {
  static constexpr uint32_t kLevels = 21;

  uint16_t some = 0;         // the probability that a delta is not 0 where some are 0 around it, and others not
  uint16_t runs = kNoTable;  // the token table of runs
  uint16_t of_level[kLevels] = {};
};

struct CondensedModels {
  bool has_valence_contexts = false;
  bool has_borders = false;  // the first attribute's values at borders are stored once, in border parts
  // Token tables for the first value of a border part, and for the others.
  uint16_t border_tables[2] = {kNoTable, kNoTable};
  uint32_t first_context = 0;  // without valence: the context of the second symbol
  View<const SymbolContext> contexts;
  View<const TokenTable> token_tables;
  View<const TableSet> table_sets;
  View<const AttributeModel> attributes;
  View<const SeamModel> seams;    // by attribute data
  View<const DeltaModel> deltas;  // ascending by attribute
  DeltaTables delta_tables;       // if there are deltas

  // How many of a stream's `attribute_count` attributes are deltas.
  PSPLIT_HD uint32_t delta_count(uint32_t attribute_count) const {
    uint32_t count = 0;
    while (count < deltas.size() && deltas[count].attribute < attribute_count) ++count;
    return count;
  }

  // Calls visit(array) for each of the arrays, which may be replaced by a copy.
  template <typename Visit>
  void for_each_array(Visit visit) {
    visit(contexts);
    visit(token_tables);
    visit(table_sets);
    visit(attributes);
    visit(seams);
    visit(deltas);
  }
};

}  // namespace psplit::core
