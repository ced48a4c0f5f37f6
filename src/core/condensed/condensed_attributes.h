// The attributes of a condensed stream: the rest of its skeleton, their numbers, and the section of each.
#pragma once

#include "src/core/border_walk.h"
#include "src/core/condensed/condensed_numbers.h"
#include "src/core/condensed/creation.h"
#include "src/core/condensed/deltas.h"
#include "src/core/condensed/skeleton.h"
#include "src/core/condensed/token_steps.h"
#include "src/core/integer_decoder.h"
#include "src/core/patch.h"

namespace psplit::core {

template <typename Index>
struct CondensedAttribute {
  SkeletonAttribute skeleton;
  const AttributeModel* model = nullptr;
  const TableSet* tables = nullptr;
  bool by_creation = false;
  bool is_delta = false;       // by creation as well, but the deltas decode it
  uint32_t section_bytes = 0;  // not of the first; of deltas: an equal share of their sections
  uint32_t flag_counts[AttributeModel::kCreaseContexts] = {};
  View<uint32_t> raw_symbols;  // of an attribute that is stored raw
  TokenSequence tokens;
  CreatedValues<Index> created;  // by creation
};

template <typename Index>
class CondensedAttributes {
 public:
  // Reads what follows the descriptions of attributes, and the numbers of all attributes. `integers` are by
  // attribute.
  PSPLIT_HD Fault read(const CondensedStream& stream, ByteReader& reader, Patch<Index>& patch,
                       View<IntegerDecoder<Index>> integers, Arena& arena) {
    const CondensedModels& models = stream.models;
    if (patch.attributes.size() != stream.attribute_count) return Fault::kAttribute;
    if (!arena.take(attributes_, patch.attributes.size()) || !arena.take(orders_, 2 * patch.groups.size() + 1))
      return Fault::kWorkspace;
    for (size_t i = 0; i < orders_.size(); ++i) orders_[i] = {};
    for (uint32_t g = 0; g < patch.groups.size(); ++g) {
      const Group<Index>& group = patch.groups[g];
      for (uint32_t i = group.first; i < group.first + group.count; ++i) {
        attributes_[i] = {};
        attributes_[i].model = &models.attributes[i];
        const Fault fault = read_scheme(reader, i, patch, integers[i]);
        if (fault != Fault::kNone) return fault;
      }
      for (uint32_t i = group.first; i < group.first + group.count; ++i)
        if (const Fault fault = read_transform(reader, patch.attributes[i]); fault != Fault::kNone)
          return fault;
    }
    return read_numbers(stream, patch, integers, arena);
  }

  // Whether values of the group are in the order of Draco's stream.
  PSPLIT_HD bool needs_sequence(const Group<Index>& group) const {
    for (uint32_t i = group.first; i < group.first + group.count; ++i)
      if (!attributes_[i].by_creation) return true;
    return false;
  }

  // Makes the tokens ready, when the groups have their tables and the length of their sequences. `section` is
  // the first section of attributes, after everything that precedes attributes. `corners` come from
  // CondensedConnectivity. Collective.
  template <Lanes L>
  PSPLIT_HD Fault start(L lanes, const CondensedStream& stream, const SectionReader& section,
                        const VertexCorners<Index>& corners, Patch<Index>& patch,
                        View<IntegerDecoder<Index>> integers, Arena& arena) {
    size_t at = 0;
    for (uint32_t i = 0; i < attributes_.size(); ++i) {
      if (attributes_[i].is_delta) continue;
      SectionReader own = section;
      if (i > 0) {
        const size_t bytes = attributes_[i].section_bytes;
        own = SectionReader(stream.bytes.data() + at, bytes);
        if (const Fault fault = own.start_words(0); fault != Fault::kNone) return fault;
        at += bytes;
      }
      const Fault fault =
          attributes_[i].by_creation
              ? start_created(lanes, i, corners, own, stream, patch, arena)
              : alone(lanes, [&] { return start_traversed(i, own, stream.models, patch, integers[i], arena); });
      if (fault != Fault::kNone) return fault;
    }
    if (!has_deltas()) return Fault::kNone;
    const Sequence<Index>* order = nullptr;
    const Fault fault = find_delta_order(lanes, corners, patch, order, arena);
    if (fault != Fault::kNone) return fault;
    return alone(lanes, [&] {
      delta_order_ = *order;
      return deltas_.start(stream, at, patch, arena);
    });
  }
  // Their tokens are pending after start, then their created values.
  PSPLIT_HD View<CondensedAttribute<Index>> attributes() const { return attributes_; }

