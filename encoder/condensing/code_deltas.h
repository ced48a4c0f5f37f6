// The attributes of deltas of a primitive: which ones they are, how each is coded, and their symbols.
// src/core/condensed/deltas.h decodes them.
#pragma once

#include <array>

#include "encoder/condensing/shared_models.h"
#include "psplit/parallel.h"

namespace psplit {

// The attributes of a stream whose values may be deltas: generic ones of three integers in the table of the
// first attribute, on a grid that has 0. They have no references yet, and ascend by attribute.
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
  uint64_t cost_of(size_t delta, bool is_even) const;
  void choose_reference(std::span<core::DeltaModel> deltas, size_t delta) const;

  // Calls use(corrections) for each component at each vertex where the delta is not 0: what the weights leave
  // of the attributes' deltas there, by attribute.
  template <typename Use>
  void for_each_correction(size_t delta, bool is_even, Use use) const {
    for (size_t at = 0; at < is_some_.size(); at += delta_count_)
      for (uint32_t k = 0; k < core::kDeltaComponents && is_some_[at + delta] != 0; ++k)
        use(&corrections_[is_even][k][at]);
  }

  size_t delta_count_ = 0;
  // By whether the weights are even, by component, by vertex, then by attribute.
  std::array<std::array<std::vector<int32_t>, core::kDeltaComponents>, 2> corrections_;
  std::vector<uint8_t> is_some_;  // by vertex, then by attribute: whether the delta is not 0
};

// The symbols of all deltas of `source`. has_places: its first attribute is in order of creation.
CodedDeltas code_deltas(const DecodedSource& source, std::span<const core::DeltaModel> deltas, bool has_places);

// Tables that fit counts: each level has a table, which it shares with the levels beside it.
DeltaTables delta_tables(const DeltaCounts& counts);

// The bits that symbols with these counts take, without their tables.
double delta_bits(const DeltaCounts& counts, const DeltaTables& tables);

}  // namespace psplit
