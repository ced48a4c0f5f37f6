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
      : seen_{table.vertex, out.corner, out.rank} {
    fill(out.rank, kNone<Index>);
  }
  PSPLIT_HD Fault see_forward(uint32_t face_count) {
    Seen seen = seen_;
    for (uint32_t face = 0; face < face_count; ++face)
      for (uint32_t corner = 4 * face; corner < 4 * face + 3; ++corner) seen.see(corner);
    return seen.finish();
  }
  PSPLIT_HD Fault see_backward(uint32_t face_count) {
    Seen seen = seen_;
    for (uint32_t face = face_count; face-- > 0;) {
      seen.see(4 * face + 1);
      seen.see(4 * face + 2);
      seen.see(4 * face);
    }
    return seen.finish();
  }
  // These corners only: all others have vertices that occur before.
  PSPLIT_HD Fault see(View<const Index> corners) {
    Seen seen = seen_;
    for (size_t i = 0; i < corners.size(); ++i) seen.see(corners[i]);
    return seen.finish();
  }

 private:
  // A copy of it stays in registers.
  struct Seen {
    View<const Index> vertex;
    View<Index> corner, rank;
    uint32_t count = 0;

    // If the vertex at the corner is new, it comes next.
    PSPLIT_HD PSPLIT_INLINE void see(uint32_t at) {
      Index& rank_of_vertex = rank[vertex[at]];
      const uint32_t before = rank_of_vertex, is_new = before == kNone<Index>;
      corner[count] = static_cast<Index>(at);
      rank_of_vertex = static_cast<Index>(select(0 - is_new, count, before));
      count += is_new;
    }
    PSPLIT_HD Fault finish() const { return count == rank.size() ? Fault::kNone : Fault::kConnectivity; }
  };

  Seen seen_;
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
  // Copies of what the search reads, which stay in registers.
  struct Search {
    View<const Index> opposite, vertex, corner, rank;

    PSPLIT_HD bool is_before(uint32_t v, uint32_t i) const { return rank[v] < i; }

    // If all vertices of the parallelogram across an edge come before value i, adds it to those of the value.
    PSPLIT_HD PSPLIT_INLINE void add(uint32_t i, Index across, Predictors<Index>* of_value,
                                     uint32_t& count) const {
      if (across == kNone<Index>) return;
      const Index a = vertex[next(across)], b = vertex[previous(across)], far = vertex[across];
      of_value[count] = {a, b, far, 0};
      // The last of the three.
      const uint32_t rank_a = rank[a], rank_b = rank[b], rank_far = rank[far];
      const uint32_t of_edge = select(mask(rank_a > rank_b), rank_a, rank_b);
      count += static_cast<uint32_t>(select(mask(of_edge > rank_far), of_edge, rank_far) < i);
    }
  };

  template <bool kTwo>
  PSPLIT_HD void find_predictors(const AttributeModel& model) {
    const Search search{table_.opposite, table_.vertex, order_.corner, order_.rank};
    const View<Predictors<Index>> out = predictors_;
    const View<uint8_t> table_of = table_of_;
    constexpr uint32_t kStored = kTwo ? 2 : 1;
    const uint32_t value_count = order_.count;
    const bool two = model.two;
    uint32_t used = 0;
    for (uint32_t i = 0; i < value_count; ++i) {
      const Index corner = search.corner[i];
      Predictors<Index> found[2];
      uint32_t count = 0;
      search.add(i, search.opposite[corner], found, count);
      if (kTwo && two) {
        // Across the edges of the neighbours on the left and on the right.
        const Index left = search.opposite[next(corner)], right = search.opposite[previous(corner)];
        if (left != kNone<Index>) search.add(i, search.opposite[next(left)], found, count);
        if (count < 2 && right != kNone<Index>) search.add(i, search.opposite[previous(right)], found, count);
      }
      if (PSPLIT_UNLIKELY(count == 0)) predict_alone(search, model, i, found);
      table_of[i] = static_cast<uint8_t>(count);
      used |= 1u << count;
      found[0].value = search.vertex[corner];
      out[kStored * i] = found[0];
      if constexpr (kTwo) out[kStored * i + 1] = found[count == 1 ? 0 : 1];
    }
    used_tables_ = used;
  }

  // Without a parallelogram: from the face's other vertices, or from the value before.
  PSPLIT_HD void predict_alone(const Search& search, const AttributeModel& model, uint32_t i,
                               Predictors<Index>* found) const {
    const Index corner = search.corner[i];
    const Index a = search.vertex[next(corner)], b = search.vertex[previous(corner)];
    const bool has_a = search.is_before(a, i), has_b = search.is_before(b, i);
    const Index last = i > 0 ? search.vertex[search.corner[i - 1]] : static_cast<Index>(order_.count);
    const Index p = has_a ? a : has_b ? b : last, q = has_a && has_b && model.mean ? b : p;
    found[0] = {p, p, p, 0};
    found[1] = {q, q, q, 0};
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