  // Reads what follows the tokens, after all of their steps.
  PSPLIT_HD Fault finish_tokens(Patch<Index>& patch, View<IntegerDecoder<Index>> integers, Arena& arena) {
    for (uint32_t i = 0; i < attributes_.size(); ++i) {
      CondensedAttribute<Index>& attribute = attributes_[i];
      const Coding coding = patch.attributes[i].coding;
      Fault fault = Fault::kNone;
      if (coding == Coding::kRaw)
        fault = write_raw(attribute, patch.attributes[i], arena);
      else if (!attribute.by_creation)
        fault = read_flags(attribute, integers[i], arena);
      if (fault != Fault::kNone) return fault;
      if (!attribute.is_delta && !attribute.tokens.section().is_at_end()) return Fault::kSection;
    }
    return Fault::kNone;
  }

  // Checks created values after all of their steps. Draco's octahedral transforms have no values beyond the
  // grid, and one name for each place on its edge.
  PSPLIT_HD Fault finish_created(const Patch<Index>& patch, View<IntegerDecoder<Index>> integers) const {
    for (uint32_t i = 0; i < attributes_.size(); ++i) {
      const Attribute<Index>& description = patch.attributes[i];
      PredictionData& data = integers[i].data();
      if (!attributes_[i].by_creation || description.coding != Coding::kNormal || data.scheme == Scheme::kNone)
        continue;
      const OctahedralGrid grid = data.grid;
      const View<int32_t> values = description.values;
      for (size_t k = 0; k < values.size(); k += 2) {
        const auto s = static_cast<uint32_t>(values[k]), t = static_cast<uint32_t>(values[k + 1]);
        if (s >= grid.max_quantized() || t >= grid.max_quantized()) return Fault::kPrediction;
        const Vec2 normal = grid.canonical({values[k], values[k + 1]});
        values[k] = normal.s, values[k + 1] = normal.t;
      }
    }
    return Fault::kNone;
  }

  // Decodes the deltas, when the values of all other attributes are finished. Collective.
  PSPLIT_HD bool has_deltas() const { return deltas_.count() > 0; }
  template <Lanes L>
  PSPLIT_HD Fault decode_deltas(L lanes, const CondensedStream& stream, Patch<Index>& patch) {
    const DeltaPlaces places = DeltaPlaces::of(patch.attributes[0], attributes_[0].by_creation);
    return deltas_.decode(lanes, stream, delta_order_, places, patch);
  }

  // The memory that all of them take and keep. An attribute whose values are not created has integers, which
  // take less than created values with two predictors.
  PSPLIT_HD static size_t bytes(const CondensedStream& stream, uint32_t attribute_data_count,
                                const ValueCounts& values) {
    const uint64_t orders = 2 * (uint64_t{attribute_data_count} + 1) + 1;
    const uint64_t used_orders = orders < stream.attribute_count ? orders : stream.attribute_count;
    // A container's directory may state fewer attributes than its stream has.
    const uint32_t in_stream = stream.models.delta_count(stream.attribute_count);
    const uint64_t deltas =
        in_stream <= values.attributes && kDeltaComponents * in_stream <= values.components ? in_stream : 0;
    bool has_two = stream.traversed_count > 0;
    for (uint32_t i = 0; i < stream.attribute_count; ++i)
      has_two |= CreatedValues<Index>::mode_of(stream.models.attributes[i]) != CreationMode::kOne;
    return Arena::bytes<CondensedAttribute<Index>>(values.attributes) + Arena::bytes<Sequence<Index>>(orders) +
           used_orders * Sequence<Index>::bytes(values.points) +
           CreatedValues<Index>::bytes(values.points, values.attributes - deltas,
                                       values.components - kDeltaComponents * deltas, has_two ? 2 : 1) +
           DeltaDecoder<Index>::bytes(stream, values.points) +
           (stream.models.has_borders ? border_walk_bytes<Index>(values.points) : 0) +
           values.attributes * Arena::bytes<uint8_t>(values.points);
  }

