// The connectivity of a condensed stream: its symbols, split events and start faces to a corner table
// (edgebreaker.h).
#pragma once

#include "src/core/condensed/condensed_numbers.h"
#include "src/core/condensed/context_symbols.h"
#include "src/core/condensed/creation.h"
#include "src/core/edgebreaker.h"

namespace psplit::core {

// Which components have a start face.
class CondensedStartFaces {
 public:
  PSPLIT_HD explicit CondensedStartFaces(const CondensedStream& stream)
      : has_bits_(stream.has_start_face_bits()),
        all_(stream.interior_count > 0),
        bits_(stream.numbers(stream.start_faces_at)) {}
  PSPLIT_HD bool next() {
    ++count_;
    return has_bits_ ? bits_.read(1) != 0 : all_;
  }
  PSPLIT_HD uint32_t count() const { return count_; }

 private:
  bool has_bits_, all_;
  SectionReader bits_;
  uint32_t count_ = 0;
};

// Reads as many split events as there are in `events`.
PSPLIT_HD inline Fault read_split_events(const CondensedStream& stream, uint32_t symbol_count,
                                         View<SplitEvent> events) {
  CondensedNumbers numbers(stream.numbers(stream.events_at));
  CondensedKinds kinds;
  uint64_t source = 0;
  for (size_t i = 0; i < events.size(); ++i) {
    const CondensedNumbers::SplitEventNumbers event = numbers.split_event(kinds.event);
    source += event.source_delta;
    if (!set_split_event(symbol_count, source, event.back, events[i])) return Fault::kSplitEvent;
    events[i].right_edge = event.right_edge;
  }
  return Fault::kNone;
}

// Sets `section` to the first section where Edgebreaker's symbols begin, after the border part.
PSPLIT_HD inline Fault start_symbols(const CondensedStream& stream, SectionReader& section) {
  section = stream.models.has_borders ? stream.behind_border : stream.numbers(stream.numbers_end);
  if (!stream.models.has_borders) return section.start_words(stream.first_section);
  return section.empty() ? Fault::kCounts : Fault::kNone;
}

template <typename Index>
class CondensedConnectivity {
 public:
  // Reads the split events, and makes the steps of symbols ready, if their contexts do not need the mesh.
  PSPLIT_HD Fault start(const ConnectivityCounts& counts, const CondensedStream& stream, Arena& arena,
                        Connectivity<Index>& mesh) {
    mesh.counts = counts;
    if (!arena.take(corners_.corner, corner_room(counts)) || !mesh.allocate(arena)) return Fault::kWorkspace;
    for (size_t i = 0; i < stream.models.attributes.size(); ++i)
      corners_.are_last |= stream.models.attributes[i].by_creation && stream.models.attributes[i].backward;
    mark_ = arena.mark();
    if (!arena.take(events_, counts.split_count)) return Fault::kWorkspace;
    Fault fault = read_split_events(stream, counts.symbol_count, events_);
    if (fault == Fault::kNone) fault = start_symbols(stream, section_);
    if (fault != Fault::kNone) return fault;
    if (stream.models.has_valence_contexts) return valences_.start(counts, arena);
    if (!arena.take(symbols_, counts.symbol_count) || !arena.take(steps_, 1)) return Fault::kWorkspace;
    steps_[0] = ContextSymbolSteps(section_, stream.models, symbols_);
    return Fault::kNone;
  }
  // To be taken before finish. Empty for contexts of valences.
  PSPLIT_HD View<ContextSymbolSteps> steps() const { return steps_; }

