// Values in order of creation: the order in which Edgebreaker brings vertices. Each value is predicted from
// parallelograms of values before it. Specification: "values in order of creation"
// (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include "src/core/attributes.h"
#include "src/core/condensed/models.h"
#include "src/core/in_step.h"
#include "src/core/value_chain.h"

namespace psplit::core {

// By vertex, before merged vertices are dropped: its first corner in the order of decoding, or its last.
template <typename Index>
struct VertexCorners {
  View<Index> corner;
  bool are_last = false;
};

// Finds the vertices of a table in the order of creation: vertices are as they occur at the corners of faces.
// Forward, faces are in order of decoding. Backward, they are as Edgebreaker's encoder met them. `out` is
// allocated. Only one of the functions is to be called.
template <typename Index>
class CreationOrder {
 public:
  // The ranks in `out` are set for the first `known_count` vertices of the order, and kNone for all others.
  PSPLIT_HD CreationOrder(const CornerTable<Index>& table, uint32_t known_count, const Sequence<Index>& out)
      : seen_{table.vertex, out.corner, out.rank, known_count} {}

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
  // Does the work of see_forward or see_backward, if no other corner can be the first one of a vertex. `marks`
  // has room for a mark at each corner. Collective.
  template <Lanes L>
  PSPLIT_HD Fault see_first(L lanes, View<const Index> corners) {
    Seen seen = seen_;
    if constexpr (L::size() == 1) {
      for (size_t i = 0; i < corners.size(); ++i) seen.see(corners[i]);
    } else {
      for (uint32_t chunk = 0; chunk < corners.size(); chunk += L::size()) {
        const uint32_t i = chunk + lanes.rank();
        constexpr uint32_t kNoVertex = ~0u;
        const uint32_t vertex = i < corners.size() ? seen.vertex[corners[i]] : kNoVertex;
        uint32_t is_new = vertex != kNoVertex && seen.rank[vertex] == kNone<Index>;
        // A vertex that others were merged into has several corners here. The first one counts.
        for (uint32_t lane = 0; lane + 1 < L::size(); ++lane)
          is_new &= lanes.shuffle(vertex, lane) != vertex || lane >= lanes.rank() ? 1 : 0;
        lanes.sync();
        const Scan<uint32_t> scan = exclusive_scan(lanes, is_new);
        if (is_new != 0) {
          seen.corner[seen.count + scan.before] = corners[i];
          seen.rank[vertex] = static_cast<Index>(seen.count + scan.before);
        }
        seen.count += scan.total;
        lanes.sync();
      }
    }
    return seen.finish();
  }
  template <Lanes L>
  PSPLIT_HD Fault see_last(L lanes, View<const Index> corners, uint32_t face_count, View<uint8_t> marks) {
    const Seen seen = seen_;
    const bool has_known = seen.count > 0;
    fill(lanes, marks, uint8_t{0});
    for_each_lane_item(lanes, static_cast<uint32_t>(corners.size()), [&](uint32_t i) {
      const Index corner = corners[i];
      if (corner != kNone<Index>) marks[corner] = !has_known || seen.rank[seen.vertex[corner]] == kNone<Index>;
    });
    lanes.sync();
    const uint32_t count = list_marked(lanes, face_count, marks);
    lanes.sync();
    for_each_lane_item(lanes, count - seen.count, [&](uint32_t i) {
      seen.rank[seen.vertex[seen.corner[seen.count + i]]] = static_cast<Index>(seen.count + i);
    });
    lanes.sync();
    return count == seen.rank.size() ? Fault::kNone : Fault::kConnectivity;
  }

