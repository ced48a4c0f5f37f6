// The seams of a stream's attributes, and the points that follow from them (seams.h).
#pragma once

#include "src/core/condensed/seam_steps.h"
#include "src/core/patch.h"
#include "src/core/rans.h"
#include "src/core/seam_lanes.h"
#include "src/core/stream_header.h"

namespace psplit::core {

template <typename Index>
class SeamDecoder {
 public:
  // Takes the entropy-coded bits of `count` attribute data, at most kMaxAttributeData, from the reader.
  PSPLIT_HD Fault read(ByteReader& reader, uint32_t count) {
    count_ = count;
    for (uint32_t i = 0; i < count; ++i) {
      if (const Fault fault = bits_[i].start(reader); fault != Fault::kNone) return fault;
      if constexpr (!PSPLIT_MOVES_ROWS)
        find_same_before(
            i);  // a device decodes the bits of all attribute data side by side, so equal ones cost no time
    }
    return Fault::kNone;
  }

  // Makes the steps ready that decode a bit for each inner edge, when the mesh is known. Collective.
  template <Lanes L>
  PSPLIT_HD Fault start(L lanes, const Connectivity<Index>& mesh, Arena& arena) {
    if (const Fault fault = list_edges(lanes, mesh, arena); fault != Fault::kNone) return fault;
    return alone(lanes, [&] {
      if (!arena.take(steps_, count_)) return Fault::kWorkspace;
      uint32_t run_count = 0;
      for (uint32_t i = 0; i < count_; ++i)
        if (same_back_[i] == 0) steps_[run_count++] = BitSteps(bits_[i], seams_of(i));
      arena.trim(steps_, run_count);
      return Fault::kNone;
    });
  }
  PSPLIT_HD View<BitSteps> steps() const { return steps_; }

  // Starts for an encoder, which sets the bits of each edge itself.
  Fault start(uint32_t count, const Connectivity<Index>& mesh, Arena& arena) {
    count_ = count;
    return list_edges(SerialLanes(), mesh, arena);
  }
  View<const Index> edges() const { return inner_edges_; }

  // Starts for the `count` attribute data of a condensed stream. `section` is at the end of the symbols.
  // Collective.
  template <Lanes L>
  PSPLIT_HD Fault start(L lanes, const CondensedStream& stream, const SectionReader& section, uint32_t count,
                        const Connectivity<Index>& mesh, Arena& arena) {
    if (lanes.rank() == 0) count_ = count;
    SectionReader has_seams = stream.numbers(stream.seams_at);
    bool any_seams = false;
    for (uint32_t i = 0; i < count; ++i) any_seams |= has_seams.read(1) != 0;
    lanes.sync();
    // Without seams no edges are needed.
    const Fault fault =
        any_seams ? list_edges(lanes, mesh, arena) : alone(lanes, [&] { return take_tables(arena); });
    if (fault != Fault::kNone) return fault;
    fill(lanes, seams_.first(count * inner_edges_.size()), uint8_t{0});
    return alone(lanes, [&] {
      if (!arena.take(condensed_steps_, 1)) return Fault::kWorkspace;
      condensed_steps_[0] = {stream, section, count, seams_, inner_edges_.size()};
      return Fault::kNone;
    });
  }
  PSPLIT_HD View<CondensedSeamSteps> condensed_steps() const { return condensed_steps_; }

