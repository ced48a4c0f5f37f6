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
  CornerTable<Index> table;

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

template <typename Index>
class PatchDecoder {
 public:
  PSPLIT_HD PatchDecoder(const StreamHeader& header, Arena& arena, Patch<Index>& out)
      : header_(header), reader_(header.body), arena_(arena), patch_(out) {}

  PSPLIT_HD Fault decode() {
    patch_.face_count = header_.counts.face_count;
    Fault fault = header_.edgebreaker ? decode_edgebreaker() : decode_sequential_faces();
    if (fault == Fault::kNone) fault = read_groups();
    for (uint32_t g = 0; g < patch_.group_count && fault == Fault::kNone; ++g)
      fault = decode_group(patch_.groups[g]);
    return fault;
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

    bool any_seams = false;
    for (uint32_t i = 0; i < header_.attribute_data_count; ++i) {
      fault = decode_seams(mesh_, seams[i], arena_, seam_tables_[i]);
      if (fault == Fault::kNone) fault = number_attribute_vertices(mesh_, seam_tables_[i]);
      if (fault != Fault::kNone) return fault;
      any_seams |= seam_tables_[i].has_seams;
    }
    patch_.table = mesh_.table;
    patch_.point_at = mesh_.table.vertex;
    patch_.point_count = mesh_.vertex_count;
    if (!any_seams) return Fault::kNone;
    if (!arena_.take(patch_.point_at, mesh_.table.vertex.size())) return Fault::kWorkspace;
    number_points(mesh_, View<const AttributeTable<Index>>(seam_tables_, header_.attribute_data_count),
                  patch_.point_at, &patch_.point_count);
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
      const Fault fault = decode_symbols(reader_, index_count, 1, arena_, [&](uint32_t i, uint32_t symbol) {
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

  PSPLIT_HD Fault find_sequence(Group<Index>& group) {
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
    return group.by_prediction_degree ? traverse_by_prediction_degree(group.table, arena_, group.sequence)
                                      : traverse_depth_first(group.table, arena_, group.sequence);
  }

  PSPLIT_HD Fault decode_group(Group<Index>& group) {
    if (const Fault fault = find_sequence(group); fault != Fault::kNone) return fault;
    const uint32_t end = group.first + group.count;
    for (uint32_t i = group.first; i < end; ++i) {
      Attribute<Index>& attribute = patch_.attributes[i];
      if (attribute.coding == Coding::kRaw) {
        attribute.raw = reader_.head();
        if (!reader_.skip(uint64_t{attribute.stride()} * group.sequence.count)) return Fault::kTruncated;
        continue;
      }
      const Attribute<Index>* position = nullptr;
      for (uint32_t k = 0; k < i && position == nullptr; ++k)
        if (patch_.attributes[k].semantic == Attribute<Index>::kPosition) position = &patch_.attributes[k];
      const Fault fault =
          decode_integers(reader_, header_.edgebreaker, 3 * patch_.face_count, group, attribute,
                          position != nullptr ? &patch_.groups[position->group] : nullptr, position, arena_);
      if (fault != Fault::kNone) return fault;
    }
    for (uint32_t i = group.first; i < end; ++i)
      if (const Fault fault = read_transform(reader_, patch_.attributes[i]); fault != Fault::kNone)
        return fault;
    return Fault::kNone;
  }

  const StreamHeader& header_;
  ByteReader reader_;
  Arena& arena_;
  Patch<Index>& patch_;
  Connectivity<Index> mesh_;
  AttributeTable<Index> seam_tables_[kMaxAttributeData];
  AttributeTable<Index> linear_;
  Sequence<Index> linear_sequence_;
};

// Decodes a stream whose header was read, and for which Index is wide enough (StreamHeader::fits_16_bits). The
// bytes may be anything: what is wrong with them comes back as a fault, and nothing outside of them and the
// arena is touched. Safe to call from many threads with arenas of their own.
template <typename Index>
PSPLIT_HD Fault decode_patch(const StreamHeader& header, Arena& arena, Patch<Index>& out) {
  return PatchDecoder<Index>(header, arena, out).decode();
}

}  // namespace psplit::core
