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
  Group<Index> groups[kMaxAttributeData + 1];
  uint32_t group_count = 0;
  Attribute<Index> attributes[kMaxAttributes];
  uint32_t attribute_count = 0;
  // Of an Edgebreaker mesh, else empty.
  Connectivity<Index> mesh;

  // Writes an attribute's values by point; see ValueWriter.
  template <typename PlaceOf>
  PSPLIT_HD void write_values(const Attribute<Index>& attribute, PlaceOf place_of) const {
    const ValueWriter<Index> writer(attribute);
    const Group<Index>& group = groups[attribute.group];
    const bool is_raw = attribute.coding == Coding::kRaw;
    if (corner_of_point.empty() && !is_raw)
      return writer.write(
          point_count, [](uint32_t point) { return point; }, place_of);
    writer.write(
        point_count,
        [&](uint32_t point) -> uint32_t {
          const uint32_t vertex =
              corner_of_point.empty() ? point : group.table.table.vertex[corner_of_point[point]];
          return is_raw ? group.sequence.rank[vertex] : vertex;
        },
        place_of);
  }
};

// Decodes a patch and stops before each of the long chains of dependent steps, so that a driver may take those
// of several patches in step:
//
//   Fault fault = decoder.start();
//   while (fault == Fault::kNone && decoder.stop() != Stop::kDone) fault = decoder.resume();
enum class Stop : uint8_t {
  kTraversal,   // steps of traversal() may be taken before resume
  kSymbols,     // symbols of integers() may be decoded before resume
  kPrediction,  // steps of integers() may be taken before resume
  kDone,
};

template <typename Index>
class PatchDecoder {
 public:
  PSPLIT_HD PatchDecoder(const StreamHeader& header, Arena& arena, Patch<Index>& out)
      : header_(header), reader_(header.body), arena_(arena), patch_(out), mesh_(out.mesh) {}

  PSPLIT_HD Fault start() {
    patch_.face_count = header_.counts.face_count;
    Fault fault = header_.edgebreaker ? decode_edgebreaker() : decode_sequential_faces();
    if (fault == Fault::kNone) fault = read_groups();
    return fault == Fault::kNone ? advance() : fault;
  }

  PSPLIT_HD Stop stop() const { return stop_; }
  PSPLIT_HD DepthFirstTraversal<Index>& traversal() { return traversal_; }
  PSPLIT_HD IntegerDecoder<Index>& integers() { return integers_; }

  // Takes the steps that are left, and goes on to the next stop.
  PSPLIT_HD Fault resume() {
    Fault fault = Fault::kNone;
    if (stop_ == Stop::kTraversal) {
      DepthFirstTraversal<Index> traversal = traversal_;  // a copy of its own may live in registers
      while (traversal.running()) traversal.step();
      traversal.finish(arena_, patch_.groups[group_].sequence);
    } else if (stop_ == Stop::kSymbols) {
      stop_ = Stop::kPrediction;
      return integers_.finish_symbols(reader_, 3 * patch_.face_count, arena_);
    } else if (stop_ == Stop::kPrediction) {
      fault = integers_.finish(arena_);
      ++attribute_;
    }
    return fault == Fault::kNone ? advance() : fault;
  }

