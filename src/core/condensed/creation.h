// Values in order of creation: the order in which Edgebreaker brings vertices. Each value is predicted from
// parallelograms of values before it. Specification: "values in order of creation"
// (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include "src/core/attributes.h"
#include "src/core/condensed/models.h"
#include "src/core/in_step.h"

namespace psplit::core {

// Finds the vertices of a table in the order of creation: vertices are as they occur at the corners of faces.
// Forward, faces are in order of decoding. Backward, they are as Edgebreaker's encoder met them. `out` is
// allocated. Only one of the functions is to be called.
template <typename Index>
class CreationOrder {
 public:
  PSPLIT_HD CreationOrder(const CornerTable<Index>& table, const Sequence<Index>& out)
      : table_(table), out_(out) {
    fill(out_.rank, kNone<Index>);
  }
  PSPLIT_HD void see_forward(uint32_t face_count) {
    for (uint32_t face = 0; face < face_count; ++face)
      for (uint32_t corner = 4 * face; corner < 4 * face + 3; ++corner) see(corner);
  }
  PSPLIT_HD void see_backward(uint32_t face_count) {
    for (uint32_t face = face_count; face-- > 0;) {
      see(4 * face + 1);
      see(4 * face + 2);
      see(4 * face);
    }
  }
  // These corners only: all others have vertices that occur before.
  PSPLIT_HD void see(View<const Index> corners) {
    for (size_t i = 0; i < corners.size(); ++i) see(corners[i]);
  }
  PSPLIT_HD Fault finish() const { return count_ == out_.count ? Fault::kNone : Fault::kConnectivity; }

 private:
  // If the vertex at the corner is new, it comes next.
  PSPLIT_HD void see(uint32_t corner) {
    Index& rank = out_.rank[table_.vertex[corner]];
    const uint32_t before = rank, is_new = before == kNone<Index>;
    out_.corner[count_] = static_cast<Index>(corner);
    rank = static_cast<Index>(select(0 - is_new, count_, before));
    count_ += is_new;
  }

  CornerTable<Index> table_;
  Sequence<Index> out_;
  uint32_t count_ = 0;
};

// How an attribute's values are predicted: from one parallelogram, from the mean of two, or from the mean of
// two that do not reach out as far.
enum class CreationMode : uint8_t { kOne, kTwo, kDamped };

// The places of the values that predict one value, as vertices. A value without a parallelogram is predicted
// from one that is three times the same value. One more vertex than there are stands for a value of zeros.
template <typename Index>
struct Predictors {
  Index a, b, far;
  Index value;  // of the predicted value itself
};

// One attribute's values.
template <typename Index>
class CreatedValues {
 public:
  // Finds out what predicts each value. `order` has the vertices of the group's table.
  PSPLIT_HD Fault start(const AttributeModel& model, const Group<Index>& group, const Sequence<Index>& order,
                        Attribute<Index>& attribute, Arena& arena) {
    table_ = group.table.table;
    order_ = order;
    components_ = attribute.value_components();
    mode_ = model.reach > 0           ? CreationMode::kDamped
            : model.two || model.mean ? CreationMode::kTwo
                                      : CreationMode::kOne;
    reach_ = model.reach;
    const uint64_t total = uint64_t{order.count} * components_;
    if (total > 0xffffffffu) return Fault::kCounts;
    const size_t stride = value_stride(components_);
    if (!arena.take(attribute.values, (size_t{order.count} + 1) * stride) ||
        !arena.take(symbols_, static_cast<size_t>(total) + 1) || !arena.take(table_of_, order.count) ||
        !arena.take(predictors_, size_t{order.count} * (mode_ == CreationMode::kOne ? 1 : 2)))
      return Fault::kWorkspace;
    values_ = attribute.values;
    for (size_t k = 0; k < stride; ++k) values_[order.count * stride + k] = 0;
    if (mode_ == CreationMode::kOne)
      find_predictors<false>(model);
    else
      find_predictors<true>(model);
    return Fault::kNone;
  }
  // The memory that `start` takes for `attributes` attributes that have `components` components together.
  PSPLIT_HD static constexpr size_t bytes(uint64_t value_count, uint64_t attributes, uint64_t components) {
    return Arena::bytes<int32_t>((value_count + 1) * (components + attributes)) +
           Arena::bytes<uint32_t>(value_count * components + attributes) +
           attributes * (2 * Arena::bytes<int32_t>(0) + Arena::bytes<uint8_t>(value_count) +
                         Arena::bytes<Predictors<Index>>(2 * value_count));
  }

  // By value: the number of parallelograms that predict it.
  PSPLIT_HD View<const uint8_t> table_of() const { return table_of_; }
  // Bit n: some value is predicted by n of them.
  PSPLIT_HD uint32_t used_tables() const { return used_tables_; }
  PSPLIT_HD View<uint32_t> symbols() const { return symbols_.first(symbols_.size() - 1); }

  PSPLIT_HD CreationMode mode() const { return mode_; }
  PSPLIT_HD uint32_t components() const { return components_; }
  // Whether there are values to predict.
  PSPLIT_HD bool running() const { return at_ < order_.count; }

 protected:
  CornerTable<Index> table_;
  Sequence<Index> order_;
  View<uint32_t> symbols_;
  View<int32_t> values_;
  View<uint8_t> table_of_;
  View<Predictors<Index>> predictors_;
  uint32_t components_ = 0, used_tables_ = 0, at_ = 0, reach_ = 0;
  CreationMode mode_ = CreationMode::kOne;

 private:
  PSPLIT_HD bool is_before(uint32_t vertex, uint32_t i) const { return order_.rank[vertex] < i; }