  // The memory that is taken and released.
  PSPLIT_HD static size_t scratch_bytes(uint32_t face_count) {
    return Arena::bytes<uint8_t>(uint64_t{4} * face_count);
  }

 private:
  PSPLIT_HD Fault read_scheme(ByteReader& reader, uint32_t i, Patch<Index>& patch,
                              IntegerDecoder<Index>& integers) {
    Attribute<Index>& description = patch.attributes[i];
    CondensedAttribute<Index>& attribute = attributes_[i];
    if (description.coding == Coding::kRaw)
      return data_type_bytes(description.type) <= sizeof(uint32_t) ? Fault::kNone : Fault::kMethod;
    const Attribute<Index>* const position = patch.position_before(i);
    const uint8_t scheme = ByteReader(reader).u8();
    const Fault fault =
        integers.describe(reader, /*is_edgebreaker=*/true, patch.groups[description.group], description,
                          position != nullptr ? &patch.groups[position->group] : nullptr, position);
    if (fault != Fault::kNone) return fault;
    PredictionData& data = integers.data();
    // Draco decodes a scheme that does not fit its attribute as another scheme; its encoder does not write it.
    if (static_cast<uint8_t>(data.scheme) != scheme) return Fault::kMethod;
    if (reader.u8() == 0) return reader.truncated() ? Fault::kTruncated : Fault::kMethod;
    attribute.skeleton = {description.coding, data.scheme, data.transform, 0, 0};
    attribute.by_creation = attribute.skeleton.is_by_creation(*attribute.model);
    attribute.is_delta = attribute.model->is_delta;
    if (attribute.is_delta && !attribute.by_creation) return Fault::kAttribute;
    return attribute.skeleton.has_grid() ? data.read_grid(reader) : Fault::kNone;
  }

  PSPLIT_HD Fault read_numbers(const CondensedStream& stream, const Patch<Index>& patch,
                               View<IntegerDecoder<Index>> integers, Arena& arena) {
    CondensedNumbers numbers(stream.numbers(stream.lengths_at));
    CondensedKinds kinds;
    for (uint32_t i = 1; i < attributes_.size(); ++i)
      if (!attributes_[i].is_delta) attributes_[i].section_bytes = numbers.number(kinds.bytes);
    if (const Fault fault = deltas_.read(stream, numbers, kinds.bytes, patch, arena); fault != Fault::kNone)
      return fault;
    for (uint32_t n = 0; n < deltas_.count(); ++n)
      attributes_[stream.models.deltas[n].attribute].section_bytes = deltas_.share_of_sections(n);
    for (uint32_t i = 0; i < attributes_.size(); ++i) {
      if (attributes_[i].by_creation || !attributes_[i].skeleton.has_wrap_range()) continue;
      const int64_t low = numbers.signed_number(kinds.low), extent = numbers.number(kinds.extent);
      const Fault fault = integers[i].data().wrap.set(low, low + extent);
      if (fault != Fault::kNone) return fault;
    }
    for (uint32_t i = 0; i < attributes_.size(); ++i) {
      CondensedAttribute<Index>& attribute = attributes_[i];
      bool has_flags = attribute.skeleton.scheme == Scheme::kGeometricNormal;
      for (uint32_t k = 0; k < attribute.skeleton.flag_lists(); ++k) {
        attribute.flag_counts[k] = numbers.number(kinds.flags);
        // No scheme has more flags than there are corners.
        if (attribute.flag_counts[k] > uint64_t{3} * patch.face_count) return Fault::kPrediction;
        has_flags |= attribute.flag_counts[k] > 0;
      }
      if (has_flags && !attribute.model->has_flags) return Fault::kAttribute;
    }
    return read_sets(stream.models, numbers);
  }

  PSPLIT_HD Fault read_sets(const CondensedModels& models, CondensedNumbers& numbers) {
    for (uint32_t i = 0; i < attributes_.size(); ++i) {
      CondensedAttribute<Index>& attribute = attributes_[i];
      const uint32_t set = numbers.bits(static_cast<int>(set_bits(*attribute.model)));
      if (set >= attribute.model->set_count) return Fault::kAttribute;
      attribute.tables = &models.table_sets[attribute.model->first_set + set];
    }
    return numbers.broken() ? Fault::kTruncated : Fault::kNone;
  }

