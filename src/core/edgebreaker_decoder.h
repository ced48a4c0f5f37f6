// The connectivity of an Edgebreaker stream: reads its sections, and decodes the corner table from them
// (edgebreaker.h). Draco bitstream specification 2.2, "edgebreaker decoder".
#pragma once

#include "src/core/edgebreaker.h"
#include "src/core/stream_header.h"

namespace psplit::core {

template <typename Index>
class EdgebreakerDecoder {
 public:
  // Reads the split events, the symbols of the standard traversal, and the start faces.
  PSPLIT_HD Fault start(const StreamHeader& header, ByteReader& reader, Arena& arena,
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

  // Decodes the mesh, and releases all other memory that was taken since start. `keep_order` is that of
  // Connectivity::drop_merged_vertices.
  PSPLIT_HD Fault finish(ByteReader& reader, Arena& arena, bool keep_order, Connectivity<Index>& mesh) {
    Fault fault = Fault::kNone;
    if (is_valence_) {
      fault = valence_symbols_.finish(reader, symbol_lists_);
      if (fault == Fault::kNone)
        fault = decode_connectivity(valence_symbols_, events_, start_faces_, arena, mesh);
    } else {
      fault = decode_connectivity(StandardSymbols(symbol_bits_), events_, start_faces_, arena, mesh);
    }
    if (fault != Fault::kNone) return fault;
    mesh.drop_merged_vertices(keep_order);
    arena.release(mark_);
    return Fault::kNone;
  }

  // The memory that this takes and keeps, and the memory that it takes and releases; without the slots of
  // symbols' tables.
  PSPLIT_HD static size_t bytes(const StreamHeader& header) {
    return Connectivity<Index>::bytes(header.counts);
  }
  PSPLIT_HD static size_t scratch_bytes(const StreamHeader& header) {
    using Symbols = ValenceSymbols<Index>;
    const size_t lists = Arena::bytes<SymbolSequence>(Symbols::kLists) + Symbols::bytes(header.counts) +
                         Symbols::kLists * SymbolSequence::bytes();
    return Arena::bytes<SplitEvent>(header.counts.split_count) + (header.valence ? lists : 0) +
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
};

}  // namespace psplit::core