  // If all vertices of the parallelogram across an edge come before value i, adds it to those of the value.
  PSPLIT_HD PSPLIT_INLINE void add_parallelogram(uint32_t i, Index across, Predictors<Index>* of_value,
                                                 uint32_t& count) const {
    if (across == kNone<Index>) return;
    const Index a = table_.vertex[next(across)], b = table_.vertex[previous(across)],
                far = table_.vertex[across];
    of_value[count] = {a, b, far, of_value[0].value};
    count += static_cast<uint32_t>(order_.rank[a] < i) & static_cast<uint32_t>(order_.rank[b] < i) &
             static_cast<uint32_t>(order_.rank[far] < i);
  }

  template <bool kTwo>
  PSPLIT_HD void find_predictors(const AttributeModel& model) {
    const View<Index> opposite = table_.opposite;
    constexpr uint32_t kStored = kTwo ? 2 : 1;
    for (uint32_t i = 0; i < order_.count; ++i) {
      const Index corner = order_.corner[i];
      Predictors<Index> found[2];
      found[0].value = table_.vertex[corner];
      uint32_t count = 0;
      add_parallelogram(i, opposite[corner], found, count);
      if (kTwo && model.two) {
        // Across the edges of the neighbours on the left and on the right.
        if (const Index left = opposite[next(corner)]; left != kNone<Index>)
          add_parallelogram(i, opposite[next(left)], found, count);
        if (const Index right = opposite[previous(corner)]; count < 2 && right != kNone<Index>)
          add_parallelogram(i, opposite[previous(right)], found, count);
      }
      if (PSPLIT_UNLIKELY(count == 0)) predict_alone(model, i, corner, found);
      table_of_[i] = static_cast<uint8_t>(count);
      used_tables_ |= 1u << count;
      predictors_[kStored * i] = found[0];
      if (kTwo) predictors_[kStored * i + 1] = found[count == 1 ? 0 : 1];
    }
  }

  // Without a parallelogram: from the face's other vertices, or from the value before.
  PSPLIT_HD void predict_alone(const AttributeModel& model, uint32_t i, Index corner,
                               Predictors<Index>* found) const {
    const auto zero = static_cast<Index>(order_.count);
    const Index a = table_.vertex[next(corner)], b = table_.vertex[previous(corner)];
    const bool has_a = is_before(a, i), has_b = is_before(b, i);
    const Index last = i > 0 ? table_.vertex[order_.corner[i - 1]] : zero;
    const Index p = has_a ? a : has_b ? b : last, q = has_a && has_b && model.mean ? b : p;
    found[0] = {p, p, p, found[0].value};
    found[1] = {q, q, q, found[0].value};
  }
};

// Computes one value a step. kComponents is 0 if their number is known only at run time.
template <typename Index, uint32_t kComponents, CreationMode kMode>
class CreationSteps : public CreatedValues<Index> {
 public:
  CreationSteps() = default;
  PSPLIT_HD explicit CreationSteps(const CreatedValues<Index>& values) : CreatedValues<Index>(values) {}

  PSPLIT_HD PSPLIT_INLINE void step() {
    constexpr uint32_t kBlock = kComponents != 0 ? kComponents : 1;
    using Block = Components<kBlock>;
    const uint32_t count = kComponents != 0 ? kComponents : this->components_;
    const size_t stride = value_stride(count);
    const Predictors<Index>* const from =
        this->predictors_.data() + size_t{this->at_} * (kMode == CreationMode::kOne ? 1 : 2);
    const auto* const symbols =
        reinterpret_cast<const int32_t*>(this->symbols_.data()) + size_t{this->at_} * count;
    int32_t* const values = this->values_.data();
    for (uint32_t k = 0; k < count; k += kBlock) {
      const auto predicted = [&](const Predictors<Index>& by) {
        const Block a(values + by.a * stride + k), b(values + by.b * stride + k);
        const Block p = a + b - Block(values + by.far * stride + k);
        if constexpr (kMode != CreationMode::kDamped) return p;
        return p - (p - (a + (b - a).shifted(1))).shifted(this->reach_);
      };
      Block value = predicted(from[0]);
      if constexpr (kMode != CreationMode::kOne) value = value + (predicted(from[1]) - value).shifted(1);
      (value + Block(symbols + k).signed_of_symbols()).store(values + from[0].value * stride + k);
    }
    ++this->at_;
  }
};

// Takes the steps of all runs, at most 16, kRuns of them in turn.
template <uint32_t kRuns, typename Index>
PSPLIT_HD void step_created(CreatedValues<Index>* const* all, uint32_t count) {
  constexpr uint32_t kMost = 16;
  const auto step_those = [&]<uint32_t kComponents, CreationMode kMode>() {
    CreatedValues<Index>* chosen[kMost] = {};
    uint32_t chosen_count = 0;
    for (uint32_t i = 0; i < count && chosen_count < kMost; ++i) {
      const uint32_t components = all[i]->components(),
                     fast = components == 2 || components == 3 ? components : 0;
      if (all[i]->running() && fast == kComponents && all[i]->mode() == kMode) chosen[chosen_count++] = all[i];
    }
    step_all<kRuns, CreationSteps<Index, kComponents, kMode>>(chosen, chosen_count);
  };
  step_those.template operator()<3, CreationMode::kOne>();
  step_those.template operator()<3, CreationMode::kTwo>();
  step_those.template operator()<3, CreationMode::kDamped>();
  step_those.template operator()<2, CreationMode::kOne>();
  step_those.template operator()<2, CreationMode::kTwo>();
  step_those.template operator()<2, CreationMode::kDamped>();
  step_those.template operator()<0, CreationMode::kOne>();
  step_those.template operator()<0, CreationMode::kTwo>();
  step_those.template operator()<0, CreationMode::kDamped>();
}

}  // namespace psplit::core