 private:
  PSPLIT_HD Fault decode_edgebreaker() {
    const ConnectivityCounts& counts = header_.counts;
    if (header_.attribute_data_count > kMaxAttributeData) return Fault::kAttribute;
    mesh_.counts = counts;
    if (!mesh_.allocate(arena_)) return Fault::kWorkspace;
    View<SplitEvent> events;
    if (const Fault fault = read_split_events(events); fault != Fault::kNone) return fault;

    BitReader symbol_bits;
    if (!header_.valence) {
      const uint64_t size = reader_.varint64();
      symbol_bits = BitReader(reader_.head(), reader_.remaining());
      if (!reader_.skip(size)) return Fault::kTruncated;
    }
    RansBits start_faces, seams[kMaxAttributeData];
    if (const Fault fault = start_faces.start(reader_); fault != Fault::kNone) return fault;
    for (uint32_t i = 0; i < header_.attribute_data_count; ++i)
      if (const Fault fault = seams[i].start(reader_); fault != Fault::kNone) return fault;

    const View<const SplitEvent> read_only(events.data(), events.size());
    Fault fault = Fault::kNone;
    if (header_.valence) {
      ValenceSymbols<Index> symbols;
      fault = symbols.read(reader_, counts, arena_);
      if (fault == Fault::kNone) fault = decode_connectivity(symbols, read_only, start_faces, arena_, mesh_);
    } else {
      StandardSymbols symbols(symbol_bits);
      fault = decode_connectivity(symbols, read_only, start_faces, arena_, mesh_);
    }
    if (fault != Fault::kNone) return fault;
    mesh_.drop_merged_vertices(/*keep_order=*/header_.attribute_data_count > 0);

    patch_.point_at = mesh_.table.vertex;
    patch_.point_count = mesh_.vertex_count;
    if (header_.attribute_data_count == 0) return Fault::kNone;

    bool any_seams = false;
    View<bool> on_seam, on_any_seam;
    View<Index> scratch;
    if (!arena_.take(on_seam, mesh_.vertex_count) || !arena_.take(on_any_seam, mesh_.vertex_count) ||
        !arena_.take(scratch, mesh_.vertex_count))
      return Fault::kWorkspace;
    fill(on_any_seam, false);
    const auto read_only_marks = [](View<bool> marks) { return View<const bool>(marks.data(), marks.size()); };
    for (uint32_t i = 0; i < header_.attribute_data_count; ++i) {
      fault = decode_seams(mesh_, seams[i], arena_, seam_tables_[i], on_seam);
      if (fault != Fault::kNone) return fault;
      if (!seam_tables_[i].has_seams) continue;
      any_seams = true;
      number_attribute_vertices(mesh_, read_only_marks(on_seam), scratch, seam_tables_[i]);
      for (size_t v = 0; v < on_seam.size(); ++v) on_any_seam[v] |= on_seam[v];
    }
    if (!any_seams) return Fault::kNone;
    if (!arena_.take(patch_.point_at, mesh_.table.vertex.size())) return Fault::kWorkspace;
    const View<const AttributeTable<Index>> tables(seam_tables_, header_.attribute_data_count);
    patch_.point_count = number_points(mesh_, tables, read_only_marks(on_any_seam), scratch, patch_.point_at);
    if (!arena_.take(patch_.corner_of_point, patch_.point_count)) return Fault::kWorkspace;
    for (uint32_t face = 0; face < patch_.face_count; ++face)
      for (uint32_t corner = 4 * face; corner < 4 * face + 3; ++corner)
        patch_.corner_of_point[patch_.point_at[corner]] = static_cast<Index>(corner);
    return Fault::kNone;
  }

