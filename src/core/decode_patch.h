// One Draco mesh stream to faces, points and integers: the stages of the decoder in their order. Read this
// first.
//
//   parse         stream_header.h    counts, where sections are
//   connectivity  edgebreaker.h      symbols, split events, start faces -> corner table
//   seams         seams.h            seam bits -> corner tables of attributes, points
//   traversal     traversal.h        corner table -> the order of values
//   symbols       symbols.h, rans.h  entropy-coded residuals
//   prediction    prediction.h       residuals, order, corner table -> integers by vertex
//   output        attributes.h       integers -> floats and integers of the attribute's type, by point
#pragma once

#include "src/core/attributes.h"
#include "src/core/stream_header.h"

namespace psplit::core {

inline constexpr uint32_t kMaxAttributeData = 128;

// A decoded stream. Its arrays lie in the arena it was decoded with, and in the stream's own bytes: both must
// outlive it.
template <typename Index>
struct Patch {
  uint32_t face_count = 0, point_count = 0;
  // The point at corner 4 * face + k. Where no attribute has seams points are the vertices.
  View<Index> point_at;
  View<Index> corner_of_point;  // one of the point's corners; empty where points are vertices
  View<Group<Index>> groups;
  View<Attribute<Index>> attributes;
  // Of an Edgebreaker mesh, else empty.
  Connectivity<Index> mesh;
  View<bool> on_seam;  // by vertex: at the end of some attribute's seam; empty without seams

  // Writes an attribute's values by point; see ValueWriter.
  template <bool kAligned = false, Lanes L, typename PlaceOf>
  PSPLIT_HD void write_values(L lanes, const Attribute<Index>& attribute, DataType type,
                              PlaceOf place_of) const {
    const ValueWriter<Index> writer(attribute, type);
    const Group<Index>& group = groups[attribute.group];
    const bool is_raw = attribute.coding == Coding::kRaw;
    if (corner_of_point.empty() && !is_raw)
      return writer.template write<kAligned>(
          lanes, point_count, [](uint32_t point) { return point; }, place_of);
    writer.template write<kAligned>(
        lanes, point_count,
        [&](uint32_t point) -> uint32_t {
          const uint32_t vertex =
              corner_of_point.empty() ? point : group.table.table.vertex[corner_of_point[point]];
          return is_raw ? group.sequence.rank[vertex] : vertex;
        },
        place_of);
  }
  template <typename PlaceOf>
  PSPLIT_HD void write_values(const Attribute<Index>& attribute, PlaceOf place_of) const {
    write_values(SerialLanes(), attribute, attribute.type, place_of);
  }
};

// Decodes a patch and stops before each of the long chains of dependent steps, so that a driver may take those
// of several attributes and several patches in step:
//
//   Fault fault = decoder.start();
//   while (fault == Fault::kNone && decoder.stop() != Stop::kDone) {
//     ... take all steps of what is pending
//     fault = decoder.resume(lanes);
//   }
enum class Stop : uint8_t {
  kSymbolLists,  // sequences(), of a valence traversal's symbols, are pending
  kSeams,        // seams() are pending
  kChains,       // sequences() and traversals() are pending
  kPrediction,   // of_three(), of_two() and normals() of integers() are
  kDone,
};

template <typename Index>
class PatchDecoder {
 public:
  PSPLIT_HD PatchDecoder(const StreamHeader& header, Arena& arena, Patch<Index>& out)
      : header_(header), reader_(header.body), arena_(arena), patch_(out), mesh_(out.mesh) {}

  PSPLIT_HD Fault start() {
    patch_.face_count = header_.counts.face_count;
    if (header_.edgebreaker) return start_edgebreaker();
    const Fault fault = decode_sequential_faces();
    return fault == Fault::kNone ? start_attributes() : fault;
  }

  PSPLIT_HD Stop stop() const { return stop_; }
  PSPLIT_HD View<BitSteps> seams() const { return seam_steps_; }
  PSPLIT_HD View<SymbolSequence> sequences() const {
    return View<SymbolSequence>(sequences_.data() + first_pending_, sequence_count_ - first_pending_);
  }
  PSPLIT_HD View<DepthFirstTraversal<Index>> traversals() const { return traversals_.first(traversal_count_); }
  PSPLIT_HD View<IntegerDecoder<Index>> integers() const { return integers_; }