 private:
  // Appends the marked corners, from the last face to the first. Returns the number of corners in the list.
  template <Lanes L>
  PSPLIT_HD uint32_t list_marked(L lanes, uint32_t face_count, View<const uint8_t> marks) const {
    if constexpr (L::size() > 1) {
      const Seen seen = seen_;
      uint32_t count = seen.count;
      for (uint32_t chunk = 0; chunk < face_count; chunk += L::size()) {
        const uint32_t i = chunk + lanes.rank(), face = face_count - 1 - i;
        const uint32_t marked = i < face_count ? load_le32(&marks[4 * size_t{face}]) : 0;
        const Scan<uint32_t> scan =
            exclusive_scan(lanes, (marked & 1) + (marked >> 8 & 1) + (marked >> 16 & 1));
        uint32_t at = count + scan.before;
        if ((marked >> 8 & 1) != 0) seen.corner[at++] = static_cast<Index>(4 * face + 1);
        if ((marked >> 16 & 1) != 0) seen.corner[at++] = static_cast<Index>(4 * face + 2);
        if ((marked & 1) != 0) seen.corner[at++] = static_cast<Index>(4 * face);
        count += scan.total;
      }
      return count;
    } else {
      return list_marked(face_count, marks);
    }
  }
  PSPLIT_HD uint32_t list_marked(uint32_t face_count, View<const uint8_t> marks) const {
    const Seen seen = seen_;
    uint32_t count = seen.count;
    for (uint32_t face = face_count; face-- > 0;) {
      constexpr uint32_t kAtCorner0 = 0xff;
      const uint32_t marked = load_le32(&marks[4 * size_t{face}]);
      if (PSPLIT_UNLIKELY(marked > kAtCorner0)) {
        seen.corner[count] = static_cast<Index>(4 * face + 1);
        count += marked >> 8 & 1;
        seen.corner[count] = static_cast<Index>(4 * face + 2);
        count += marked >> 16 & 1;
      }
      seen.corner[count] = static_cast<Index>(4 * face);
      count += marked & 1;
    }
    return count;
  }

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

// What one parallelogram predicts.
template <CreationMode kMode, typename Block>
PSPLIT_HD Block predicted_by(const Block& a, const Block& b, const Block& far, uint32_t reach) {
  const Block p = a + b - far;
  if constexpr (kMode != CreationMode::kDamped) return p;
  return p - (p - (a + (b - a).shifted(1))).shifted(reach);
}

// The values that predict one value, as vertices. A value without a parallelogram is predicted from one that is
// three times the same value. One more vertex than there are stands for a value of zeros.
template <typename Index>
class Predictors {
 public:
  Predictors() = default;
  // `value` is the vertex of the predicted value itself.
  PSPLIT_HD Predictors(uint32_t a, uint32_t b, uint32_t far, uint32_t value)
      : edge_(a | static_cast<Word>(b) << kBits), rest_(far | static_cast<Word>(value) << kBits) {}
  PSPLIT_HD Index a() const { return static_cast<Index>(edge_); }
  PSPLIT_HD Index b() const { return static_cast<Index>(edge_ >> kBits); }
  PSPLIT_HD Index far() const { return static_cast<Index>(rest_); }
  PSPLIT_HD Index value() const { return static_cast<Index>(rest_ >> kBits); }

 private:
  static constexpr int kBits = 8 * sizeof(Index);
  using Word = typename TwiceAsWide<Index>::Type;
  Word edge_, rest_;
};

// One attribute's values.
template <typename Index>
class CreatedValues {
 public:
  PSPLIT_HD static CreationMode mode_of(const AttributeModel& model) {
    return model.reach > 0           ? CreationMode::kDamped
           : model.two || model.mean ? CreationMode::kTwo
                                     : CreationMode::kOne;
  }

