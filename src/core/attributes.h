// Attributes: how they are described, and their integers. Draco bitstream specification 2.2, "attribute
// decoders".
#pragma once

#include "src/core/data_type.h"
#include "src/core/prediction.h"

namespace psplit::core {

PSPLIT_HD constexpr uint32_t data_type_bytes(DataType type) {
  constexpr uint8_t kBytes[] = {0, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8, 1};
  return kBytes[static_cast<uint8_t>(type)];
}

enum class Coding : uint8_t { kRaw = 0, kInteger = 1, kQuantized = 2, kNormal = 3 };

inline constexpr uint32_t kMaxAttributes = 256;

template <typename Index>
struct Attribute {
  static constexpr uint8_t kPosition = 0;

  uint8_t semantic = 0;  // Draco's attribute type
  DataType type = DataType::kFloat32;
  uint8_t components = 0;
  bool normalized = false;
  uint32_t unique_id = 0;
  Coding coding = Coding::kRaw;
  uint8_t group = 0;  // the attributes that share a table and a sequence

  // Integers by vertex of the group's table, value_stride apart, two each for kNormal. Not for kRaw, whose
  // bytes lie in the stream in the order of the group's sequence.
  View<int32_t> values;
  const uint8_t* raw = nullptr;
  // kQuantized and kNormal: bits; kQuantized: a float of origin for each component in the stream, and the
  // range.
  uint8_t bits = 0;
  const uint8_t* origin = nullptr;
  float range = 0;

