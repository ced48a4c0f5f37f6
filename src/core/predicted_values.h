// The values of an attribute while they are predicted: their order, their corrections, and the array that they
// are written to.
#pragma once

#include "src/core/traversal.h"
#include "src/core/wrap.h"

namespace psplit::core {

// Value i of the sequence has correction i, and is written to the place of its vertex. kComponents is 0 if
// their number is known only at run time.
template <typename Index, uint32_t kComponents>
class PredictedValues {
 public:
  // A value is computed in one block, or component by component if their number is not known.
  static constexpr uint32_t kBlock = kComponents != 0 ? kComponents : 1;
  using Block = Components<kBlock>;

  CornerTable<Index> table;
  Sequence<Index> sequence;
  View<const int32_t> corrections;
  View<int32_t> values;            // by vertex, value_stride apart
  const int32_t* zeros = nullptr;  // a value of zeros, four at least
  uint32_t component_count = kComponents;

  PSPLIT_HD uint32_t components() const { return kComponents != 0 ? kComponents : component_count; }
  PSPLIT_HD const int32_t* correction(uint32_t i) const { return &corrections[size_t{i} * components()]; }
  PSPLIT_HD int32_t* of_vertex(uint32_t vertex) const {
    return &values[size_t{vertex} * value_stride(components())];
  }
  PSPLIT_HD int32_t* at(uint32_t corner) const { return of_vertex(table.vertex[corner]); }
  PSPLIT_HD uint32_t rank_at(uint32_t corner) const { return sequence.rank[table.vertex[corner]]; }
  // The value before value i.
  PSPLIT_HD const int32_t* before(uint32_t i) const { return i > 0 ? at(sequence.corner[i - 1]) : zeros; }
};

// Values whose corrections were made with the wrap transform.
template <typename Index, uint32_t kComponents>
class WrappedValues : public PredictedValues<Index, kComponents> {
 public:
  using Values = PredictedValues<Index, kComponents>;
  using typename Values::Block;

  WrappedValues() = default;
  PSPLIT_HD WrappedValues(const Values& from, const WrapRange& range) : Values(from), wrap_(range) {}

  // Computes value i. predicted(k) is the block of the predicted value that starts at component k.
  template <typename Predicted>
  PSPLIT_HD void correct(uint32_t i, int32_t* out, Predicted predicted) const {
    const int32_t* by = this->correction(i);
    for (uint32_t k = 0; k < this->components(); k += Values::kBlock)
      wrap_(predicted(k), Block(by + k)).store(out + k);
  }
  // An overload for a predicted value in memory.
  PSPLIT_HD void correct(uint32_t i, const int32_t* predicted) const {
    correct(i, this->at(this->sequence.corner[i]), [=](uint32_t k) { return Block(predicted + k); });
  }

 private:
  Wrap<Values::kBlock> wrap_;
};

// Integer positions, at the corners of an attribute that is predicted from them.
template <typename Index>
struct Positions {
  CornerTable<Index> attribute_table, table;  // the attribute's, and the positions' own
  Sequence<Index> sequence;                   // the attribute's
  View<const int32_t> values;
  bool has_seams = false;  // of the positions

  // If the positions have seams as well, the position is that of the corner at which the attribute's traversal
  // met the value.
  PSPLIT_HD Vec3 at(Index corner) const {
    const Index met = has_seams ? sequence.corner[sequence.rank[attribute_table.vertex[corner]]] : corner;
    const int32_t* value = &values[size_t{table.vertex[met]} * value_stride(3)];
    return {value[0], value[1], value[2]};
  }
};

}  // namespace psplit::core