  // Takes memory, also for the values of the attribute.
  PSPLIT_HD Fault allocate(const AttributeModel& model, const AttributeTable<Index>& table,
                           Attribute<Index>& attribute, Arena& arena) {
    table_ = table.table;
    components_ = attribute.value_components();
    mode_ = mode_of(model);
    reach_ = model.reach;
    const uint32_t count = table.vertex_count;
    const uint64_t total = uint64_t{count} * components_;
    if (total > 0xffffffffu) return Fault::kCounts;
    const size_t stride = value_stride(components_);
    if (!arena.take(attribute.values, (uint64_t{count} + 1) * stride) || !arena.take(symbols_, total + 1) ||
        !arena.take(table_of_, count) ||
        !arena.take(predictors_, uint64_t{count} * (mode_ == CreationMode::kOne ? 1 : 2)))
      return Fault::kWorkspace;
    values_ = attribute.values;
    for (size_t k = 0; k < stride; ++k) values_[count * stride + k] = 0;
    return Fault::kNone;
  }
  // Finds out what predicts each value. `order` has all vertices of the table; the values of the first
  // `known_count` are not stored.
  // Collective.
  template <Lanes L>
  PSPLIT_HD void find_predictors(L lanes, const AttributeModel& model, const Sequence<Index>& order,
                                 uint32_t known_count) {
    if (lanes.rank() == 0) {
      order_ = order.corner.data();
      rank_ = order.rank.data();
      zero_ = order.count;
      known_count_ = known_count;
      count_ = order.count - known_count;
      table_of_ = table_of_.first(count_);
    }
    lanes.sync();
    const Search search{table_.opposite, table_.vertex, {order.corner.data() + known_count, count_},
                        order.rank,      known_count,   mask(model.backward)};
    if (mode_ == CreationMode::kOne)
      find_predictors<false>(lanes, model, search);
    else
      find_predictors<true>(lanes, model, search);
  }
  // Takes the predictors of another attribute, whose model has the same `two` and `mean`. Returns false if they
  // are not for this order, or not as this mode needs them.
  PSPLIT_HD bool share_predictors(const CreatedValues& other, const Sequence<Index>& order) {
    const bool is_one = mode_ == CreationMode::kOne, other_is_one = other.mode_ == CreationMode::kOne;
    if (other.order_ != order.corner.data() || is_one != other_is_one) return false;
    order_ = other.order_;
    rank_ = other.rank_;
    zero_ = other.zero_;
    known_count_ = other.known_count_;
    count_ = other.count_;
    table_of_ = other.table_of_;
    predictors_ = other.predictors_;
    used_tables_ = other.used_tables_;
    return true;
  }
  // The memory that `allocate` takes for `attributes` attributes that have `components` components together,
  // and at most `predictors` predictors a value.
  PSPLIT_HD static constexpr size_t bytes(uint64_t value_count, uint64_t attributes, uint64_t components,
                                          uint32_t predictors) {
    return Arena::bytes<int32_t>((value_count + 1) * (components + attributes)) +
           Arena::bytes<uint32_t>(value_count * components + attributes) +
           attributes * (2 * Arena::bytes<int32_t>(0) + Arena::bytes<uint8_t>(value_count) +
                         Arena::bytes<Predictors<Index>>(predictors * value_count));
  }

  // The number of parallelograms that predict each value.
  PSPLIT_HD View<const uint8_t> table_of() const { return table_of_; }
  // Bit n: some value is predicted by n of them.
  PSPLIT_HD uint32_t used_tables() const { return used_tables_; }
  PSPLIT_HD View<uint32_t> symbols() const { return symbols_.first(size_t{count_} * components_); }
  // One for each value, or two unless the mode is kOne.
  PSPLIT_HD View<const Predictors<Index>> predictors() const { return predictors_; }

  PSPLIT_HD CreationMode mode() const { return mode_; }
  PSPLIT_HD uint32_t components() const { return components_; }
  // Computes all values that have two or three components, as CreationSteps does, by lanes. Collective.
  template <Lanes L>
  PSPLIT_HD void predict(L lanes) {
    const bool is_due = steps_left() > 0 && (components_ == 2 || components_ == 3);
    lanes.sync();
    if (!is_due) return;
    if (components_ == 2)
      predict_components<2>(lanes);
    else
      predict_components<3>(lanes);
    if (lanes.rank() == 0) at_ = count_;
    lanes.sync();
  }
  // The values that are left to predict.
  PSPLIT_HD uint32_t steps_left() const { return count_ - at_; }