  PSPLIT_HD uint32_t value_components() const { return coding == Coding::kNormal ? 2 : components; }
  PSPLIT_HD uint32_t stride() const { return data_type_bytes(type) * components; }
  // From one place on the grid to the next, of kQuantized.
  PSPLIT_HD float step() const { return range / static_cast<float>((1u << bits) - 1); }
};

template <typename Index>
struct Group {
  int8_t attribute_data = -1;  // which seams; -1 for those without
  bool per_corner = false;     // uses the table of its own attribute data
  bool by_prediction_degree = false;
  uint32_t first = 0, count = 0;  // of the patch's attributes
  AttributeTable<Index> table;
  Sequence<Index> sequence;
};

// Reads what describes a group's attributes, and appends them.
template <typename Index>
PSPLIT_HD Fault read_descriptions(ByteReader& reader, uint8_t group_number, Group<Index>& group,
                                  View<Attribute<Index>> attributes, uint32_t& attribute_count) {
  group.first = attribute_count;
  group.count = reader.varint();
  if (reader.truncated()) return Fault::kTruncated;
  if (group.count == 0 || group.count > attributes.size() - attribute_count) return Fault::kAttribute;
  attribute_count += group.count;
  for (uint32_t i = 0; i < group.count; ++i) {
    Attribute<Index>& attribute = attributes[group.first + i];
    attribute = {};
    attribute.semantic = reader.u8();
    const uint8_t type = reader.u8();
    attribute.components = reader.u8();
    attribute.normalized = reader.u8() != 0;
    attribute.unique_id = reader.varint();
    attribute.group = group_number;
    constexpr uint8_t kSemanticCount = 5;
    if (attribute.semantic >= kSemanticCount || type == 0 || type > static_cast<uint8_t>(DataType::kBool) ||
        attribute.components == 0)
      return reader.truncated() ? Fault::kTruncated : Fault::kAttribute;
    attribute.type = static_cast<DataType>(type);
  }
  for (uint32_t i = 0; i < group.count; ++i) {
    Attribute<Index>& attribute = attributes[group.first + i];
    const uint8_t coding = reader.u8();
    if (coding > static_cast<uint8_t>(Coding::kNormal)) return Fault::kAttribute;
    attribute.coding = static_cast<Coding>(coding);
    const bool is_float = attribute.type == DataType::kFloat32;
    if ((attribute.coding == Coding::kQuantized && !is_float) ||
        (attribute.coding == Coding::kNormal && (!is_float || attribute.components != 3)) ||
        (attribute.coding == Coding::kInteger && attribute.type > DataType::kUint32))
      return Fault::kAttribute;
  }
  return reader.truncated() ? Fault::kTruncated : Fault::kNone;
}

// Undoes the prediction, for a number of components known at compile time, or not (0).
template <typename Index, uint32_t kComponents>
PSPLIT_HD Fault predict(const Group<Index>& group, Attribute<Index>& attribute, const Group<Index>* positions,
                        const Attribute<Index>* position, View<const int32_t> corrections, Arena& arena,
                        PredictionData& data) {
  Predictor<Index, kComponents> predictor(group.table, group.sequence, attribute.value_components(),
                                          corrections, attribute.values, data);
  // Where positions have seams as well, the vertex is the one at which the attribute's walk met the value.
  const auto position_at = [&](Index corner) -> Vec3 {
    const Index at = positions->table.has_seams
                         ? group.sequence.corner[group.sequence.rank[group.table.table.vertex[corner]]]
                         : corner;
    const int32_t* value = &position->values[size_t{positions->table.table.vertex[at]} * value_stride(3)];
    return {value[0], value[1], value[2]};
  };
  switch (data.scheme) {
    case Scheme::kNone: predictor.none(); return Fault::kNone;
    case Scheme::kDifference: predictor.difference(); return Fault::kNone;
    case Scheme::kParallelogram: predictor.parallelogram(); return Fault::kNone;
    case Scheme::kMultiParallelogram: predictor.multi_parallelogram(); return Fault::kNone;
    case Scheme::kConstrainedMultiParallelogram: return predictor.constrained_multi_parallelogram(arena);
    case Scheme::kTexCoords:
      if constexpr (kComponents == 2) return predictor.tex_coords(position_at);
      return Fault::kPrediction;
    case Scheme::kGeometricNormal:
      if constexpr (kComponents == 2) return predictor.geometric_normal(position_at), Fault::kNone;
      return Fault::kPrediction;
  }
  return Fault::kPrediction;
}

// The integers of an attribute: read what stands before the symbols, the symbols, what stands behind them; then
// undo the prediction.
template <typename Index>
class IntegerDecoder {
 public:
  // Of the group's sequence only its length need be known yet. `positions` and `position` are those to predict
  // from, or null. `symbols` are to be decoded before read_prediction.
  PSPLIT_HD Fault start(ByteReader& reader, bool is_edgebreaker, const Group<Index>& group,
                        Attribute<Index>& attribute, const Group<Index>* positions,
                        const Attribute<Index>* position, Arena& arena, SymbolSequence& symbols) {
    group_ = &group;
    attribute_ = &attribute;
    positions_ = positions;
    position_ = position;
    const auto scheme = static_cast<int8_t>(reader.u8());
    data_.scheme = static_cast<Scheme>(scheme);
    if (scheme < -2 || scheme > 6 || scheme == -1 || scheme == 3) return Fault::kMethod;
    if (data_.scheme != Scheme::kNone) {
      const auto transform = static_cast<int8_t>(reader.u8());
      const bool is_wrap = transform == static_cast<int8_t>(Transform::kWrap);
      if (transform < 1 || transform > 3 || is_wrap != (attribute.coding != Coding::kNormal))
        return Fault::kMethod;
      data_.transform = static_cast<Transform>(transform);
      // Without a corner table there is only the last value to predict from; nor do schemes for positions or
      // texture coordinates mean anything on an octahedron.
      if (!is_edgebreaker || (!is_wrap && data_.scheme != Scheme::kGeometricNormal))
        data_.scheme = Scheme::kDifference;
      if (data_.scheme == Scheme::kGeometricNormal && is_wrap) return Fault::kPrediction;
      if (data_.scheme == Scheme::kTexCoords || data_.scheme == Scheme::kGeometricNormal)
        if (position == nullptr || position->coding == Coding::kRaw || position->value_components() != 3)
          return Fault::kPrediction;
    }

    const uint32_t components = attribute.value_components(), count = group.sequence.count;
    const uint64_t total = uint64_t{count} * components;
    if (total > 0xffffffffu) return Fault::kCounts;
    // One correction more than there are: four may be read where there are three.
    if (!arena.take(attribute.values, size_t{group.table.vertex_count} * value_stride(components)) ||
        !arena.take(corrections_, static_cast<size_t>(total) + 1) || !arena.take(zeros_, 4))
      return Fault::kWorkspace;
    fill(zeros_, 0);
    // Symbols come first, and turn into corrections in place.
    const View<uint32_t> out(reinterpret_cast<uint32_t*>(corrections_.data()), static_cast<size_t>(total));
    if (reader.u8() != 0) return symbols.start(reader, count, components, arena, out);
    const uint32_t bytes = reader.u8();
    if (bytes > 4) return Fault::kEntropy;
    const uint8_t* in = reader.head();
    if (!reader.skip(total * bytes)) return Fault::kTruncated;
    for (uint32_t i = 0; i < total; ++i) {
      out[i] = 0;
      for (uint32_t k = 0; k < bytes; ++k) out[i] |= static_cast<uint32_t>(*in++) << (8 * k);
    }
    return Fault::kNone;
  }