  // Cuts a table for each attribute data, and splits vertices into points, after all steps were taken.
  PSPLIT_HD Fault finish(Arena& arena, Patch<Index>& patch) {
    const Connectivity<Index>& mesh = patch.mesh;
    uint32_t same[kMaxAttributeData];
    AttributeTable<Index>* cut[kMaxAttributeData];  // the tables with seams, each of them once
    uint32_t cut_count = 0;
    View<Index> point_counts;
    if (!arena.take(patch.on_seam, mesh.vertex_count) || !arena.take(point_counts, mesh.vertex_count))
      return Fault::kWorkspace;
    fill(patch.on_seam, false);
    for (uint32_t i = 0; i < count_; ++i) {
      if ((same[i] = same_seams(SerialLanes(), i)) < i) continue;
      const Fault fault = cut_seams(mesh, inner_edges_, seams_of(i), arena, tables_[i], patch.on_seam);
      if (fault != Fault::kNone) return fault;
      if (tables_[i].has_seams) cut[cut_count++] = &tables_[i];
    }
    VertexSplit<Index> split(mesh, corner_room_, seams_, point_counts);
    if (cut_count > 0) {
      if (!arena.take(patch.point_at, mesh.table.vertex.size())) return Fault::kWorkspace;
      split.split(cut, cut_count, patch.on_seam, patch.point_at);
    }
    for (uint32_t i = 0; i < count_; ++i) tables_[i] = tables_[same[i]];
    arena.give_back(corner_room_);
    arena.give_back(seams_);
    if (cut_count > 0) {
      patch.point_count = split.count();
      if (!arena.take_for_good(patch.corner_of_point, patch.point_count)) return Fault::kWorkspace;
      split.store(patch.point_at, patch.corner_of_point);
    }
    arena.give_back(point_counts);
    return Fault::kNone;
  }
  // Finishes by all lanes together. Collective.
  template <Lanes L>
  PSPLIT_HD Fault finish(L lanes, Arena& arena, Patch<Index>& patch) {
    if constexpr (L::size() == 1) return finish(arena, patch);
    const Connectivity<Index>& mesh = patch.mesh;
    View<bool> on_seam;
    View<Index> scratch;
    if (!take(lanes, arena, on_seam, mesh.vertex_count) || !take(lanes, arena, scratch, mesh.vertex_count))
      return Fault::kWorkspace;
    fill(lanes, on_seam, false);
    bool any_seams = false;
    const uint32_t count = count_;
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t same = same_seams(lanes, i);
      if (same < i) {
        if (lanes.rank() == 0) tables_[i] = tables_[same];
        lanes.sync();
        continue;
      }
      bool has_seams = false;
      if (const Fault fault = cut_table(lanes, i, mesh, arena, on_seam, scratch, has_seams);
          fault != Fault::kNone)
        return fault;
      any_seams |= has_seams;
    }
    if (lanes.rank() == 0) patch.on_seam = on_seam;
    if (!any_seams) return lanes.sync(), Fault::kNone;
    const PointSplit<Index> split(mesh, tables_, on_seam, scratch);
    const uint32_t point_count = split.count(lanes);
    View<Index> point_at, corner_of_point;
    if (!take(lanes, arena, point_at, mesh.table.vertex.size()) ||
        !take(lanes, arena, corner_of_point, point_count))
      return Fault::kWorkspace;
    split.store(lanes, point_at, corner_of_point);
    if (lanes.rank() == 0)
      patch.point_at = point_at, patch.corner_of_point = corner_of_point, patch.point_count = point_count;
    lanes.sync();
    return Fault::kNone;
  }
  // The table of each attribute data.
  PSPLIT_HD View<AttributeTable<Index>> tables() const { return tables_; }
  // The bits of an attribute data, before `finish`. A condensed stream without any seams has none.
  PSPLIT_HD View<uint8_t> seams_of(uint32_t attribute_data) const {
    const size_t row = attribute_data - same_back_[attribute_data];
    return View<uint8_t>(seams_.data() + row * inner_edges_.size(), inner_edges_.size());
  }

  // The memory that `start` and `finish` take.
  PSPLIT_HD static size_t bytes(const StreamHeader& header, const ValueCounts& values) {
    const uint64_t count = header.attribute_data_count, faces = header.counts.face_count;
    const uint64_t vertices = header.counts.vertex_limit, inner_edges = 3 * faces / 2;
    return Arena::bytes<AttributeTable<Index>>(count) + Arena::bytes<BitSteps>(count) +
           (header.is_condensed() ? Arena::bytes<CondensedSeamSteps>(1) : 0) + Arena::bytes<Index>(3 * faces) +
           Arena::bytes<uint8_t>(seam_room(count, inner_edges, faces)) + Arena::bytes<bool>(vertices) +
           Arena::bytes<Index>(vertices) + count * AttributeTable<Index>::bytes(header.counts.face_count) +
           Arena::bytes<Index>(4 * faces) + Arena::bytes<Index>(values.points);
  }

 private:
  static constexpr uint32_t kMostLookedAt = 4;  // attribute data before one, in search of the same seams

