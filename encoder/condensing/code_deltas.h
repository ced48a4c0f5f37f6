// The attributes of deltas of a primitive: which ones they are, how each is coded, and their symbols.
// src/core/condensed/deltas.h decodes them.
#pragma once

#include "encoder/condensing/shared_models.h"
#include "psplit/parallel.h"

namespace psplit {

// The attributes of a stream whose values may be deltas: generic ones of three integers in the table of the
// first attribute, on a grid that has 0. Without references. Ascending by attribute.
std::vector<core::DeltaModel> possible_deltas(const DecodedSource& source, const DracoFields& fields);

// Corrections of deltas and their neighbours at some vertices of the streams. References are chosen by them.
class DeltaSample {
 public:
  // Adds every `every`-th vertex of a stream. has_places: its first attribute is in order of creation.
  void add(const DecodedSource& source, std::span<const core::DeltaModel> deltas, bool has_places,
           uint32_t every);
  void append(DeltaSample&& other);
  // Sets the weights and the reference of each attribute.
  void choose(std::span<core::DeltaModel> deltas, const ThreadPool& pool) const;

 private:
  // At a vertex: what the weights leave of an attribute's delta, by component.
  struct Corrections {
    int32_t affine[core::kDeltaComponents], even[core::kDeltaComponents];
    const int32_t* of(bool is_even) const { return is_even ? even : affine; }
  };
  uint64_t cost_of(size_t delta, bool is_even) const;
  void choose_reference(std::span<core::DeltaModel> deltas, size_t delta) const;

  size_t delta_count_ = 0;
  std::vector<Corrections> corrections_;  // by vertex, then by attribute
  std::vector<uint8_t> is_some_;          // the same: whether the delta is not 0
};

// The symbols of all deltas of `source`. has_places: its first attribute is in order of creation.
CodedDeltas code_deltas(const DecodedSource& source, std::span<const core::DeltaModel> deltas, bool has_places);

// Tables that fit counts: each level has a table, which it shares with the levels beside it.
DeltaTables delta_tables(const DeltaCounts& counts);

// The bits that symbols with these counts take, without their tables.
double delta_bits(const DeltaCounts& counts, const DeltaTables& tables);

}  // namespace psplit
