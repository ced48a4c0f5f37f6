// The attributes of a stream: their groups and descriptions, the sequence of each group, the integers of each
// attribute.
#pragma once

#include "src/core/condensed/condensed_attributes.h"
#include "src/core/integer_decoder.h"
#include "src/core/patch.h"
#include "src/core/stream_header.h"

namespace psplit::core {

template <typename Index, StreamKinds kKinds = StreamKinds::kBoth>
class AttributeDecoder {
 public:
  PSPLIT_HD AttributeDecoder(const StreamHeader& header, Arena& arena, Patch<Index>& patch)
      : header_(header), arena_(arena), patch_(patch) {}

  // Reads groups and descriptions, finds the sequence of each group, and reads the first attributes. After
  // begin_traversals, sequences(), traversals(), degree_walks() and tokens of condensed() are pending.
  // `seam_tables` are by attribute data. A condensed stream needs start_condensed as well.
  PSPLIT_HD Fault start(ByteReader& reader, View<AttributeTable<Index>> seam_tables) {
    const uint32_t group_count = reader.u8();
    if (reader.truncated()) return Fault::kTruncated;
    if (group_count > kMaxAttributeData + 1) return Fault::kAttribute;
    if (!arena_.take(patch_.groups, group_count) || !arena_.take(traversals_, group_count))
      return Fault::kWorkspace;
    Fault fault = read_groups(reader);
    if (fault != Fault::kNone) return fault;
    uint32_t attribute_count = 0;
    fault = read_attributes(reader, patch_.groups, arena_, patch_.attributes, attribute_count,
                            read_descriptions<Index>);
    if (fault != Fault::kNone) return fault;
    if (!arena_.take(sequences_, attribute_count) || !arena_.take(integers_, attribute_count))
      return Fault::kWorkspace;
    for (uint32_t i = 0; i < attribute_count; ++i) integers_[i] = {};
    if (is_condensed()) fault = condensed_.read(header_.condensed, reader, patch_, integers_, arena_);
    if (fault == Fault::kNone) fault = header_.edgebreaker ? find_sequences(seam_tables) : list_points();
    return fault != Fault::kNone || is_condensed() ? fault : read(reader);
  }
  // See CondensedAttributes::start. Collective.
  template <Lanes L>
  PSPLIT_HD Fault start_condensed(L lanes, const SectionReader& section, const VertexCorners<Index>& corners) {
    return condensed_.start(lanes, header_.condensed, section, corners, patch_, integers_, arena_);
  }

  // One thread makes the walk by prediction degree at once: in step with others it is slower. Collective.
  template <Lanes L>
  PSPLIT_HD Fault begin_traversals(L lanes) {
    for (uint32_t i = 0; i < traversal_count_; ++i) traversals_[i].begin(lanes);
    const Group<Index>* const group = walked_by_degree_;
    if (group == nullptr) return Fault::kNone;
    if constexpr (L::size() == 1) {
      return traverse_by_prediction_degree(group->table, arena_, group->sequence);
    } else {
      const Fault fault = alone(lanes, [&] {
        before_degree_walk_ = arena_.mark();
        if (!arena_.take(degree_walks_, 1)) return Fault::kWorkspace;
        degree_walks_[0] = {};
        return degree_walks_[0].allocate(group->table, arena_, group->sequence);
      });
      if (fault == Fault::kNone) degree_walks_[0].begin(lanes);
      return fault;
    }
  }

  // The symbols of the attributes that were read last, and the walks over the groups' tables. At most one of
  // these is by prediction degree, and only lanes take its steps.
  PSPLIT_HD View<SymbolSequence> sequences() const {
    return View<SymbolSequence>(sequences_.data() + first_pending_, sequence_count_ - first_pending_);
  }
  PSPLIT_HD View<DepthFirstTraversal<Index>> traversals() const { return traversals_.first(traversal_count_); }
  PSPLIT_HD View<PredictionDegreeTraversal<Index>> degree_walks() const { return degree_walks_; }
  // The attributes of a condensed stream. Empty for a Draco stream.
  PSPLIT_HD View<CondensedAttribute<Index>> condensed() const { return condensed_.attributes(); }

  // Whether traversals have steps left.
  PSPLIT_HD bool walks() const {
    for (uint32_t i = 0; i < traversal_count_; ++i)
      if (traversals_[i].steps_left() > 0) return true;
    return false;
  }
  // Takes these steps, and finishes the traversals.
  PSPLIT_HD Fault walk_to_end() {
    for (uint32_t i = 0; i < traversal_count_; ++i)
      while (traversals_[i].steps_left() > 0) traversals_[i].step();
    return finish_traversals();
  }