  // `corner_limit`: see read_prediction_data.
  PSPLIT_HD Fault read_prediction(ByteReader& reader, uint32_t corner_limit, Arena& arena) {
    return reader.truncated() ? Fault::kTruncated : read_prediction_data(reader, corner_limit, arena, data_);
  }

  // The symbols and the sequence are known: the commonest predictions in steps, of which one may be running.
  // Any number of them may be taken before finish. Collective.
  template <Lanes L>
  PSPLIT_HD void start_prediction(L lanes) {
    const bool is_signed = data_.scheme == Scheme::kNone || data_.transform == Transform::kWrap;
    for_each_lane_item(lanes, is_signed ? static_cast<uint32_t>(corrections_.size()) - 1 : 0, [&](uint32_t i) {
      corrections_[i] = static_cast<int32_t>(signed_of_symbol(static_cast<uint32_t>(corrections_[i])));
    });
    if (lanes.rank() == 0) start_steps();
    lanes.sync();
  }
  PSPLIT_HD ParallelogramSteps<Index, 3>& of_three() { return of_three_; }
  PSPLIT_HD ParallelogramSteps<Index, 2>& of_two() { return of_two_; }
  PSPLIT_HD NormalSteps<Index>& normals() { return normals_; }

  PSPLIT_HD Fault finish(Arena& arena) {
    const size_t mark = arena.mark();
    const Fault fault = in_steps() ? Fault::kNone : predict_components(arena);
    arena.release(mark);
    return fault;
  }

 private:
  PSPLIT_HD void start_steps() {
    const PredictedValues<Index> on{group_->table.table, group_->sequence, corrections_, attribute_->values,
                                    zeros_.data()};
    const Wrap wrap{data_.low, data_.high, data_.modulus};
    const uint32_t components = attribute_->value_components();
    if (data_.scheme == Scheme::kParallelogram && components == 3) of_three_ = {on, wrap};
    if (data_.scheme == Scheme::kParallelogram && components == 2) of_two_ = {on, wrap};
    if (data_.scheme == Scheme::kDifference && attribute_->coding == Coding::kNormal)
      normals_ = {on, data_.grid, data_.transform == Transform::kOctahedronCanonicalized};
  }

  // Whether steps are all that there is to do.
  PSPLIT_HD bool in_steps() const {
    const uint32_t components = attribute_->value_components();
    return (data_.scheme == Scheme::kParallelogram && (components == 2 || components == 3)) ||
           (data_.scheme == Scheme::kDifference && attribute_->coding == Coding::kNormal);
  }

  PSPLIT_HD Fault predict_components(Arena& arena) {
    switch (attribute_->value_components()) {
      case 1: return predict<Index, 1>(*group_, *attribute_, positions_, position_, corrections_, arena, data_);
      case 2: return predict<Index, 2>(*group_, *attribute_, positions_, position_, corrections_, arena, data_);
      case 3: return predict<Index, 3>(*group_, *attribute_, positions_, position_, corrections_, arena, data_);
      case 4: return predict<Index, 4>(*group_, *attribute_, positions_, position_, corrections_, arena, data_);
      default:
        return predict<Index, 0>(*group_, *attribute_, positions_, position_, corrections_, arena, data_);
    }
  }

  const Group<Index>* group_ = nullptr;
  Attribute<Index>* attribute_ = nullptr;
  const Group<Index>* positions_ = nullptr;
  const Attribute<Index>* position_ = nullptr;
  PredictionData data_;
  View<int32_t> corrections_, zeros_;
  ParallelogramSteps<Index, 3> of_three_;
  ParallelogramSteps<Index, 2> of_two_;
  NormalSteps<Index> normals_;
};

// Reads what turns integers into the attribute's own type.
template <typename Index>
PSPLIT_HD Fault read_transform(ByteReader& reader, Attribute<Index>& attribute) {
  if (attribute.coding == Coding::kQuantized) {
    attribute.origin = reader.head();
    reader.skip(uint64_t{attribute.components} * sizeof(float));
    attribute.range = reader.f32();
    attribute.bits = reader.u8();
    if (attribute.bits < 1 || attribute.bits > 30)
      return reader.truncated() ? Fault::kTruncated : Fault::kAttribute;
  } else if (attribute.coding == Coding::kNormal) {
    attribute.bits = reader.u8();
    if (attribute.bits < 2 || attribute.bits > 30)
      return reader.truncated() ? Fault::kTruncated : Fault::kAttribute;
  }
  return reader.truncated() ? Fault::kTruncated : Fault::kNone;
}

// An attribute's values in its own type, to the bit what libdraco computes: no multiply-add may be fused.
template <typename Index>
class ValueWriter {
 public:
  // `type` is the attribute's own; of quantized ones it may be an integer, wide enough, for places on their
  // grid.
  PSPLIT_HD ValueWriter(const Attribute<Index>& attribute, DataType type)
      : attribute_(attribute), type_(type), coding_(attribute.coding) {
    if (coding_ == Coding::kQuantized && type != attribute.type) coding_ = Coding::kInteger;
    if (coding_ == Coding::kQuantized) step_ = attribute.step();
    if (attribute.coding == Coding::kNormal) grid_ = OctahedralGrid(attribute.bits);
  }