  // All steps are taken, but for what sequences leave to their finish: goes on to the next stop. Collective:
  // the decoder is everybody's.
  template <Lanes L>
  PSPLIT_HD Fault resume(L lanes) {
    const Stop stop = stop_;
    lanes.sync();
    switch (stop) {
      case Stop::kSymbolLists: return alone(lanes, [&] { return finish_edgebreaker(); });
      case Stop::kSeams: return alone(lanes, [&] { return finish_seams(); });
      case Stop::kChains: return finish_chains(lanes);
      case Stop::kPrediction: return alone(lanes, [&] { return finish_predictions(); });
      case Stop::kDone: break;
    }
    return Fault::kNone;
  }

  // What the first lane does alone.
  template <Lanes L, typename Do>
  PSPLIT_HD static Fault alone(L lanes, Do what) {
    const Fault fault = lanes.rank() == 0 ? what() : Fault::kNone;
    lanes.sync();
    return static_cast<Fault>(broadcast(lanes, static_cast<uint32_t>(fault), 0));
  }

 private:
  PSPLIT_HD Fault stop_at(Stop stop) {
    stop_ = stop;
    return Fault::kNone;
  }

  PSPLIT_HD Fault start_edgebreaker() {
    const ConnectivityCounts& counts = header_.counts;
    if (header_.attribute_data_count > kMaxAttributeData) return Fault::kAttribute;
    mesh_.counts = counts;
    if (!mesh_.allocate(arena_)) return Fault::kWorkspace;
    connectivity_mark_ = arena_.mark();
    if (const Fault fault = read_split_events(); fault != Fault::kNone) return fault;
    if (!header_.valence) {
      const uint64_t size = reader_.varint64();
      symbol_bits_ = BitReader(reader_.head(), reader_.remaining());
      if (!reader_.skip(size)) return Fault::kTruncated;
    }
    if (const Fault fault = start_faces_.start(reader_); fault != Fault::kNone) return fault;
    for (uint32_t i = 0; i < header_.attribute_data_count; ++i)
      if (const Fault fault = seam_bits_[i].start(reader_); fault != Fault::kNone) return fault;
    if (!header_.valence) return finish_edgebreaker();
    if (!arena_.take(sequences_, valence_symbols_.kLists)) return Fault::kWorkspace;
    sequence_count_ = valence_symbols_.kLists;
    const Fault fault = valence_symbols_.start(reader_, counts, arena_, sequences_);
    return fault == Fault::kNone ? stop_at(Stop::kSymbolLists) : fault;
  }

  PSPLIT_HD Fault finish_edgebreaker() {
    Fault fault = Fault::kNone;
    if (header_.valence) {
      fault = valence_symbols_.finish(reader_, sequences_);
      if (fault == Fault::kNone)
        fault = decode_connectivity(valence_symbols_, events_, start_faces_, arena_, mesh_);
    } else {
      fault = decode_connectivity(StandardSymbols(symbol_bits_), events_, start_faces_, arena_, mesh_);
    }
    if (fault != Fault::kNone) return fault;
    mesh_.drop_merged_vertices(/*keep_order=*/header_.attribute_data_count > 0);
    arena_.release(connectivity_mark_);
    patch_.point_at = mesh_.table.vertex;
    patch_.point_count = mesh_.vertex_count;
    return header_.attribute_data_count > 0 ? start_seams() : start_attributes();
  }

  PSPLIT_HD Fault start_seams() {
    const uint32_t count = header_.attribute_data_count;
    if (!arena_.take(seam_tables_, count) || !arena_.take(seam_steps_, count) ||
        !arena_.take(inner_edges_, size_t{3} * patch_.face_count))
      return Fault::kWorkspace;
    const uint32_t edge_count = list_inner_edges(mesh_.table, inner_edges_);
    inner_edges_ = inner_edges_.first(edge_count);
    if (!arena_.take(seams_, size_t{count} * edge_count)) return Fault::kWorkspace;
    for (uint32_t i = 0; i < count; ++i) seam_steps_[i] = BitSteps(seam_bits_[i], seams_of(i));
    return stop_at(Stop::kSeams);
  }
  PSPLIT_HD View<uint8_t> seams_of(uint32_t attribute_data) const {
    return View<uint8_t>(seams_.data() + size_t{attribute_data} * inner_edges_.size(), inner_edges_.size());
  }

