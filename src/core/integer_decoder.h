// The integers of one attribute: its symbols, which become corrections, and its prediction, which turns
// corrections into values.
#pragma once

#include "src/core/attributes.h"
#include "src/core/prediction.h"
#include "src/core/symbols.h"

namespace psplit::core {

template <typename Index>
class IntegerDecoder {
 public:
  // Whether parallelograms of four components have steps, as those of two and three: a device and small code
  // have fewer loops.
  static constexpr bool kStepsFour = !PSPLIT_MOVES_ROWS && !PSPLIT_IS_SMALL_CODE;

  // Reads up to the entropy-coded symbols, which `symbols` will decode. Of the group's sequence only the length
  // must be known yet. `positions` and `position` are the group and the attribute of the positions to predict
  // from, or null.
  PSPLIT_HD Fault start(ByteReader& reader, bool is_edgebreaker, const Group<Index>& group,
                        Attribute<Index>& attribute, const Group<Index>* positions,
                        const Attribute<Index>* position, Arena& arena, SymbolSequence& symbols) {
    Fault fault = describe(reader, is_edgebreaker, group, attribute, positions, position);
    if (fault == Fault::kNone) fault = allocate(arena);
    if (fault != Fault::kNone) return fault;
    if (reader.u8() == 0) return read_plain(reader, this->symbols());
    const size_t mark = arena.mark();
    fault = symbols.start(reader, group.sequence.count, attribute.value_components(), arena, this->symbols());
    if (!kValuesReplaceTables || fault != Fault::kNone) return fault;
    // No value is written before all symbols are decoded.
    const size_t end = arena.mark();
    arena.release(mark);
    const bool is_reserved = reserve_values(arena);
    arena.retake(end);
    return is_reserved ? Fault::kNone : Fault::kWorkspace;
  }

  // The parts of `start`, for condensed streams. describe reads the scheme. allocate takes the memory of
  // symbols().
  PSPLIT_HD Fault describe(ByteReader& reader, bool is_edgebreaker, const Group<Index>& group,
                           Attribute<Index>& attribute, const Group<Index>* positions,
                           const Attribute<Index>* position) {
    group_ = &group;
    attribute_ = &attribute;
    positions_ = positions;
    position_ = position;
    return read_scheme(reader, is_edgebreaker);
  }
  PSPLIT_HD Fault allocate(Arena& arena) {
    const uint32_t components = attribute_->value_components();
    const uint64_t total = uint64_t{group_->sequence.count} * components;
    if (total > 0xffffffffu) return Fault::kCounts;
    // One correction more, because a vector register loads four numbers for a value of three components.
    return arena.take_for_good(corrections_, total + 1) ? Fault::kNone : Fault::kWorkspace;
  }
  // Takes the memory of the values, unless `start` did. To be called when the corrections are known.
  PSPLIT_HD bool take_values(Arena& arena) {
    if (zeros_.empty() && !reserve_values(arena)) return false;
    fill(zeros_, 0);
    return true;
  }
  // Symbols turn into corrections in place.
  PSPLIT_HD View<uint32_t> symbols() const {
    return View<uint32_t>(reinterpret_cast<uint32_t*>(corrections_.data()), corrections_.size() - 1);
  }
  PSPLIT_HD uint32_t value_count() const { return group_->sequence.count; }
  // The stored fields besides symbols. A condensed stream sets them itself.
  PSPLIT_HD PredictionData& data() { return data_; }

  // The memory that `start`, read_prediction and take_values take for `attributes` attributes that have
  // `components` components together. `table_bytes` is that of all symbols' tables. value_stride adds at most
  // one place to each attribute.
  PSPLIT_HD static constexpr size_t bytes(uint64_t value_count, uint64_t attributes, uint64_t components,
                                          size_t table_bytes) {
    const size_t values = Arena::bytes<int32_t>(value_count * (components + attributes)) +
                          Arena::bytes<int32_t>(components + zero_count(0) * attributes) +
                          2 * attributes * Arena::bytes<int32_t>(0);
    // With several attributes, one may have large tables and another one many values.
    const bool is_shared = kValuesReplaceTables && attributes == 1;
    const size_t smaller = is_shared ? (values < table_bytes ? values : table_bytes) : 0;
    return Arena::bytes<int32_t>(value_count * components + attributes) + values + table_bytes - smaller +
           attributes * (Arena::bytes<int32_t>(0) + PredictionData::bytes(value_count));
  }
  // Continues reading after the symbols. PredictionData::read describes `corner_limit`.
  PSPLIT_HD Fault read_prediction(ByteReader& reader, uint32_t corner_limit, Arena& arena) {
    return reader.truncated() ? Fault::kTruncated : data_.read(reader, corner_limit, arena);
  }