  // Finds attribute data before these whose bits are the same.
  PSPLIT_HD void find_same_before(uint32_t i) {
    for (uint32_t back = 1; back <= kMostLookedAt && back <= i && same_back_[i] == 0; ++back)
      if (bits_[i].is_same(bits_[i - back])) same_back_[i] = static_cast<uint8_t>(back + same_back_[i - back]);
  }
  PSPLIT_HD static uint64_t seam_room(uint64_t count, uint64_t edges, uint64_t faces) {
    return count * edges > 3 * faces ? count * edges : 3 * faces;
  }
  PSPLIT_HD Fault take_tables(Arena& arena) {
    return arena.take(tables_, count_) ? Fault::kNone : Fault::kWorkspace;
  }
  template <Lanes L>
  PSPLIT_HD Fault list_edges(L lanes, const Connectivity<Index>& mesh, Arena& arena) {
    const Fault fault = alone(lanes, [&] {
      if (const Fault of_tables = take_tables(arena); of_tables != Fault::kNone) return of_tables;
      const bool is_taken = arena.take(corner_room_, uint64_t{3} * mesh.counts.face_count);
      return is_taken ? Fault::kNone : Fault::kWorkspace;
    });
    if (fault != Fault::kNone) return fault;
    const uint32_t edge_count = list_inner_edges(lanes, mesh.table, corner_room_);
    return alone(lanes, [&] {
      inner_edges_ = corner_room_.first(edge_count);
      return arena.take(seams_, seam_room(count_, edge_count, mesh.counts.face_count)) ? Fault::kNone
                                                                                       : Fault::kWorkspace;
    });
  }
  // Attribute data before this one with the same seams, and so with the same table and the same walk over it;
  // this one if there are none. It looks at few, so that no stream makes it look at thousands. Collective.
  template <Lanes L>
  PSPLIT_HD uint32_t same_seams(L lanes, uint32_t attribute_data) const {
    if (same_back_[attribute_data] > 0) return attribute_data - same_back_[attribute_data];
    const auto bytes = static_cast<uint32_t>(inner_edges_.size());
    const View<const uint8_t> bits = seams_of(attribute_data);
    for (uint32_t i = attribute_data > kMostLookedAt ? attribute_data - kMostLookedAt : 0; i < attribute_data;
         ++i) {
      const View<const uint8_t> others = seams_of(i);
      bool differs = false;
      if constexpr (L::size() == 1)
        differs = bytes > 0 && !equal_bytes(bits.data(), others.data(), bytes);
      else
        for_each_lane_item(lanes, bytes, [&](uint32_t edge) { differs |= bits[edge] != others[edge]; });
      if (!any(lanes, differs)) return i;
    }
    return attribute_data;
  }
  // Makes the table of an attribute data. Collective.
  template <Lanes L>
  PSPLIT_HD Fault cut_table(L lanes, uint32_t attribute_data, const Connectivity<Index>& mesh, Arena& arena,
                            View<bool> on_seam, View<Index> scratch, bool& has_seams) {
    const View<const uint8_t> bits = seams_of(attribute_data);
    for_each_lane_item(lanes, static_cast<uint32_t>(bits.size()),
                       [&](uint32_t i) { has_seams |= bits[i] != 0; });
    has_seams = any(lanes, has_seams);
    AttributeTable<Index> table{mesh.table, mesh.closed, mesh.vertex_count, has_seams};
    if (has_seams) {
      const bool is_taken = take(lanes, arena, table.table.opposite, mesh.table.opposite.size()) &&
                            take(lanes, arena, table.table.vertex, mesh.table.vertex.size()) &&
                            take(lanes, arena, table.closed, uint64_t{3} * mesh.counts.face_count);
      if (!is_taken) return Fault::kWorkspace;
      cut_seams(lanes, mesh.table.opposite, inner_edges_, bits, table.table.opposite);
      table.vertex_count = number_attribute_vertices(lanes, mesh, table, scratch, on_seam);
      if (lanes.rank() == 0) arena.trim(table.closed, table.vertex_count);
    }
    if (lanes.rank() == 0) tables_[attribute_data] = table;
    lanes.sync();
    return Fault::kNone;
  }

  uint32_t count_ = 0;
  RansBits bits_[kMaxAttributeData];
  // How far before an attribute data the first one with the same coded bits is; 0 if there is none.
  uint8_t same_back_[kMaxAttributeData] = {};
  View<Index> corner_room_, inner_edges_;  // the edges are first in the room, which later has corners
  View<uint8_t> seams_;                    // by attribute data and edge; later by corner
  View<BitSteps> steps_;
  View<CondensedSeamSteps> condensed_steps_;
  View<AttributeTable<Index>> tables_;
};

}  // namespace psplit::core