  // Finish traversals, and the pending sequences, after their steps were taken. finish_sequences is collective.
  PSPLIT_HD Fault finish_traversals() {
    if (!degree_walks_.empty()) {
      const Fault fault = degree_walks_[0].finish();
      degree_walks_ = {};
      arena_.release(before_degree_walk_);
      if (fault != Fault::kNone) return fault;
    }
    for (; traversal_count_ > 0; --traversal_count_) {
      DepthFirstTraversal<Index>& traversal = traversals_[traversal_count_ - 1];
      if (const Fault fault = traversal.finish(); fault != Fault::kNone) return fault;
      traversal.give_back(arena_);
    }
    return Fault::kNone;
  }
  template <Lanes L>
  PSPLIT_HD Fault finish_sequences(L lanes, ByteReader& reader) {
    if (is_condensed()) return Fault::kNone;
    for (uint32_t i = first_pending_; i < sequence_count_; ++i)
      if (const Fault fault = sequences_[i].finish(lanes, reader); fault != Fault::kNone) return fault;
    return Fault::kNone;
  }

  PSPLIT_HD Fault finish_tokens() { return condensed_.finish_tokens(patch_, integers_, arena_); }

  // Whether all attributes are read; otherwise read_on reads more, and sequences() are pending again.
  PSPLIT_HD bool is_read() const { return is_condensed() || group_ == patch_.groups.size(); }
  PSPLIT_HD Fault read_on(ByteReader& reader) {
    first_pending_ = sequence_count_;
    return read(reader);
  }

  // Reads up to the end of the stream without decoding values. Of symbols, only those are decoded whose end is
  // not stored.
  PSPLIT_HD Fault read_to_end(ByteReader& reader) {
    Fault fault = Fault::kNone;
    while (fault == Fault::kNone && !is_read()) {
      fault = sequences_[sequence_count_ - 1].finish(SerialLanes(), reader);
      if (fault == Fault::kNone) fault = read_on(reader);
    }
    return fault;
  }

  // See IntegerDecoder::take_values, when all attributes are read.
  PSPLIT_HD Fault take_values() {
    for (uint32_t i = 0; i < integers_.size(); ++i)
      if (has_integers(i) && !integers_[i].take_values(arena_)) return Fault::kWorkspace;
    return Fault::kNone;
  }
  // Makes the steps of integers() ready, after take_values. Collective.
  template <Lanes L>
  PSPLIT_HD void start_predictions(L lanes) {
    if constexpr (L::size() > 1)
      for (size_t i = 0; i < condensed().size(); ++i) condensed()[i].created.predict(lanes);
    for (uint32_t i = 0; i < integers_.size(); ++i)
      if (has_integers(i))
        integers_[i].start_prediction(lanes, is_condensed(), L::size() > 1 && knows_positions(i));
  }
  PSPLIT_HD View<IntegerDecoder<Index>> integers() const { return integers_; }
  // Whether all values are computed after start_predictions.
  PSPLIT_HD bool are_predicted() const {
    for (uint32_t i = 0; i < integers_.size(); ++i)
      if (has_integers(i) && !integers_[i].is_predicted()) return false;
    for (size_t i = 0; i < condensed().size(); ++i)
      if (condensed()[i].created.steps_left() > 0) return false;
    return true;
  }
  PSPLIT_HD Fault check_created() const {
    return is_condensed() ? condensed_.finish_created(patch_, integers_) : Fault::kNone;
  }
  // Finishes the integers after their steps were taken.
  PSPLIT_HD Fault finish_predictions() {
    Fault fault = check_created();
    const size_t mark = arena_.mark();
    ParallelogramFinder<Index> parallelograms;
    for (uint32_t i = 0; i < integers_.size() && fault == Fault::kNone; ++i)
      if (has_integers(i)) fault = integers_[i].finish(parallelograms, arena_, mark);
    arena_.release(mark);
    return fault;
  }
  // Decodes the deltas of a condensed stream, when all other values are finished. Collective.
  template <Lanes L>
  PSPLIT_HD Fault decode_deltas(L lanes) {
    return is_condensed() && condensed_.has_deltas()
               ? condensed_.decode_deltas(lanes, header_.condensed, patch_)
               : Fault::kNone;
  }