  // Makes the steps of the most frequent predictions ready, when symbols and sequence are known. At most one of
  // their kinds is running. Any number of steps may be taken before finish. A warp computes parallelograms,
  // means of them, and normals from positions, at once instead. Collective. `is_condensed`: corrections of
  // octahedral transforms are signed as well. `knows_positions`: the positions to predict from are computed.
  template <Lanes L>
  PSPLIT_HD void start_prediction(L lanes, bool is_condensed, bool knows_positions) {
    data_.take_crease_steps(lanes);
    if constexpr (L::size() > 1) {
      if (predict_by_lanes(lanes)) {
        if (lanes.rank() == 0) is_predicted_ = true;
        return lanes.sync();
      }
    }
    const bool is_signed = data_.scheme == Scheme::kNone || data_.transform == Transform::kWrap || is_condensed;
    for_each_lane_item(lanes, is_signed ? static_cast<uint32_t>(corrections_.size()) - 1 : 0, [&](uint32_t i) {
      corrections_[i] = static_cast<int32_t>(signed_of_symbol(static_cast<uint32_t>(corrections_[i])));
    });
    bool is_broken = false;
    if (has_normal_steps())
      for_each_lane_item(lanes, static_cast<uint32_t>(corrections_.size()) - 1,
                         [&](uint32_t i) { is_broken |= !is_in_range(data_.grid, corrections_[i]); });
    const bool is_chained = !any(lanes, is_broken);
    if (lanes.rank() == 0) start_steps(is_chained);
    lanes.sync();
    if constexpr (L::size() > 1) {
      const Scheme scheme = data_.scheme;
      const bool is_predicted = knows_positions && predict_normals(lanes);
      const bool is_independent = scheme == Scheme::kNone || scheme == Scheme::kDifference ||
                                  (scheme == Scheme::kTexCoords && knows_positions);
      if (lanes.rank() == 0) is_predicted_ = is_predicted, is_independent_ = is_independent;
      lanes.sync();
    }
  }
  // Takes the steps, or computes all values if that needs neither memory nor values that may not be there yet.
  // Not collective: each attribute may have a thread of its own.
  PSPLIT_HD void take_prediction() {
    if (attribute_ == nullptr || is_predicted_ || is_finished_) return;
    if (has_steps()) {
      step_through(parallelograms_3d_);
      step_through(parallelograms_2d_);
      if constexpr (kStepsFour) step_through(parallelograms_4d_);
      return step_through(normals_);
    }
    if (!is_independent_) return;
    Arena none;
    ParallelogramFinder<Index> no_parallelograms;
    early_fault_ = predict_components(no_parallelograms, none);
    is_finished_ = true;
  }
  // Whether start_prediction has computed the values.
  PSPLIT_HD bool is_predicted() const { return is_predicted_; }
  PSPLIT_HD ParallelogramSteps<Index, 3>& parallelograms_3d() { return parallelograms_3d_; }
  PSPLIT_HD ParallelogramSteps<Index, 2>& parallelograms_2d() { return parallelograms_2d_; }
  // Only if kStepsFour.
  PSPLIT_HD ParallelogramSteps<Index, 4>& parallelograms_4d() { return parallelograms_4d_; }
  PSPLIT_HD NormalSteps<Index>& normals() { return normals_; }

  // `parallelograms` come from the previous attribute, or are empty, and are the last that was taken from the
  // arena since `mark`. Memory is released to there, unless these or new parallelograms are in it.
  PSPLIT_HD Fault finish(ParallelogramFinder<Index>& parallelograms, Arena& arena, size_t mark) {
    if (has_steps() || is_predicted_ || is_finished_) return early_fault_;
    if (data_.scheme != Scheme::kConstrainedMultiParallelogram ||
        !parallelograms.are_of(group_->table.table, group_->sequence)) {
      parallelograms = {};
      arena.release(mark);
    }
    return predict_components(parallelograms, arena);
  }
  // The memory that `finish` takes. It is not released.
  PSPLIT_HD static constexpr size_t finish_bytes(uint64_t value_count) {
    return ParallelogramFinder<Index>::bytes(value_count);
  }