  PSPLIT_HD Fault finish_seams() {
    bool any_seams = false;
    View<bool> on_seam;
    View<Index> scratch;
    if (!arena_.take(on_seam, mesh_.vertex_count) || !arena_.take(patch_.on_seam, mesh_.vertex_count) ||
        !arena_.take(scratch, mesh_.vertex_count))
      return Fault::kWorkspace;
    fill(patch_.on_seam, false);
    for (uint32_t i = 0; i < header_.attribute_data_count; ++i) {
      AttributeTable<Index>& table = seam_tables_[i];
      const Fault fault = cut_seams(mesh_, inner_edges_, seams_of(i), arena_, table, on_seam);
      if (fault != Fault::kNone) return fault;
      if (!table.has_seams) continue;
      any_seams = true;
      number_attribute_vertices(mesh_, on_seam, scratch, table);
      for (size_t v = 0; v < on_seam.size(); ++v) patch_.on_seam[v] |= on_seam[v];
    }
    if (!any_seams) return start_attributes();
    if (!arena_.take(patch_.point_at, mesh_.table.vertex.size())) return Fault::kWorkspace;
    patch_.point_count = split_into_points(mesh_, seam_tables_, patch_.on_seam, scratch, patch_.point_at);
    if (!arena_.take(patch_.corner_of_point, patch_.point_count)) return Fault::kWorkspace;
    for (uint32_t face = 0; face < patch_.face_count; ++face)
      for (uint32_t corner = 4 * face; corner < 4 * face + 3; ++corner)
        patch_.corner_of_point[patch_.point_at[corner]] = static_cast<Index>(corner);
    return start_attributes();
  }

  PSPLIT_HD Fault read_split_events() {
    const ConnectivityCounts& counts = header_.counts;
    if (!arena_.take(events_, counts.split_count)) return Fault::kWorkspace;
    uint64_t source = 0;
    for (SplitEvent* event = events_.data(); event != events_.data() + events_.size(); ++event) {
      source += reader_.varint();
      const uint64_t back = reader_.varint();
      if (reader_.truncated()) return Fault::kTruncated;
      if (source >= counts.symbol_count || back > source) return Fault::kSplitEvent;
      // Encoders count from the other end.
      event->source = static_cast<uint32_t>(counts.symbol_count - 1 - source);
      event->split = static_cast<uint32_t>(counts.symbol_count - 1 - (source - back));
    }
    if (counts.split_count == 0) return Fault::kNone;
    BitReader edges(reader_.head(), reader_.remaining());
    for (SplitEvent* event = events_.data(); event != events_.data() + events_.size(); ++event)
      event->right_edge = edges.read(1);
    return reader_.skip(edges.bytes_taken()) ? Fault::kNone : Fault::kTruncated;
  }

  PSPLIT_HD Fault decode_sequential_faces() {
    const uint32_t index_count = 3 * patch_.face_count;
    patch_.point_count = header_.point_count;
    if (!arena_.take(patch_.point_at, size_t{4} * patch_.face_count)) return Fault::kWorkspace;
    bool in_range = true;
    const auto store = [&](uint32_t i, uint64_t point) {
      in_range &= point < patch_.point_count;
      patch_.point_at[4 * (i / 3) + i % 3] = static_cast<Index>(point);
    };
    const uint8_t plain = reader_.u8();
    if (plain == 0) {
      int64_t last = 0;
      const Fault fault = decode_symbols(reader_, index_count, arena_, [&](uint32_t i, uint32_t symbol) {
        last += (symbol & 1) != 0 ? -int64_t{symbol >> 1} : int64_t{symbol >> 1};
        if (last < 0) in_range = false, last = 0;
        store(i, static_cast<uint64_t>(last));
      });
      if (fault != Fault::kNone) return fault;
    } else {
      // In as many bytes as the number of points takes; for some it is a varint.
      const uint32_t points = patch_.point_count;
      for (uint32_t i = 0; i < index_count && !reader_.truncated(); ++i)
        store(i, points < 1u << 8    ? reader_.u8()
                 : points < 1u << 16 ? reader_.u16()
                 : points < 1u << 21 ? reader_.varint()
                                     : reader_.u32());
    }
    if (reader_.truncated()) return Fault::kTruncated;
    if (!in_range) return Fault::kIndex;
    // Values lie in the order of points.
    View<Index> identity;
    if (!arena_.take(identity, patch_.point_count)) return Fault::kWorkspace;
    for (uint32_t i = 0; i < patch_.point_count; ++i) identity[i] = static_cast<Index>(i);
    linear_.table.vertex = identity;
    linear_.vertex_count = patch_.point_count;
    linear_sequence_ = {identity, identity, patch_.point_count};
    return Fault::kNone;
  }