 protected:
  CornerTable<Index> table_;
  const Index* order_ = nullptr;  // of the predictors
  const Index* rank_ = nullptr;   // by vertex: its place in the order
  View<uint32_t> symbols_;
  View<int32_t> values_;
  View<uint8_t> table_of_;
  View<Predictors<Index>> predictors_;
  uint32_t components_ = 0, used_tables_ = 0, reach_ = 0;
  uint32_t at_ = 0, count_ = 0;  // of the stored values
  uint32_t zero_ = 0;            // the place of the zeros
  uint32_t known_count_ = 0;
  CreationMode mode_ = CreationMode::kOne;

 private:
  // What the search reads. Copies, which stay in registers.
  struct Search {
    View<const Index> opposite, vertex, corner, rank;
    uint32_t known_count;
    uint32_t flip;  // all ones if the order is backward, otherwise 0

    PSPLIT_HD bool is_before(uint32_t v, uint32_t i) const { return rank[v] < i + known_count; }
    // Whether three vertices come before value i, which occurs at corner `at`: x, y, and the one at `across`,
    // whose face has all three. A face that comes before has only such vertices, and nearly every face that
    // counts does.
    PSPLIT_HD bool is_before(uint32_t x, uint32_t y, Index across, Index at, uint32_t i) const {
      if (across == kNone<Index>) return false;
      if (PSPLIT_LIKELY((across ^ flip) < ((at ^ flip) & ~3u))) return true;
      return is_before(x, i) && is_before(y, i) && is_before(vertex[across], i);
    }
  };

  template <uint32_t kComponents, Lanes L>
  PSPLIT_HD void predict_components(L lanes) const {
    switch (mode_) {
      case CreationMode::kOne: return predict_by<kComponents, CreationMode::kOne>(lanes);
      case CreationMode::kTwo: return predict_by<kComponents, CreationMode::kTwo>(lanes);
      case CreationMode::kDamped: return predict_by<kComponents, CreationMode::kDamped>(lanes);
    }
  }
  template <uint32_t kComponents, CreationMode kMode, Lanes L>
  PSPLIT_HD void predict_by(L lanes) const {
    constexpr uint32_t kValues = ValueLane<kComponents, L>::kValues, kStride = value_stride(kComponents);
    constexpr uint32_t kPredictors = kMode == CreationMode::kOne ? 1 : 2, kSources = 3 * kPredictors;
    const ValueLane<kComponents, L> lane(lanes);
    const Predictors<Index>* const predictors = predictors_.data();
    const uint32_t count = count_, known_count = known_count_, zero = zero_, reach = reach_;
    const Index* const rank = rank_;
    int32_t* const values = values_.data() + lane.component;
    for (uint32_t first = 0; first < count; first += kValues) {
      const uint32_t i = first + lane.value;
      const bool is_busy = lane.is_busy() && i < count;
      int32_t sources[kSources] = {}, correction = 0;
      uint32_t from[kSources], vertex = 0;
      for (uint32_t& each : from) each = kValues;
      if (is_busy) {
        const auto take = [&](uint32_t source, uint32_t v) {
          const uint32_t place = v == zero ? 0 : rank[v];
          if (place >= known_count + first && v != zero)
            from[source] = place - known_count - first;
          else
            sources[source] = values[size_t{v} * kStride];
        };
        for (uint32_t p = 0; p < kPredictors; ++p) {
          const Predictors<Index> by = predictors[size_t{i} * kPredictors + p];
          take(3 * p, by.a()), take(3 * p + 1, by.b()), take(3 * p + 2, by.far());
          if (p == 0) vertex = by.value();
        }
        correction = static_cast<int32_t>(signed_of_symbol(symbols_[size_t{i} * kComponents + lane.component]));
      }
      const int32_t value = chain_values<kComponents>(
          lanes, count - first < kValues ? count - first : kValues, sources, from,
          [&](const int32_t(&at)[kSources]) {
            using Block = Components<1>;
            Block created = predicted_by<kMode>(Block(at[0]), Block(at[1]), Block(at[2]), reach);
            if constexpr (kPredictors == 2)
              created =
                  created +
                  (predicted_by<kMode>(Block(at[3]), Block(at[4]), Block(at[5]), reach) - created).shifted(1);
            return (created + Block(correction))[0];
          });
      if (is_busy) values[size_t{vertex} * kStride] = value;
      lanes.sync();
    }
  }