  PSPLIT_HD Fault read_split_events(View<SplitEvent>& events) {
    const ConnectivityCounts& counts = header_.counts;
    if (!arena_.take(events, counts.split_count)) return Fault::kWorkspace;
    uint64_t source = 0;
    for (SplitEvent* event = events.data(); event != events.data() + events.size(); ++event) {
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
    for (SplitEvent* event = events.data(); event != events.data() + events.size(); ++event)
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

  PSPLIT_HD Fault read_groups() {
    patch_.group_count = reader_.u8();
    if (reader_.truncated()) return Fault::kTruncated;
    if (patch_.group_count > kMaxAttributeData + 1) return Fault::kAttribute;
    bool has_shared = false;
    for (uint32_t g = 0; g < patch_.group_count && header_.edgebreaker; ++g) {
      Group<Index>& group = patch_.groups[g];
      group.attribute_data = static_cast<int8_t>(reader_.u8());
      group.per_corner = reader_.u8() != 0;
      const uint8_t traversal = reader_.u8();
      if (reader_.truncated()) return Fault::kTruncated;
      group.by_prediction_degree = traversal == 1;
      if (traversal > 1 || (group.per_corner && group.by_prediction_degree)) return Fault::kMethod;
      if (group.attribute_data < 0) {
        if (group.per_corner || has_shared) return Fault::kAttribute;
        has_shared = true;
        continue;
      }
      if (static_cast<uint32_t>(group.attribute_data) >= header_.attribute_data_count) return Fault::kAttribute;
      for (uint32_t other = 0; other < g; ++other)
        if (patch_.groups[other].attribute_data == group.attribute_data) return Fault::kAttribute;
    }
    for (uint32_t g = 0; g < patch_.group_count; ++g) {
      const Fault fault = read_descriptions(reader_, static_cast<uint8_t>(g), patch_.groups[g],
                                            patch_.attributes, patch_.attribute_count);
      if (fault != Fault::kNone) return fault;
    }
    return Fault::kNone;
  }

  // From where the last stop was to the next.
  PSPLIT_HD Fault advance() {
    for (; group_ < patch_.group_count; ++group_, in_group_ = false) {
      Group<Index>& group = patch_.groups[group_];
      const uint32_t end = group.first + group.count;
      if (!in_group_) {
        in_group_ = true;
        attribute_ = group.first;
        bool traverse = false;
        if (const Fault fault = find_sequence(group, traverse); fault != Fault::kNone) return fault;
        if (traverse) {
          stop_ = Stop::kTraversal;
          return Fault::kNone;
        }
      }
      for (; attribute_ < end; ++attribute_) {
        Attribute<Index>& attribute = patch_.attributes[attribute_];
        if (attribute.coding != Coding::kRaw) {
          stop_ = Stop::kSymbols;
          const Attribute<Index>* position = find_position(attribute_);
          return integers_.start(reader_, header_.edgebreaker, group, attribute,
                                 position != nullptr ? &patch_.groups[position->group] : nullptr, position,
                                 arena_);
        }
        attribute.raw = reader_.head();
        if (!reader_.skip(uint64_t{attribute.stride()} * group.sequence.count)) return Fault::kTruncated;
      }
      for (uint32_t i = group.first; i < end; ++i)
        if (const Fault fault = read_transform(reader_, patch_.attributes[i]); fault != Fault::kNone)
          return fault;
    }
    stop_ = Stop::kDone;
    return Fault::kNone;
  }

  // Finds the group's table and sequence, unless that takes a traversal that is left to be made.
  PSPLIT_HD Fault find_sequence(Group<Index>& group, bool& traverse) {
    if (!header_.edgebreaker) {
      group.table = linear_;
      group.sequence = linear_sequence_;
      return Fault::kNone;
    }
    group.table = group.per_corner
                      ? seam_tables_[group.attribute_data]
                      : AttributeTable<Index>{mesh_.table, mesh_.closed, mesh_.vertex_count, false};
    // The same walk over the same table need not be walked again.
    for (const Group<Index>* other = patch_.groups; other != &group; ++other) {
      if (group.table.has_seams || other->table.has_seams ||
          other->by_prediction_degree != group.by_prediction_degree)
        continue;
      group.sequence = other->sequence;
      return Fault::kNone;
    }
    if (group.by_prediction_degree) return traverse_by_prediction_degree(group.table, arena_, group.sequence);
    traverse = true;
    traversal_ = {};
    return traversal_.start(group.table, arena_, group.sequence);
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
  Connectivity<Index>& mesh_;
  AttributeTable<Index> seam_tables_[kMaxAttributeData];
  AttributeTable<Index> linear_;
  Sequence<Index> linear_sequence_;

  Stop stop_ = Stop::kDone;
  uint32_t group_ = 0, attribute_ = 0;
  bool in_group_ = false;
  DepthFirstTraversal<Index> traversal_;
  IntegerDecoder<Index> integers_;
};

// Decodes a stream whose header was read, and for which Index is wide enough (StreamHeader::fits_16_bits). The
// bytes may be anything: what is wrong with them comes back as a fault, and nothing outside of them and the
// arena is touched. Safe to call from many threads with arenas of their own.
template <typename Index>
PSPLIT_HD Fault decode_patch(const StreamHeader& header, Arena& arena, Patch<Index>& out) {
  PatchDecoder<Index> decoder(header, arena, out);
  Fault fault = decoder.start();
  while (fault == Fault::kNone && decoder.stop() != Stop::kDone) fault = decoder.resume();
  return fault;
}

// The same for the streams of several decoders, none of them started: their dependent steps are taken in turn,
// so that a processor works on one while it waits for another. faults[n] is the n-th's.
template <uint32_t kCount, typename Index>
PSPLIT_HD void decode_in_step(PatchDecoder<Index>* const (&decoders)[kCount], Fault (&faults)[kCount]) {
  for (uint32_t n = 0; n < kCount; ++n) faults[n] = decoders[n]->start();
  for (;;) {
    // Like streams make like stops. Where one of them is somewhere else, each goes on by itself.
    uint32_t live = 0, alike = 0;
    for (uint32_t n = 0; n < kCount; ++n) {
      live += faults[n] == Fault::kNone && decoders[n]->stop() != Stop::kDone;
      alike += faults[n] == Fault::kNone && decoders[n]->stop() == decoders[0]->stop();
    }
    if (live == 0) return;
    if (live == kCount && alike == kCount) {
      if (decoders[0]->stop() == Stop::kTraversal) {
        step_together<kCount>([&](uint32_t n) -> auto& { return decoders[n]->traversal(); });
      } else if (decoders[0]->stop() == Stop::kSymbols) {
        SymbolSequence* sequences[kCount];
        for (uint32_t n = 0; n < kCount; ++n) sequences[n] = &decoders[n]->integers().symbols();
        uint32_t direct = 0;
        for (const SymbolSequence* sequence : sequences) direct += sequence->is_direct();
        if (direct == kCount) decode_in_step<kCount, true>(sequences);
        if (direct == 0) decode_in_step<kCount, false>(sequences);
      } else {
#if defined(PSPLIT_HAS_VECTORS)
        step_together<kCount>([&](uint32_t n) -> auto& { return decoders[n]->integers().steps(); });
#endif
      }
    }
    for (uint32_t n = 0; n < kCount; ++n)
      if (faults[n] == Fault::kNone && decoders[n]->stop() != Stop::kDone) faults[n] = decoders[n]->resume();
  }
}

}  // namespace psplit::core