  // What attributes there are, and how their values are ordered.
  PSPLIT_HD Fault start_attributes() {
    const uint32_t group_count = reader_.u8();
    if (reader_.truncated()) return Fault::kTruncated;
    if (group_count > kMaxAttributeData + 1) return Fault::kAttribute;
    // Descriptions take more bytes than this.
    const size_t most = reader_.remaining() / 4 < kMaxAttributes ? reader_.remaining() / 4 : kMaxAttributes;
    if (!arena_.take(patch_.groups, group_count) || !arena_.take(traversals_, group_count) ||
        !arena_.take(patch_.attributes, most))
      return Fault::kWorkspace;
    if (const Fault fault = read_groups(); fault != Fault::kNone) return fault;
    uint32_t attribute_count = 0;
    for (uint32_t g = 0; g < group_count; ++g) {
      const Fault fault = read_descriptions(reader_, static_cast<uint8_t>(g), patch_.groups[g],
                                            patch_.attributes, attribute_count);
      if (fault != Fault::kNone) return fault;
    }
    arena_.trim(patch_.attributes, attribute_count);
    if (!arena_.take(sequences_, attribute_count) || !arena_.take(integers_, attribute_count))
      return Fault::kWorkspace;
    for (uint32_t i = 0; i < attribute_count; ++i) integers_[i] = {};
    sequence_count_ = 0;
    for (Group<Index>* group = patch_.groups.data(); group != patch_.groups.data() + group_count; ++group)
      if (const Fault fault = find_sequence(*group); fault != Fault::kNone) return fault;
    return read_attributes();
  }