  template <bool kTwo, Lanes L>
  PSPLIT_HD void find_predictors(L lanes, const AttributeModel& model, const Search& search) {
    const View<const Index> opposite = search.opposite, vertex = search.vertex;
    const View<Predictors<Index>> out = predictors_;
    const View<uint8_t> table_of = table_of_;
    const uint32_t value_count = count_;
    uint32_t used = 0;
    for_each_lane_item(lanes, value_count, [&](uint32_t i) {
      const Index corner = search.corner[i], on_next = next(corner), on_previous = previous(corner);
      const Index a = vertex[on_next], b = vertex[on_previous], value = vertex[corner],
                  across = opposite[corner];
      Predictors<Index>* const stored = &out[(kTwo ? 2 : 1) * size_t{i}];
      uint32_t count = 0;
      if constexpr (kTwo) {
        count = find_two(search, i, corner, model.two, stored);
      } else if (PSPLIT_LIKELY(search.is_before(a, b, across, corner, i))) {
        stored[0] = {a, b, vertex[across], value};
        count = 1;
      }
      if (PSPLIT_UNLIKELY(count == 0)) {
        const bool has_a = search.is_before(a, i), has_b = search.is_before(b, i);
        const uint32_t last = i > 0 ? vertex[search.corner[i - 1]] : zero_;
        const uint32_t p = has_a ? a : has_b ? b : last, q = has_a && has_b && model.mean ? b : p;
        stored[0] = {p, p, p, value};
        if constexpr (kTwo) stored[1] = {q, q, q, value};
      }
      table_of[i] = static_cast<uint8_t>(count);
      used |= 1u << count;
    });
    for (uint32_t step = 1; step < L::size(); step *= 2) used |= lanes.shuffle(used, lanes.rank() ^ step);
    if (lanes.rank() == 0) used_tables_ = used;
    lanes.sync();
  }