  // Writes the values of points [0, count). value_of(point) is a vertex of the
  // table, for kRaw a place in the sequence; place_of(point) is where its value goes, or null where nobody
  // wants it. Where kAligned, places are fit for the components' type, and a component is one store everywhere.
  template <bool kAligned, Lanes L, typename ValueOf, typename PlaceOf>
  PSPLIT_HD void write(L lanes, uint32_t count, ValueOf value_of, PlaceOf place_of) const {
    const auto each = [&](auto write_one) {
      for_each_lane_item(lanes, count, [&](uint32_t point) {
        if (uint8_t* place = place_of(point); place != nullptr) write_one(value_of(point), place);
      });
    };
    switch (coding_) {
      case Coding::kRaw:
        each([&](uint32_t value, uint8_t* out) {
          const uint32_t stride = attribute_.stride();
          for (uint32_t i = 0; i < stride; ++i) out[i] = attribute_.raw[size_t{value} * stride + i];
        });
        return;
      case Coding::kInteger:
        switch (data_type_bytes(type_)) {
          case 1:
            each([&](uint32_t value, uint8_t* out) { write_integers<kAligned, uint8_t>(value, out); });
            return;
          case 2:
            each([&](uint32_t value, uint8_t* out) { write_integers<kAligned, uint16_t>(value, out); });
            return;
          default:
            each([&](uint32_t value, uint8_t* out) { write_integers<kAligned, uint32_t>(value, out); });
            return;
        }
      case Coding::kQuantized:
        switch (attribute_.components) {
          case 2: each(dequantizer<kAligned, 2>()); return;
          case 3: each(dequantizer<kAligned, 3>()); return;
          default: each(dequantizer<kAligned, 0>()); return;
        }
      case Coding::kNormal:
        each([&](uint32_t value, uint8_t* out) {
          const int32_t* in = &attribute_.values[size_t{value} * 2];
          float vector[3];
          grid_.unit_vector({in[0], in[1]}, vector);
          store<kAligned>(out, vector);
        });
        return;
    }
  }

 private:
  template <bool kAligned, typename T>
  PSPLIT_HD static void store(uint8_t* out, const T& value) {
    if constexpr (kAligned) out = static_cast<uint8_t*>(__builtin_assume_aligned(out, alignof(T)));
    __builtin_memcpy(out, &value, sizeof(T));
  }

  template <bool kAligned, typename T>
  PSPLIT_HD void write_integers(uint32_t value, uint8_t* out) const {
    const int32_t* in = &attribute_.values[size_t{value} * value_stride(attribute_.components)];
    for (uint32_t k = 0; k < attribute_.components; ++k)
      store<kAligned>(out + k * sizeof(T), static_cast<T>(in[k]));
  }

  // For a number of components known at compile time, or not (0).
  template <bool kAligned, uint32_t kComponents>
  PSPLIT_HD auto dequantizer() const {
    return [this](uint32_t value, uint8_t* out) {
      const uint32_t components = kComponents != 0 ? kComponents : attribute_.components;
      const int32_t* in = &attribute_.values[size_t{value} * value_stride(components)];
      for (uint32_t k = 0; k < components; ++k) {
        float origin;
        __builtin_memcpy(&origin, attribute_.origin + 4 * k, sizeof origin);
        const float dequantized = static_cast<float>(in[k]) * step_ + origin;
        store<kAligned>(out + 4 * k, dequantized);
      }
    };
  }

  const Attribute<Index>& attribute_;
  DataType type_;
  Coding coding_;
  float step_ = 0;
  OctahedralGrid grid_;
};

}  // namespace psplit::core