  // Makes add_faces ready.
  PSPLIT_HD Fault begin_faces(Arena& arena, const ConnectivityCounts& counts) {
    return waiting_.start(events_, counts.symbol_count, arena);
  }
  // See add_all_faces. Unless the vertices keep their order, merged ones are replaced.
  PSPLIT_HD Fault add_faces(const CondensedStream& stream, bool keep_order, Connectivity<Index>& mesh) {
    CondensedStartFaces start_faces(stream);
    const Fault fault = corners_.are_last ? add_faces<true>(stream, start_faces, mesh)
                                          : add_faces<false>(stream, start_faces, mesh);
    if (fault != Fault::kNone) return fault;
    if (start_faces.count() != stream.component_count || mesh.merged_count != stream.split_symbol_count)
      return Fault::kCounts;
    corners_.corner = corners_.corner.first(mesh.vertex_count);
    if (corners_.are_last) finish_last_corners(mesh);
    if (!keep_order) mesh.fill_holes();
    return Fault::kNone;
  }
  // Releases all memory that was taken since `start`, except that of the mesh, whose `merged` ends, and of
  // corners.
  PSPLIT_HD void finish(Arena& arena, Connectivity<Index>& mesh) {
    arena.release(mark_);
    arena.trim(mesh.merged, 0);
    steps_ = {};
  }
  // First corners ascend. The last corner of a merged vertex is kNone. Last corners are noted if a model needs
  // them, otherwise first corners.
  PSPLIT_HD const VertexCorners<Index>& corners() const { return corners_; }
  // The section after the symbols.
  PSPLIT_HD const SectionReader& section() const { return section_; }

  // The memory that this takes and keeps, and the memory that it takes and releases.
  PSPLIT_HD static size_t bytes(const ConnectivityCounts& counts) {
    return Connectivity<Index>::bytes_without_merged(counts) + Arena::bytes<Index>(corner_room(counts));
  }
  PSPLIT_HD static size_t scratch_bytes(const ConnectivityCounts& counts, const CondensedStream& stream) {
    const size_t symbols = Arena::bytes<uint8_t>(counts.symbol_count) + Arena::bytes<ContextSymbolSteps>(1);
    return Connectivity<Index>::merged_bytes(counts) + Arena::bytes<SplitEvent>(counts.split_count) +
           connectivity_scratch_bytes<Index>(counts) +
           (stream.models.has_valence_contexts ? Valences<Index>::bytes(counts) : symbols);
  }

 private:
  // The last symbol may bring three vertices more than the limit before the excess is found.
  PSPLIT_HD static size_t corner_room(const ConnectivityCounts& counts) {
    return size_t{counts.vertex_limit} + 3;
  }

  template <bool kLast>
  PSPLIT_HD Fault add_faces(const CondensedStream& stream, CondensedStartFaces& start_faces,
                            Connectivity<Index>& mesh) {
    if (stream.models.has_valence_contexts) {
      const ValenceContextSymbols<Index, kLast> symbols(valences_, stream.models, section_, corners_.corner);
      return add_all_faces(symbols, waiting_, start_faces, mesh);
    }
    section_ = steps_[0].section();
    const DecodedSymbols<Index, kLast> symbols(symbols_, corners_.corner);
    return add_all_faces(symbols, waiting_, start_faces, mesh);
  }
  // Start faces come after all others.
  PSPLIT_HD void finish_last_corners(const Connectivity<Index>& mesh) {
    constexpr uint32_t kOrder[] = {0, 2, 1};  // backward, corner 1 of a face is the first
    for (uint32_t face = mesh.counts.symbol_count; face < mesh.counts.face_count; ++face)
      for (const uint32_t k : kOrder)
        corners_.corner[mesh.table.vertex[4 * face + k]] = static_cast<Index>(4 * face + k);
    for (uint32_t i = 0; i < mesh.merged_count; ++i) corners_.corner[mesh.merged[i]] = kNone<Index>;
  }

  size_t mark_ = 0;
  SectionReader section_;
  View<SplitEvent> events_;
  VertexCorners<Index> corners_;
  Valences<Index> valences_;
  View<uint8_t> symbols_;
  View<ContextSymbolSteps> steps_;
  WaitingEdges<Index> waiting_;
};

}  // namespace psplit::core