  // The memory that `start` takes and keeps, without integers and their symbols.
  PSPLIT_HD static size_t bytes(const StreamHeader& header, const ValueCounts& values) {
    const uint64_t attributes = values.attributes, most_groups = uint64_t{header.attribute_data_count} + 1;
    const uint64_t groups = header.edgebreaker && most_groups < attributes ? most_groups : attributes;
    const size_t sequences = is_traversed(header)
                                 ? groups * (Sequence<Index>::bytes(values.points) +
                                             DepthFirstTraversal<Index>::bytes(header.counts.face_count))
                             : header.edgebreaker ? 0
                                                  : Arena::bytes<Index>(values.points);
    return Arena::bytes<Group<Index>>(groups) + Arena::bytes<DepthFirstTraversal<Index>>(groups) +
           Arena::bytes<Attribute<Index>>(attributes) + Arena::bytes<SymbolSequence>(attributes) +
           Arena::bytes<IntegerDecoder<Index>>(attributes) + sequences;
  }
  // The memory that a walk by prediction degree takes beside the integers' memory, and releases before their
  // values take memory. Values of a condensed stream that are not created take less than is planned for them.
  PSPLIT_HD static size_t walk_bytes(const StreamHeader& header, const ValueCounts& values) {
    if (!is_traversed(header)) return 0;
    const uint32_t faces = header.counts.face_count;
    return Arena::bytes<PredictionDegreeTraversal<Index>>(1) +
           PredictionDegreeTraversal<Index>::bytes(faces, values.points) -
           DepthFirstTraversal<Index>::bytes(faces);
  }
  // The memory of integers and of their symbols.
  PSPLIT_HD static size_t integer_bytes(const StreamHeader& header, size_t stream_bytes,
                                        const ValueCounts& values) {
    if (header.is_condensed())
      return CondensedAttributes<Index>::bytes(header.condensed, header.attribute_data_count, values);
    const uint64_t symbols = uint64_t{values.points} * values.components;
    const size_t slots = values.attributes == 1 ? RansTable::slot_bytes_of_one(symbols, stream_bytes)
                                                : RansTable::slot_bytes(symbols, stream_bytes);
    const size_t tables = SymbolSequence::bytes(values.attributes, symbols) + slots;
    return IntegerDecoder<Index>::bytes(values.points, values.attributes, values.components, tables);
  }
  // The memory that is taken and released after that.
  PSPLIT_HD static size_t scratch_bytes(const StreamHeader& header, const ValueCounts& values) {
    const uint32_t faces = header.counts.face_count;
    const size_t prediction = is_traversed(header) ? IntegerDecoder<Index>::finish_bytes(values.points) : 0;
    const size_t condensed = header.is_condensed() ? CondensedAttributes<Index>::scratch_bytes(faces) : 0;
    return prediction > condensed ? prediction : condensed;
  }

 private:
  // Whether some attribute is in the order of a traversal.
  PSPLIT_HD static bool is_traversed(const StreamHeader& header) {
    return header.edgebreaker && (!header.is_condensed() || header.condensed.traversed_count > 0);
  }

  PSPLIT_HD bool is_condensed() const { return header_.template is_condensed_of<kKinds>(); }

  // Whether integers_ decodes the attribute.
  PSPLIT_HD bool has_integers(uint32_t attribute) const {
    return patch_.attributes[attribute].coding != Coding::kRaw &&
           (!is_condensed() || !condensed()[attribute].by_creation);
  }

  // Whether the positions that an attribute may be predicted from are computed.
  PSPLIT_HD bool knows_positions(uint32_t attribute) const {
    const Attribute<Index>* const position = patch_.position_before(attribute);
    if (position == nullptr) return false;
    const auto i = static_cast<uint32_t>(position - patch_.attributes.data());
    return has_integers(i) ? integers_[i].is_predicted()
                           : is_condensed() && condensed()[i].created.steps_left() == 0;
  }

  PSPLIT_HD Fault read_groups(ByteReader& reader) {
    bool has_shared = false;
    for (Group<Index>* group = patch_.groups.data(); group != patch_.groups.data() + patch_.groups.size();
         ++group) {
      *group = {};
      if (!header_.edgebreaker) continue;
      group->attribute_data = static_cast<int8_t>(reader.u8());
      group->per_corner = reader.u8() != 0;
      const uint8_t traversal = reader.u8();
      if (reader.truncated()) return Fault::kTruncated;
      group->by_prediction_degree = traversal == 1;
      if (traversal > 1 || (group->per_corner && group->by_prediction_degree)) return Fault::kMethod;
      if (group->attribute_data < 0) {
        if (group->per_corner || has_shared) return Fault::kAttribute;
        has_shared = true;
        continue;
      }
      if (static_cast<uint32_t>(group->attribute_data) >= header_.attribute_data_count)
        return Fault::kAttribute;
      for (const Group<Index>* other = patch_.groups.data(); other != group; ++other)
        if (other->attribute_data == group->attribute_data) return Fault::kAttribute;
    }
    return Fault::kNone;
  }