  PSPLIT_HD Fault read_groups() {
    bool has_shared = false;
    for (Group<Index>* group = patch_.groups.data(); group != patch_.groups.data() + patch_.groups.size();
         ++group) {
      *group = {};
      if (!header_.edgebreaker) continue;
      group->attribute_data = static_cast<int8_t>(reader_.u8());
      group->per_corner = reader_.u8() != 0;
      const uint8_t traversal = reader_.u8();
      if (reader_.truncated()) return Fault::kTruncated;
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

  // Finds the group's table and sequence; depth-first traversals are left to be made.
  PSPLIT_HD Fault find_sequence(Group<Index>& group) {
    if (!header_.edgebreaker) {
      group.table = linear_;
      group.sequence = linear_sequence_;
      return Fault::kNone;
    }
    group.table = group.per_corner
                      ? seam_tables_[static_cast<size_t>(group.attribute_data)]
                      : AttributeTable<Index>{mesh_.table, mesh_.closed, mesh_.vertex_count, false};
    // The same walk over the same table need not be walked again.
    for (const Group<Index>* other = patch_.groups.data(); other != &group; ++other) {
      if (group.table.has_seams || other->table.has_seams ||
          other->by_prediction_degree != group.by_prediction_degree)
        continue;
      group.sequence = other->sequence;
      return Fault::kNone;
    }
    if (!group.sequence.allocate(group.table.vertex_count, arena_)) return Fault::kWorkspace;
    if (group.by_prediction_degree) return traverse_by_prediction_degree(group.table, arena_, group.sequence);
    traversals_[traversal_count_] = {};
    return traversals_[traversal_count_++].start(group.table, arena_, group.sequence);
  }

  // Reads on, from group_ and attribute_, to the end, or to symbols that must be known to read on.
  PSPLIT_HD Fault read_attributes() {
    const uint32_t corner_limit = 3 * patch_.face_count;
    for (; group_ < patch_.groups.size(); ++group_) {
      const Group<Index>& group = patch_.groups[group_];
      const uint32_t end = group.first + group.count;
      for (; attribute_ < end; ++attribute_) {
        Attribute<Index>& attribute = patch_.attributes[attribute_];
        if (attribute.coding == Coding::kRaw) {
          attribute.raw = reader_.head();
          if (!reader_.skip(uint64_t{attribute.stride()} * group.sequence.count)) return Fault::kTruncated;
          continue;
        }
        IntegerDecoder<Index>& integers = integers_[attribute_];
        Fault fault = Fault::kNone;
        if (!tags_are_known_) {
          SymbolSequence& symbols = sequences_[sequence_count_++];
          symbols = {};
          const Attribute<Index>* position = find_position(attribute_);
          fault = integers.start(reader_, header_.edgebreaker, group, attribute,
                                 position != nullptr ? &patch_.groups[position->group] : nullptr, position,
                                 arena_, symbols);
          tags_are_known_ = symbols.is_tagged();
          if (fault != Fault::kNone || symbols.is_tagged())
            return fault == Fault::kNone ? stop_at(Stop::kChains) : fault;
        }
        tags_are_known_ = false;
        fault = integers.read_prediction(reader_, corner_limit, arena_);
        if (fault != Fault::kNone) return fault;
      }
      for (uint32_t i = group.first; i < end; ++i)
        if (const Fault fault = read_transform(reader_, patch_.attributes[i]); fault != Fault::kNone)
          return fault;
    }
    return stop_at(Stop::kChains);
  }

  template <Lanes L>
  PSPLIT_HD Fault finish_chains(L lanes) {
    Fault fault = alone(lanes, [&] { return finish_traversals(); });
    const uint32_t first = first_pending_, end = sequence_count_;
    for (uint32_t i = first; i < end && fault == Fault::kNone; ++i)
      fault = sequences_[i].finish(lanes, reader_);
    if (fault != Fault::kNone) return fault;
    const bool is_last = group_ == patch_.groups.size();
    lanes.sync();
    if (!is_last)
      return alone(lanes, [&] {
        first_pending_ = end;
        return read_attributes();
      });
    for (uint32_t i = 0; i < integers_.size(); ++i)
      if (patch_.attributes[i].coding != Coding::kRaw) integers_[i].start_prediction(lanes);
    return alone(lanes, [&] { return stop_at(Stop::kPrediction); });
  }
  PSPLIT_HD Fault finish_traversals() {
    for (; traversal_count_ > 0; --traversal_count_)
      if (const Fault fault = traversals_[traversal_count_ - 1].finish(); fault != Fault::kNone) return fault;
    return Fault::kNone;
  }

  PSPLIT_HD Fault finish_predictions() {
    for (uint32_t i = 0; i < integers_.size(); ++i) {
      if (patch_.attributes[i].coding == Coding::kRaw) continue;
      if (const Fault fault = integers_[i].finish(arena_); fault != Fault::kNone) return fault;
    }
    return stop_at(Stop::kDone);
  }

  // The first attribute of positions, if it is decoded before this one.
  PSPLIT_HD const Attribute<Index>* find_position(uint32_t before) const {
    for (uint32_t i = 0; i < before; ++i)
      if (patch_.attributes[i].semantic == Attribute<Index>::kPosition) return &patch_.attributes[i];
    return nullptr;
  }

  const StreamHeader& header_;
  ByteReader reader_;
  Arena& arena_;
  Patch<Index>& patch_;
  Stop stop_ = Stop::kDone;

  Connectivity<Index>& mesh_;
  size_t connectivity_mark_ = 0;
  View<SplitEvent> events_;
  BitReader symbol_bits_;
  ValenceSymbols<Index> valence_symbols_;
  RansBits start_faces_, seam_bits_[kMaxAttributeData];

  View<Index> inner_edges_;
  View<uint8_t> seams_;  // by attribute data and edge
  View<BitSteps> seam_steps_;
  View<AttributeTable<Index>> seam_tables_;
  AttributeTable<Index> linear_;
  Sequence<Index> linear_sequence_;

  bool tags_are_known_ = false;
  uint32_t group_ = 0, attribute_ = 0;
  View<DepthFirstTraversal<Index>> traversals_;
  uint32_t traversal_count_ = 0;
  View<SymbolSequence> sequences_;
  uint32_t first_pending_ = 0, sequence_count_ = 0;
  View<IntegerDecoder<Index>> integers_;
};

// Calls take(runs, count) for all runs of some decoders, so many at a time: of(item) is the run of one of the
// items of list_of(decoder).
template <typename Run, typename Decoder, typename ListOf, typename Of, typename Take>
PSPLIT_HD void for_runs(Decoder* const* decoders, uint32_t decoder_count, ListOf list_of, Of of, Take take) {
  constexpr uint32_t kMost = 16;
  Run* runs[kMost] = {};
  uint32_t count = 0;
  for (uint32_t n = 0; n < decoder_count; ++n) {
    const auto list = list_of(*decoders[n]);
    for (size_t i = 0; i < list.size(); ++i) {
      runs[count++] = &of(list[i]);
      if (count < kMost) continue;
      take(runs, count);
      count = 0;
    }
  }
  take(runs, count);
}

// A traversal and a sequence of symbols in turn, until either ends. There are about two symbols for each step
// of the traversal: half as many vertices as faces, and three components each.
template <typename Index>
PSPLIT_HD void step_both(DepthFirstTraversal<Index>& traversal, SymbolSequence& sequence) {
  const auto step = [&]<typename Symbols>(Symbols symbols) {
    DepthFirstTraversal<Index> walk = traversal;
    while (walk.running() && (symbols.steps_left() >= 2 || symbols.renew()) && symbols.steps_left() >= 2) {
      walk.step();
      symbols.step();
      symbols.step();
    }
    traversal = walk;
    sequence = symbols;
  };
  if (sequence.is_direct())
    step(SymbolSteps<true>(sequence));
  else
    step(SymbolSteps<false>(sequence));
}

// Takes all pending steps of decoders that are at the same stop, those of kInStep runs in turn.
template <typename Index>
PSPLIT_HD void take_steps(PatchDecoder<Index>* const* decoders, uint32_t count) {
  using Decoder = PatchDecoder<Index>;
  using Integers = IntegerDecoder<Index>;
  const auto itself = [](auto& run) -> auto& { return run; };
  const auto sequences = [](Decoder& decoder) { return decoder.sequences(); };
  const auto integers = [](Decoder& decoder) { return decoder.integers(); };
  switch (decoders[0]->stop()) {
    case Stop::kSeams:
      for_runs<BitSteps>(
          decoders, count, [](Decoder& decoder) { return decoder.seams(); }, itself,
          step_all<kInStep, BitSteps, BitSteps>);
      return;
    case Stop::kSymbolLists:
      for_runs<SymbolSequence>(decoders, count, sequences, itself, step_symbols<kInStep>);
      return;
    case Stop::kChains: {
      using Run = DepthFirstTraversal<Index>;
      const auto traversals = [](Decoder& decoder) { return decoder.traversals(); };
      // One of each has nobody but the other to go with.
      if (count == 1 && traversals(*decoders[0]).size() == 1 && sequences(*decoders[0]).size() == 1)
        step_both(traversals(*decoders[0])[0], sequences(*decoders[0])[0]);
      for_runs<SymbolSequence>(decoders, count, sequences, itself, step_symbols<kInStep>);
      for_runs<Run>(decoders, count, traversals, itself, step_all<kInStep, Run, Run>);
      return;
    }
    case Stop::kPrediction: {
      using OfThree = ParallelogramSteps<Index, 3>;
      using OfTwo = ParallelogramSteps<Index, 2>;
      using Normals = NormalSteps<Index>;
      for_runs<OfThree>(
          decoders, count, integers, [](Integers & of) -> auto& { return of.of_three(); },
          step_all<kInStep, OfThree, OfThree>);
      for_runs<OfTwo>(
          decoders, count, integers, [](Integers & of) -> auto& { return of.of_two(); },
          step_all<kInStep, OfTwo, OfTwo>);
      for_runs<Normals>(
          decoders, count, integers, [](Integers & of) -> auto& { return of.normals(); },
          step_all<kInStep, Normals, Normals>);
      return;
    }
    case Stop::kDone: return;
  }
}

// Decodes the streams of several decoders, none of them started; faults[n] is the n-th's.
template <uint32_t kCount, typename Index>
PSPLIT_HD void decode_in_step(PatchDecoder<Index>* const (&decoders)[kCount], Fault (&faults)[kCount]) {
  for (uint32_t n = 0; n < kCount; ++n) faults[n] = decoders[n]->start();
  for (;;) {
    // Like streams make like stops; others wait for their turn.
    PatchDecoder<Index>* at[kCount];
    Fault* fault_of[kCount];
    uint32_t count = 0;
    for (uint32_t n = 0; n < kCount; ++n) {
      if (faults[n] != Fault::kNone || decoders[n]->stop() == Stop::kDone) continue;
      if (count > 0 && decoders[n]->stop() != at[0]->stop()) continue;
      at[count] = decoders[n];
      fault_of[count++] = &faults[n];
    }
    if (count == 0) return;
    take_steps(at, count);
    for (uint32_t n = 0; n < count; ++n) *fault_of[n] = at[n]->resume(SerialLanes());
  }
}

// How many runs of steps a decoder waits for, and all steps of one of them: for those who step each run apart.
template <typename Index>
PSPLIT_HD uint32_t pending_runs(const PatchDecoder<Index>& decoder) {
  switch (decoder.stop()) {
    case Stop::kSeams: return static_cast<uint32_t>(decoder.seams().size());
    case Stop::kSymbolLists:
    case Stop::kChains: return static_cast<uint32_t>(decoder.sequences().size() + decoder.traversals().size());
    case Stop::kPrediction: return static_cast<uint32_t>(decoder.integers().size());
    case Stop::kDone: break;
  }
  return 0;
}
template <typename Index>
PSPLIT_HD void take_run(const PatchDecoder<Index>& decoder, uint32_t number) {
  const auto step_through = []<typename Run>(Run& run) {
    Run* const one = &run;
    step_all<1, Run>(&one, 1);
  };
  switch (decoder.stop()) {
    case Stop::kSeams: return step_through(decoder.seams()[number]);
    case Stop::kSymbolLists:
    case Stop::kChains: {
      const View<SymbolSequence> sequences = decoder.sequences();
      if (number >= sequences.size()) return step_through(decoder.traversals()[number - sequences.size()]);
      SymbolSequence* const one = &sequences[number];
      return step_symbols<1>(&one, 1);
    }
    case Stop::kPrediction: {
      IntegerDecoder<Index>& integers = decoder.integers()[number];
      step_through(integers.of_three());
      step_through(integers.of_two());
      return step_through(integers.normals());
    }
    case Stop::kDone: return;
  }
}

// From the stop at which a decoder is to the end, with all lanes of a warp, a run a lane. The decoder is
// everybody's. Collective.
template <Lanes L, typename Index>
PSPLIT_HD Fault finish_together(L lanes, PatchDecoder<Index>& decoder) {
  Fault fault = Fault::kNone;
  while (fault == Fault::kNone && decoder.stop() != Stop::kDone) {
    for_each_lane_item(lanes, pending_runs(decoder), [&](uint32_t run) { take_run(decoder, run); });
    lanes.sync();
    fault = decoder.resume(lanes);
  }
  return fault;
}
// The same from the start.
template <Lanes L, typename Index>
PSPLIT_HD Fault decode_together(L lanes, PatchDecoder<Index>& decoder) {
  const Fault fault = decoder.alone(lanes, [&] { return decoder.start(); });
  return fault == Fault::kNone ? finish_together(lanes, decoder) : fault;
}

// Decodes a stream whose header was read, and for which Index is wide enough (StreamHeader::fits_16_bits). The
// bytes may be anything: what is wrong with them comes back as a fault, and nothing outside of them and the
// arena is touched. Safe to call from many threads with arenas of their own.
template <typename Index>
PSPLIT_HD Fault decode_patch(const StreamHeader& header, Arena& arena, Patch<Index>& out) {
  PatchDecoder<Index> decoder(header, arena, out);
  PatchDecoder<Index>* const one[1] = {&decoder};
  Fault fault[1];
  decode_in_step(one, fault);
  return fault[0];
}

}  // namespace psplit::core
