// The connectivity of an Edgebreaker stream: reads its sections, and decodes the corner table from them
// (edgebreaker.h). Draco bitstream specification 2.2, "edgebreaker decoder".
#pragma once

#include "src/core/draco_header.h"
#include "src/core/edgebreaker.h"

namespace psplit::core {

template <typename Index>
class EdgebreakerDecoder {
 public:
  // Reads the split events, the symbols of the standard traversal, and the start faces.
  PSPLIT_HD Fault start(const DracoHeader& header, ByteReader& reader, Arena& arena,
                        Connectivity<Index>& mesh) {
    is_valence_ = header.valence;
    mesh.counts = header.counts;
    if (!mesh.allocate(arena)) return Fault::kWorkspace;
    mark_ = arena.mark();
    if (!arena.take(events_, header.counts.split_count)) return Fault::kWorkspace;
    if (const Fault fault = read_split_events(reader, header.counts.symbol_count, events_);
        fault != Fault::kNone)
      return fault;
    if (!is_valence_) {
      const uint64_t size = reader.varint64();
      symbol_bits_ = BitReader(reader.head(), reader.remaining());
      if (!reader.skip(size)) return Fault::kTruncated;
    }
    return start_faces_.start(reader);
  }

  // For a valence traversal: makes ready one sequence for each list of symbols. They are to be decoded before
  // finish.
  PSPLIT_HD Fault start_symbol_lists(const ConnectivityCounts& counts, ByteReader& reader, Arena& arena) {
    if (!arena.take(symbol_lists_, ValenceSymbols<Index>::kLists)) return Fault::kWorkspace;
    return valence_symbols_.start(reader, counts, arena, symbol_lists_);
  }
  PSPLIT_HD View<SymbolSequence> symbol_lists() const { return symbol_lists_; }

  // Makes add_faces ready, when the symbols of a valence traversal are decoded.
  PSPLIT_HD Fault begin_faces(ByteReader& reader, Arena& arena, const ConnectivityCounts& counts) {
    const Fault fault = is_valence_ ? valence_symbols_.finish(reader, symbol_lists_) : Fault::kNone;
    return fault == Fault::kNone ? waiting_.start(events_, counts.symbol_count, arena) : fault;
  }
  // See add_all_faces. Unless the vertices keep their order, merged ones are replaced.
  PSPLIT_HD Fault add_faces(bool keep_order, Connectivity<Index>& mesh) {
    const Fault fault = is_valence_
                            ? add_all_faces(valence_symbols_, waiting_, start_faces_, mesh)
                            : add_all_faces(StandardSymbols(symbol_bits_), waiting_, start_faces_, mesh);
    if (fault == Fault::kNone && !keep_order) mesh.fill_holes();
    return fault;
  }
  // Releases all memory that was taken since `start`, except that of the mesh, whose `merged` ends.
  PSPLIT_HD void finish(Arena& arena, Connectivity<Index>& mesh) {
    arena.release(mark_);
    arena.trim(mesh.merged, 0);
  }

  // The memory that this takes and keeps, and the memory that it takes and releases; without the slots of
  // symbols' tables.
  PSPLIT_HD static size_t bytes(const DracoHeader& header) {
    return Connectivity<Index>::bytes_without_merged(header.counts);
  }
  PSPLIT_HD static size_t scratch_bytes(const DracoHeader& header) {
    using Symbols = ValenceSymbols<Index>;
    const size_t lists = Arena::bytes<SymbolSequence>(Symbols::kLists) + Symbols::bytes(header.counts) +
                         SymbolSequence::bytes(Symbols::kLists, header.counts.symbol_count);
    return Connectivity<Index>::merged_bytes(header.counts) +
           Arena::bytes<SplitEvent>(header.counts.split_count) + (header.valence ? lists : 0) +
           connectivity_scratch_bytes<Index>(header.counts);
  }

 private:
  bool is_valence_ = false;
  size_t mark_ = 0;
  View<SplitEvent> events_;
  BitReader symbol_bits_;
  ValenceSymbols<Index> valence_symbols_;
  View<SymbolSequence> symbol_lists_;
  RansBits start_faces_;
  WaitingEdges<Index> waiting_;
};

}  // namespace psplit::core