  PSPLIT_HD static bool has_tables(const TableSet& set, uint32_t used) {
    for (uint32_t t = 0; t < TableSet::kTables; ++t)
      if ((used >> t & 1) != 0 && set.tables[t] == kNoTable) return false;
    return true;
  }

  template <Lanes L>
  PSPLIT_HD Fault start_created(L lanes, uint32_t i, const VertexCorners<Index>& corners,
                                const SectionReader& section, const CondensedStream& stream,
                                Patch<Index>& patch, Arena& arena) {
    CondensedAttribute<Index>& attribute = attributes_[i];
    const Attribute<Index>& description = patch.attributes[i];
    const AttributeModel& model = *attribute.model;
    const uint32_t group = description.group;
    const AttributeTable<Index>& table = patch.groups[group].table;
    const bool has_known = i == 0 && stream.models.has_borders;
    Sequence<Index>& order = orders_[has_known ? orders_.size() - 1 : 2 * group + model.backward];
    Fault fault = alone(lanes, [&] {
      if (!has_known) share_order(group, model.backward, patch, order);
      return attribute.created.allocate(model, table, patch.attributes[i], arena);
    });
    const bool has_order = !order.corner.empty();
    lanes.sync();
    uint32_t known_count = 0;
    if (fault == Fault::kNone && !has_order)
      fault = find_order(lanes, i, has_known, corners, stream, patch, known_count, order, arena);
    if (fault != Fault::kNone) return fault;
    if (!alone(lanes, [&] { return share_predictors(i, order); }))
      attribute.created.find_predictors(lanes, model, order, known_count);
    return alone(lanes, [&] {
      if (!has_tables(*attribute.tables, attribute.created.used_tables())) return Fault::kEntropy;
      attribute.tokens.start(section, stream.models, *attribute.tables, description.value_components(),
                             attribute.created.table_of(), attribute.created.symbols());
      return Fault::kNone;
    });
  }

  // The order of creation, backward, of the first attribute's table.
  template <Lanes L>
  PSPLIT_HD Fault find_delta_order(L lanes, const VertexCorners<Index>& corners, const Patch<Index>& patch,
                                   const Sequence<Index>*& found, Arena& arena) {
    const uint32_t group = patch.attributes[0].group;
    Sequence<Index>& order = orders_[2 * group + 1];
    found = &order;
    if (alone(lanes, [&] {
          share_order(group, /*backward=*/true, patch, order);
          return !order.corner.empty();
        }))
      return Fault::kNone;
    const AttributeTable<Index>& table = patch.groups[group].table;
    const Fault fault = alone(
        lanes, [&] { return order.allocate(table.vertex_count, arena) ? Fault::kNone : Fault::kWorkspace; });
    if (fault != Fault::kNone) return fault;
    fill(lanes, order.rank, kNone<Index>);
    return find_order(lanes, /*backward=*/true, corners, patch, table, 0, order, arena);
  }

  // Finds the order of the attribute's values. Known values come first.
  template <Lanes L>
  PSPLIT_HD Fault find_order(L lanes, uint32_t i, bool has_known, const VertexCorners<Index>& corners,
                             const CondensedStream& stream, Patch<Index>& patch, uint32_t& known_count,
                             Sequence<Index>& order, Arena& arena) const {
    const AttributeTable<Index>& table = patch.groups[patch.attributes[i].group].table;
    Fault fault = alone(
        lanes, [&] { return order.allocate(table.vertex_count, arena) ? Fault::kNone : Fault::kWorkspace; });
    if (fault != Fault::kNone) return fault;
    fill(lanes, order.rank, kNone<Index>);
    if (has_known) fault = find_known(lanes, stream, patch, order, known_count, arena);
    if (fault != Fault::kNone) return fault;
    return find_order(lanes, attributes_[i].model->backward, corners, patch, table, known_count, order, arena);
  }