 private:
  // Values of streams with 16-bit numbers take the memory of the tables of their symbols, because a device
  // decodes thousands of such streams at once. With 32-bit numbers, values take the memory of traversals, which
  // is larger.
  static constexpr bool kValuesReplaceTables = sizeof(Index) == 2;

  PSPLIT_HD static constexpr uint32_t zero_count(uint32_t components) {
    return components < 4 ? 4 : components;
  }

  PSPLIT_HD bool reserve_values(Arena& arena) {
    const uint32_t components = attribute_->value_components();
    return arena.take_for_good(attribute_->values,
                               uint64_t{group_->table.vertex_count} * value_stride(components)) &&
           arena.take_for_good(zeros_, zero_count(components));
  }

  // Broken streams mean what they mean to libdraco: a transform of other attributes says that values are not
  // predicted, and a scheme that does not exist that each is predicted from the one before.
  PSPLIT_HD Fault read_scheme(ByteReader& reader, bool is_edgebreaker) {
    const auto scheme = static_cast<int8_t>(reader.u8());
    data_.scheme = static_cast<Scheme>(scheme);
    if (data_.scheme == Scheme::kNone) return Fault::kNone;
    constexpr int8_t kDeprecated = 3, kMost = 6, kNoTransform = -1;
    const auto transform = static_cast<int8_t>(reader.u8());
    data_.transform = static_cast<Transform>(transform);
    if (data_.transform > Transform::kOctahedronCanonicalized || transform < kNoTransform)
      return Fault::kMethod;
    const bool is_wrap = attribute_->coding != Coding::kNormal;
    if (is_wrap ? data_.transform != Transform::kWrap : data_.transform <= Transform::kWrap) {
      data_.scheme = Scheme::kNone;
      return Fault::kNone;
    }
    // Without a corner table a value can only be predicted from the one before. On an octahedron, schemes for
    // positions or texture coordinates make no sense.
    if (!is_edgebreaker || (!is_wrap && data_.scheme != Scheme::kGeometricNormal) || scheme < 0 ||
        scheme > kMost)
      data_.scheme = Scheme::kDifference;
    if (static_cast<int8_t>(data_.scheme) == kDeprecated) return Fault::kMethod;
    if (data_.scheme == Scheme::kGeometricNormal && is_wrap) return Fault::kPrediction;
    if (data_.scheme == Scheme::kTexCoords || data_.scheme == Scheme::kGeometricNormal)
      if (position_ == nullptr || position_->coding == Coding::kRaw || position_->value_components() != 3)
        return Fault::kPrediction;
    return Fault::kNone;
  }

  // Reads symbols that are not entropy-coded. A byte before them is the number of bytes of each.
  PSPLIT_HD static Fault read_plain(ByteReader& reader, View<uint32_t> out) {
    const uint32_t bytes = reader.u8();
    if (bytes > 4) return Fault::kEntropy;
    const uint8_t* in = reader.head();
    if (!reader.skip(uint64_t{out.size()} * bytes)) return Fault::kTruncated;
    for (size_t i = 0; i < out.size(); ++i) {
      out[i] = 0;
      for (uint32_t k = 0; k < bytes; ++k) out[i] |= static_cast<uint32_t>(*in++) << (8 * k);
    }
    return Fault::kNone;
  }

  template <uint32_t kComponents>
  PSPLIT_HD PredictedValues<Index, kComponents> values() const {
    return {group_->table.table, group_->sequence, corrections_,
            attribute_->values,  zeros_.data(),    attribute_->value_components()};
  }

  PSPLIT_HD Positions<Index> positions() const {
    return {group_->table.table, positions_->table.table, group_->sequence, position_->values,
            positions_->table.has_seams};
  }