  // Finds the parallelograms at the corner of a value, and if `two`, at the neighbouring corners of its vertex
  // on the left and on the right. The first one is across the edge of a and b, the vertices of the next and
  // the previous corner. The one on the left is across the edge of b and a vertex beside it, the one on the
  // right across the edge of a vertex beside a, and a. Stores the first two that count, or one twice.
  //
  // A processor cannot predict which of them count. So this computes all of them, with any corner in place of
  // one that does not exist. A condition holds if its number is negative.
  PSPLIT_HD PSPLIT_INLINE uint32_t find_two(const Search& search, uint32_t i, Index corner, bool two,
                                            Predictors<Index>* stored) const {
    const View<const Index> opposite = search.opposite, vertex = search.vertex;
    const uint32_t none = kNone<Index>, some = static_cast<uint32_t>(vertex.size()) - 2;
    const auto exists = [=](uint32_t at) { return int64_t{at} - none; };
    const auto or_some = [=](uint32_t at) { return at < some ? at : some; };
    const int64_t place = int64_t{i} + search.known_count;
    const auto before = [&](uint32_t v) { return search.rank[v] - place; };

    const uint32_t on_next = next<uint32_t>(corner), on_previous = previous<uint32_t>(corner);
    const uint32_t across = opposite[corner], left = opposite[on_next], right = opposite[on_previous];
    const uint32_t across_left = opposite[next(or_some(left))],
                   across_right = opposite[previous(or_some(right))];
    const uint32_t value = vertex[corner], a = vertex[on_next], b = vertex[on_previous],
                   far = vertex[or_some(across)], beside_b = vertex[or_some(left)],
                   far_left = vertex[or_some(across_left)], beside_a = vertex[or_some(right)],
                   far_right = vertex[or_some(across_right)];
    const Predictors<Index> at[] = {
        {a, b, far, value}, {b, beside_b, far_left, value}, {beside_a, a, far_right, value}};
    const int64_t has_a = before(a), has_b = before(b), neighbours = -int64_t{two};
    const int64_t counts[] = {
        has_a & has_b & exists(across) & before(far),
        has_b & exists(left) & before(beside_b) & exists(across_left) & before(far_left) & neighbours,
        has_a & exists(right) & before(beside_a) & exists(across_right) & before(far_right) & neighbours};
    // For each set of parallelograms that count: their number << 4 | the second of them << 2 | the first.
    constexpr uint64_t kChoices = 0x2429281a24151000u;
    const uint64_t set = static_cast<uint64_t>(counts[0]) >> 63 | static_cast<uint64_t>(counts[1]) >> 63 << 1 |
                         static_cast<uint64_t>(counts[2]) >> 63 << 2;
    const auto choice = static_cast<uint32_t>(kChoices >> 8 * set & 0xff);
    stored[0] = at[choice & 3];
    stored[1] = at[choice >> 2 & 3];
    return choice >> 4;
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
        return predicted_by<kMode>(Block(values + by.a() * stride + k), Block(values + by.b() * stride + k),
                                   Block(values + by.far() * stride + k), this->reach_);
      };
      Block value = predicted(from[0]);
      if constexpr (kMode != CreationMode::kOne) value = value + (predicted(from[1]) - value).shifted(1);
      (value + Block(symbols + k).signed_of_symbols()).store(values + from[0].value() * stride + k);
    }
    ++this->at_;
  }
};

// Takes the steps of all runs, at most 16, kRuns of them in turn.
template <uint32_t kRuns, typename Index>
PSPLIT_HD void step_created(CreatedValues<Index>* const* all, uint32_t count) {
  constexpr uint32_t kMost = 16;
  constexpr bool kHasTwo = !PSPLIT_IS_SMALL_CODE;
  const auto step_those = [&]<uint32_t kComponents, CreationMode kMode>() {
    CreatedValues<Index>* chosen[kMost] = {};
    uint32_t chosen_count = 0;
    for (uint32_t i = 0; i < count && chosen_count < kMost; ++i) {
      const uint32_t components = all[i]->components(),
                     fast = components == 3 || (kHasTwo && components == 2) ? components : 0;
      if (all[i]->steps_left() > 0 && fast == kComponents && all[i]->mode() == kMode)
        chosen[chosen_count++] = all[i];
    }
    step_all<kRareInStep<kRuns>, CreationSteps<Index, kComponents, kMode>>(chosen, chosen_count);
  };
  step_those.template operator()<3, CreationMode::kOne>();
  step_those.template operator()<3, CreationMode::kTwo>();
  step_those.template operator()<3, CreationMode::kDamped>();
  if constexpr (kHasTwo) {
    step_those.template operator()<2, CreationMode::kOne>();
    step_those.template operator()<2, CreationMode::kTwo>();
    step_those.template operator()<2, CreationMode::kDamped>();
  }
  step_those.template operator()<0, CreationMode::kOne>();
  step_those.template operator()<0, CreationMode::kTwo>();
  step_those.template operator()<0, CreationMode::kDamped>();
}

}  // namespace psplit::core