  // Sets the values of vertices on the border, which come first in the order.
  template <Lanes L>
  PSPLIT_HD Fault find_known(L lanes, const CondensedStream& stream, Patch<Index>& patch,
                             const Sequence<Index>& order, uint32_t& count, Arena& arena) const {
    if (const Fault fault = walk_border(lanes, patch, arena, patch.walk); fault != Fault::kNone) return fault;
    if (lanes.rank() == 0) patch.is_walked = true;
    const Attribute<Index>& attribute = patch.attributes[0];
    const AttributeTable<Index>& table = patch.groups[attribute.group].table;
    const uint32_t components = attribute.value_components();
    const View<const Index> walk = patch.walk;
    if (stream.known.size() != walk.size() * components) return Fault::kCounts;
    const auto set = [&](uint32_t place, Index vertex, uint32_t number) {
      order.corner[number] = 0;
      order.rank[vertex] = static_cast<Index>(number);
      for (uint32_t k = 0; k < components; ++k)
        attribute.values[size_t{vertex} * value_stride(components) + k] =
            stream.known[size_t{place} * components + k];
    };
    const auto length = static_cast<uint32_t>(walk.size());
    if (patch.corner_of_point.empty()) {
      // The points are the vertices, and no point is in the walk twice.
      for_each_lane_item(lanes, length, [&](uint32_t place) { set(place, walk[place], place); });
      lanes.sync();
      count = length;
      return Fault::kNone;
    }
    count = alone(lanes, [&] {
      uint32_t known = 0;
      for (uint32_t place = 0; place < length; ++place) {
        const Index vertex = table.table.vertex[patch.corner_of_point[walk[place]]];
        if (order.rank[vertex] == kNone<Index>) set(place, vertex, known++);
      }
      return known;
    });
    return Fault::kNone;
  }

  // Attributes without seams have the same predictors, if their models choose them alike.
  PSPLIT_HD bool share_predictors(uint32_t i, const Sequence<Index>& order) {
    const AttributeModel& model = *attributes_[i].model;
    for (uint32_t k = 0; k < i; ++k) {
      const AttributeModel& other = *attributes_[k].model;
      if (attributes_[k].by_creation && !attributes_[k].is_delta && other.two == model.two &&
          other.mean == model.mean && attributes_[i].created.share_predictors(attributes_[k].created, order))
        return true;
    }
    return false;
  }

  // All tables without seams have the same order.
  PSPLIT_HD void share_order(uint32_t group, bool backward, const Patch<Index>& patch,
                             Sequence<Index>& order) const {
    for (uint32_t other = 0; other < group && order.corner.empty() && !patch.groups[group].table.has_seams;
         ++other)
      if (!patch.groups[other].table.has_seams) order = orders_[2 * other + backward];
  }
  // Finds the order of a table's vertices. The known ones have their places in it.
  template <Lanes L>
  PSPLIT_HD static Fault find_order(L lanes, bool backward, const VertexCorners<Index>& corners,
                                    const Patch<Index>& patch, const AttributeTable<Index>& table,
                                    uint32_t known_count, const Sequence<Index>& order, Arena& arena) {
    CreationOrder<Index> creation(table.table, known_count, order);
    // Without seams only one corner can be the first one of a vertex.
    if (table.has_seams || corners.are_last != backward)
      return alone(lanes, [&] {
        return backward ? creation.see_backward(patch.face_count) : creation.see_forward(patch.face_count);
      });
    if (!backward) return creation.see_first(lanes, corners.corner);
    const size_t mark = arena.mark();
    View<uint8_t> marks;
    lanes.sync();
    if (!take(lanes, arena, marks, uint64_t{4} * patch.face_count)) return Fault::kWorkspace;
    const Fault fault = creation.see_last(lanes, corners.corner, patch.face_count, marks);
    if (lanes.rank() == 0) arena.release(mark);
    lanes.sync();
    return fault;
  }
  PSPLIT_HD Fault start_traversed(uint32_t i, const SectionReader& section, const CondensedModels& models,
                                  Patch<Index>& patch, IntegerDecoder<Index>& integers, Arena& arena) {
    constexpr uint32_t kFirst = 3;  // values with a table of their own
    CondensedAttribute<Index>& attribute = attributes_[i];
    const Attribute<Index>& description = patch.attributes[i];
    const uint32_t count = patch.groups[description.group].sequence.count;
    View<uint8_t> table_of;
    if (!arena.take(table_of, count)) return Fault::kWorkspace;
    for (uint32_t value = 0; value < count; ++value) table_of[value] = value >= kFirst;
    if (!has_tables(*attribute.tables, (count > 0 ? 1 : 0) | (count > kFirst ? 2 : 0))) return Fault::kEntropy;
    View<uint32_t> symbols;
    if (description.coding == Coding::kRaw) {
      if (!arena.take(attribute.raw_symbols, uint64_t{count} * description.components))
        return Fault::kWorkspace;
      symbols = attribute.raw_symbols;
    } else {
      if (const Fault fault = integers.allocate(arena); fault != Fault::kNone) return fault;
      symbols = integers.symbols();
    }
    attribute.tokens.start(section, models, *attribute.tables, description.value_components(), table_of,
                           symbols);
    return Fault::kNone;
  }