  PSPLIT_HD bool has_parallelograms() const {
    const uint32_t components = attribute_->value_components();
    return data_.scheme == Scheme::kParallelogram && components >= 2 && components <= (kStepsFour ? 4 : 3);
  }
  PSPLIT_HD bool has_normal_steps() const {
    return data_.scheme == Scheme::kDifference && attribute_->coding == Coding::kNormal;
  }
  PSPLIT_HD bool has_steps() const { return has_parallelograms() || has_normal_steps(); }
  // Returns false, and leaves the corrections as they are, if lanes do not compute this prediction, or if its
  // data has a fault.
  template <Lanes L>
  PSPLIT_HD bool predict_by_lanes(L lanes) {
    const uint32_t components = attribute_->value_components();
    if (has_parallelograms() && components < 4) {
      if (components == 3)
        predict_by_parallelogram(lanes, values<3>(), data_.wrap);
      else
        predict_by_parallelogram(lanes, values<2>(), data_.wrap);
      return true;
    }
    return data_.scheme == Scheme::kConstrainedMultiParallelogram && components == 3 &&
           predict_by_constrained_multi_parallelogram(lanes, values<3>(), data_.wrap, data_.creases);
  }
  // Predicts normals from positions. Their corrections are already signed if necessary.
  template <Lanes L>
  PSPLIT_HD bool predict_normals(L lanes) {
    if (data_.scheme != Scheme::kGeometricNormal || attribute_->value_components() != 2) return false;
    predict_from_geometry(lanes, values<2>(), positions(), {}, data_);
    return true;
  }
  template <typename Run>
  PSPLIT_HD static void step_through(Run& run) {
    Run* const one = &run;
    step_all<1, Run>(&one, 1);
  }
  PSPLIT_HD void start_steps(bool is_chained) {
    if (!has_steps()) return;
    const bool canonicalized = data_.transform == Transform::kOctahedronCanonicalized;
    if (attribute_->coding == Coding::kNormal && !is_chained)
      is_finished_ = true, correct_normals_by_difference(values<2>(), data_.grid, canonicalized);
    else if (attribute_->coding == Coding::kNormal)
      normals_ = {values<2>(), data_.grid, canonicalized};
    else if (attribute_->value_components() == 3)
      parallelograms_3d_ = ParallelogramSteps<Index, 3>({values<3>(), data_.wrap});
    else if (attribute_->value_components() == 2)
      parallelograms_2d_ = ParallelogramSteps<Index, 2>({values<2>(), data_.wrap});
    else if constexpr (kStepsFour)
      parallelograms_4d_ = ParallelogramSteps<Index, 4>({values<4>(), data_.wrap});
  }

  PSPLIT_HD Fault predict_components(ParallelogramFinder<Index>& parallelograms, Arena& arena) {
    const uint32_t components = attribute_->value_components();
    if (data_.scheme == Scheme::kTexCoords || data_.scheme == Scheme::kGeometricNormal) {
      if (components != 2) return Fault::kPrediction;
      return predict_from_positions(values<2>(), positions(), data_, arena);
    }
    if (components == 3) return predict(values<3>(), data_, parallelograms, arena);
    if constexpr (!PSPLIT_IS_SMALL_CODE) {
      if (components == 1) return predict(values<1>(), data_, parallelograms, arena);
      if (components == 2) return predict(values<2>(), data_, parallelograms, arena);
      if (components == 4) return predict(values<4>(), data_, parallelograms, arena);
    }
    return predict(values<0>(), data_, parallelograms, arena);
  }

  const Group<Index>* group_ = nullptr;
  Attribute<Index>* attribute_ = nullptr;
  const Group<Index>* positions_ = nullptr;
  const Attribute<Index>* position_ = nullptr;
  PredictionData data_;
  View<int32_t> corrections_, zeros_;
  bool is_predicted_ = false;  // by start_prediction
  bool is_independent_ = false, is_finished_ = false;
  Fault early_fault_ = Fault::kNone;  // of take_prediction
  ParallelogramSteps<Index, 3> parallelograms_3d_;
  ParallelogramSteps<Index, 2> parallelograms_2d_;
  [[no_unique_address]]
  typename MemberIf<!PSPLIT_IS_SMALL_CODE, ParallelogramSteps<Index, 4>>::Type parallelograms_4d_;
  NormalSteps<Index> normals_;
};

}  // namespace psplit::core