  // A sequential stream has no corner table: its vertices are the points, and values are in their order.
  PSPLIT_HD Fault list_points() {
    View<Index> identity;
    if (!arena_.take(identity, patch_.point_count)) return Fault::kWorkspace;
    for (uint32_t i = 0; i < patch_.point_count; ++i) identity[i] = static_cast<Index>(i);
    for (uint32_t g = 0; g < patch_.groups.size(); ++g) {
      patch_.groups[g].table.table.vertex = identity;
      patch_.groups[g].table.vertex_count = patch_.point_count;
      patch_.groups[g].sequence = {identity, identity, patch_.point_count};
    }
    return Fault::kNone;
  }

  PSPLIT_HD Fault find_sequences(View<AttributeTable<Index>> seam_tables) {
    for (uint32_t g = 0; g < patch_.groups.size(); ++g) {
      Group<Index>& group = patch_.groups[g];
      const Connectivity<Index>& mesh = patch_.mesh;
      group.table = group.per_corner ? seam_tables[static_cast<size_t>(group.attribute_data)]
                                     : AttributeTable<Index>{mesh.table, mesh.closed, mesh.vertex_count, false};
      if (is_condensed() && !condensed_.needs_sequence(group)) continue;
      if (const Fault fault = find_sequence(group); fault != Fault::kNone) return fault;
    }
    return Fault::kNone;
  }
  // A traversal is made ready here, and takes its steps later. Groups by prediction degree have the mesh's
  // table, and so the same walk.
  PSPLIT_HD Fault find_sequence(Group<Index>& group) {
    // A walk of one kind over one table always gives one sequence, so groups share it.
    for (const Group<Index>* other = patch_.groups.data(); other != &group; ++other) {
      if (other->table.table.opposite.data() != group.table.table.opposite.data() ||
          other->by_prediction_degree != group.by_prediction_degree || other->sequence.corner.empty())
        continue;
      group.sequence = other->sequence;
      return Fault::kNone;
    }
    if (!group.sequence.allocate(group.table.vertex_count, arena_)) return Fault::kWorkspace;
    if (group.by_prediction_degree) {
      walked_by_degree_ = &group;
      return Fault::kNone;
    }
    traversals_[traversal_count_] = {};
    return traversals_[traversal_count_++].allocate(group.table, arena_, group.sequence);
  }

  // Reads on from attribute_ of group_, to the end of the stream or to symbols that must be decoded to find
  // their end.
  PSPLIT_HD Fault read(ByteReader& reader) {
    for (; group_ < patch_.groups.size(); ++group_) {
      const Group<Index>& group = patch_.groups[group_];
      const uint32_t end = group.first + group.count;
      for (; attribute_ < end; ++attribute_) {
        const Fault fault = read_attribute(reader, group, patch_.attributes[attribute_]);
        if (fault != Fault::kNone || waits_for_tags_) return fault;
      }
      for (uint32_t i = group.first; i < end; ++i)
        if (const Fault fault = read_transform(reader, patch_.attributes[i]); fault != Fault::kNone)
          return fault;
    }
    return Fault::kNone;
  }
  // The end of tagged symbols is known after their tags: then this reads up to the symbols, and is called
  // again.
  PSPLIT_HD Fault read_attribute(ByteReader& reader, const Group<Index>& group, Attribute<Index>& attribute) {
    if (attribute.coding == Coding::kRaw) {
      attribute.raw = reader.head();
      return reader.skip(uint64_t{attribute.stride()} * group.sequence.count) ? Fault::kNone
                                                                              : Fault::kTruncated;
    }
    IntegerDecoder<Index>& integers = integers_[attribute_];
    if (!waits_for_tags_) {
      SymbolSequence& symbols = sequences_[sequence_count_++];
      symbols = {};
      const Attribute<Index>* position = patch_.position_before(attribute_);
      const Fault fault = integers.start(reader, header_.edgebreaker, group, attribute,
                                         position != nullptr ? &patch_.groups[position->group] : nullptr,
                                         position, arena_, symbols);
      waits_for_tags_ = symbols.is_tagged();
      if (fault != Fault::kNone || waits_for_tags_) return fault;
    }
    waits_for_tags_ = false;
    return integers.read_prediction(reader, /*corner_limit=*/3 * patch_.face_count, arena_);
  }

  const StreamHeader& header_;
  Arena& arena_;
  Patch<Index>& patch_;

  uint32_t group_ = 0, attribute_ = 0;  // to be read next
  bool waits_for_tags_ = false;         // that attribute is read up to its symbols
  View<DepthFirstTraversal<Index>> traversals_;
  uint32_t traversal_count_ = 0;
  const Group<Index>* walked_by_degree_ = nullptr;
  View<PredictionDegreeTraversal<Index>> degree_walks_;
  size_t before_degree_walk_ = 0;  // in the arena
  View<SymbolSequence> sequences_;
  uint32_t first_pending_ = 0, sequence_count_ = 0;
  View<IntegerDecoder<Index>> integers_;
  CondensedAttributes<Index> condensed_;
};

}  // namespace psplit::core