  // Each component is stored as its difference from the same component of the value before.
  PSPLIT_HD static Fault write_raw(const CondensedAttribute<Index>& attribute, Attribute<Index>& description,
                                   Arena& arena) {
    const uint32_t bytes = data_type_bytes(description.type), components = description.components;
    const View<uint32_t> symbols = attribute.raw_symbols;
    View<uint8_t> raw;
    if (!arena.take(raw, uint64_t{symbols.size()} * bytes)) return Fault::kWorkspace;
    description.raw = raw.data();
    for (size_t i = 0; i < symbols.size(); ++i) {
      symbols[i] = signed_of_symbol(symbols[i]) + (i >= components ? symbols[i - components] : 0);
      for (uint32_t k = 0; k < bytes; ++k) raw[i * bytes + k] = static_cast<uint8_t>(symbols[i] >> 8 * k);
    }
    return Fault::kNone;
  }

  PSPLIT_HD static Fault take_flags(SectionReader& section, uint32_t probability, uint32_t count,
                                    View<uint8_t>& flags, Arena& arena) {
    if (!arena.take(flags, count)) return Fault::kWorkspace;
    for (uint32_t i = 0; i < count; ++i) flags[i] = static_cast<uint8_t>(section.next_bit(probability));
    return Fault::kNone;
  }
  PSPLIT_HD static Fault read_flags(CondensedAttribute<Index>& attribute, IntegerDecoder<Index>& integers,
                                    Arena& arena) {
    PredictionData& data = integers.data();
    SectionReader& section = attribute.tokens.section();
    const AttributeModel& model = *attribute.model;
    Fault fault = Fault::kNone;
    if (attribute.skeleton.has_grid()) {
      // Symbols are signed, and Draco's corrections are below the number of values in the grid.
      const View<uint32_t> symbols = integers.symbols();
      uint32_t too_large = 0;
      for (size_t i = 0; i < symbols.size(); ++i) too_large |= mask(symbols[i] >= data.grid.max_quantized());
      if (too_large != 0) return Fault::kPrediction;
    }
    if (data.scheme == Scheme::kConstrainedMultiParallelogram)
      for (uint32_t k = 0; k < kMaxParallelograms && fault == Fault::kNone; ++k)
        fault = take_flags(section, model.creases[k], attribute.flag_counts[k], data.creases[k], arena);
    if (data.scheme == Scheme::kTexCoords) {
      fault = take_flags(section, model.orientations, attribute.flag_counts[0], data.orientations, arena);
      if (fault == Fault::kNone) data.find_orientations([&](uint32_t k) { return data.orientations[k] != 0; });
    }
    View<uint8_t> flips;
    if (data.scheme == Scheme::kGeometricNormal) {
      fault = take_flags(section, model.flips, integers.value_count(), flips, arena);
      data.flips_by_value = flips;
    }
    return fault;
  }

  View<CondensedAttribute<Index>> attributes_;
  DeltaDecoder<Index> deltas_;
  Sequence<Index> delta_order_;
  // The orders of creation, by group: forward and backward. Each is empty until it is needed. The last one is
  // that of the first attribute, if values at borders are known.
  View<Sequence<Index>> orders_;
};

}  // namespace psplit::core
