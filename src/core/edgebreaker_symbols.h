// What Edgebreaker reads: its symbols, as one of two traversals stores them, and its split events. Draco
// bitstream specification 2.2, "edgebreaker traversal" and "edgebreaker traversal valence".
#pragma once

#include "src/core/connectivity.h"
#include "src/core/symbols.h"

namespace psplit::core {

// The codes of the standard traversal: C takes one bit, the others three.
enum Clers : uint32_t { kC = 0, kS = 1, kL = 3, kR = 5, kE = 7 };
// Lists and tables of symbols number C, S, L, R and E from 0 on.
inline constexpr uint32_t kClersCount = 5;
PSPLIT_HD constexpr uint32_t clers_of_number(uint32_t number) { return number == 0 ? kC : 2 * number - 1; }
PSPLIT_HD constexpr uint32_t number_of_clers(uint32_t symbol) { return (symbol + 1) / 2; }
PSPLIT_HD constexpr bool is_clr(uint32_t symbol) { return (0b00101001u >> symbol & 1) != 0; }

// A handle: an edge of the face that symbol `source` adds is set aside for the S that is symbol `split`. Both
// count in order of decoding.
struct SplitEvent {
  uint32_t source = 0;
  uint32_t split = 0;
  uint32_t right_edge = 0;
};

// A stream counts symbols from the last one on, and `source` from the event before. Returns false if there are
// no such symbols.
PSPLIT_HD inline bool set_split_event(uint32_t symbol_count, uint64_t source, uint64_t back,
                                      SplitEvent& event) {
  if (source >= symbol_count || back > source) return false;
  event.source = static_cast<uint32_t>(symbol_count - 1 - source);
  event.split = static_cast<uint32_t>(symbol_count - 1 - (source - back));
  return true;
}

// Reads as many events as there are in `events`. Their sources descend, as encoders count from the other end.
PSPLIT_HD inline Fault read_split_events(ByteReader& reader, uint32_t symbol_count, View<SplitEvent> events) {
  uint64_t source = 0;
  for (size_t i = 0; i < events.size(); ++i) {
    source += reader.varint();
    const uint64_t back = reader.varint();
    if (reader.truncated()) return Fault::kTruncated;
    if (!set_split_event(symbol_count, source, back, events[i])) return Fault::kSplitEvent;
  }
  if (events.empty()) return Fault::kNone;
  BitReader edges(reader.head(), reader.remaining());
  for (size_t i = 0; i < events.size(); ++i) events[i].right_edge = edges.read(1);
  return reader.skip(edges.bytes_taken()) ? Fault::kNone : Fault::kTruncated;
}

// The standard traversal: one string of bits.
class StandardSymbols {
 public:
  PSPLIT_HD explicit StandardSymbols(BitReader bits) : bits_(bits) {}
  PSPLIT_HD uint32_t next(uint32_t) {
    constexpr int kMostBits = 3;
    if constexpr (PSPLIT_MOVES_ROWS) {
      // The lanes of a warp load at the same symbols, so that they wait once for all.
      constexpr uint32_t kAtOnce = 16;
      if (count_++ % kAtOnce == 0) (void)bits_.peek(kMostBits * kAtOnce);
    }
    const auto ahead = static_cast<uint32_t>(PSPLIT_MOVES_ROWS ? bits_.peeked() : bits_.peek(kMostBits));
    const uint32_t is_long = ahead & 1;
    bits_.take(static_cast<int>(1 + 2 * is_long));
    return ahead & 7 & (0 - is_long);
  }
  PSPLIT_HD void added(uint32_t, uint32_t, uint32_t, uint32_t) {}
  PSPLIT_HD void merged(uint32_t, uint32_t) {}

 private:
  BitReader bits_;
  uint32_t count_ = 0;
};

// The valences of vertices, as far as they are known while symbols are decoded.
template <typename Valence>
class Valences {
 public:
  static constexpr uint32_t kLowest = 2, kHighest = 7, kClasses = kHighest - kLowest + 1;

  PSPLIT_HD Fault start(const ConnectivityCounts& counts, Arena& arena) {
    if (!arena.take(of_, uint64_t{counts.vertex_limit} + 3)) return Fault::kWorkspace;
    fill(of_, Valence{0});
    return Fault::kNone;
  }
  // The memory that `start` takes.
  PSPLIT_HD static size_t bytes(const ConnectivityCounts& counts) {
    return Arena::bytes<Valence>(uint64_t{counts.vertex_limit} + 3);
  }

  // The class of a vertex: its valence, at least kLowest and at most kHighest, minus kLowest.
  PSPLIT_HD uint32_t class_of(uint32_t vertex) const {
    const uint32_t valence = of_[vertex];
    return (valence < kLowest ? kLowest : valence > kHighest ? kHighest : valence) - kLowest;
  }
  // The symbol added the face with these vertices.
  PSPLIT_HD void added(uint32_t symbol, uint32_t v0, uint32_t v1, uint32_t v2) {
    // A digit for each code of a symbol, the lowest digit for 0. Branches would be unpredictable.
    constexpr uint32_t kOf0 = 0x20101000, kOf1 = 0x20102011, kOf2 = 0x20201011;
    grow(v0, kOf0 >> 4 * symbol & 3);
    grow(v1, kOf1 >> 4 * symbol & 3);
    grow(v2, kOf2 >> 4 * symbol & 3);
  }
  // An S made vertex n part of vertex p.
  PSPLIT_HD void merged(uint32_t p, uint32_t n) { grow(p, of_[n]); }

 private:
  PSPLIT_HD void grow(uint32_t vertex, uint32_t by) { of_[vertex] = static_cast<Valence>(of_[vertex] + by); }

  View<Valence> of_;
};

// The valence traversal: a list of symbols for each valence. The valence of the vertex that a C would close
// says which list has the next symbol.
template <typename Valence>
class ValenceSymbols {
 public:
  static constexpr uint32_t kLists = Valences<Valence>::kClasses;

  // Starts a sequence for each list. All of them are to be decoded before `finish`.
  PSPLIT_HD Fault start(ByteReader& reader, const ConnectivityCounts& counts, Arena& arena,
                        View<SymbolSequence> sequences) {
    if (const Fault fault = valences_.start(counts, arena); fault != Fault::kNone) return fault;
    for (uint32_t i = 0; i < kLists; ++i) {
      List& list = lists_[i];
      list.left = reader.varint();
      if (reader.truncated()) return Fault::kTruncated;
      if (list.left > counts.face_count) return Fault::kCounts;
      if (!arena.take(list.decoded, list.left)) return Fault::kWorkspace;
      sequences[i] = {};
      Fault fault = sequences[i].start(reader, list.left, 1, arena, list.decoded);
      if (fault == Fault::kNone && sequences[i].is_tagged()) {
        fault = sequences[i].finish(SerialLanes(), reader);  // the next list begins after its last bit
        sequences[i] = {};
      }
      if (fault == Fault::kMethod) {
        // As in libdraco, a list in a coding that does not exist has zeros.
        fill(list.decoded, uint32_t{0});
        sequences[i] = {};
        fault = Fault::kNone;
      }
      if (fault != Fault::kNone) return fault;
    }
    return Fault::kNone;
  }
  // The memory that `start` takes, without the sequences' tables, if the lists have no more symbols than the
  // stream.
  PSPLIT_HD static size_t bytes(const ConnectivityCounts& counts) {
    return Valences<Valence>::bytes(counts) + Arena::bytes<uint32_t>(counts.symbol_count) +
           (kLists - 1) * Arena::bytes<uint32_t>(0);
  }

  PSPLIT_HD Fault finish(ByteReader& reader, View<SymbolSequence> sequences) {
    for (uint32_t i = 0; i < kLists; ++i) {
      if (const Fault fault = sequences[i].finish(SerialLanes(), reader); fault != Fault::kNone) return fault;
      // The list becomes one of bytes, in place.
      List& list = lists_[i];
      list.symbols = reinterpret_cast<uint8_t*>(list.decoded.data());
      for (uint32_t k = 0; k < list.left; ++k) {
        const uint32_t symbol = list.decoded[k];
        list.symbols[k] = symbol < kClersCount ? static_cast<uint8_t>(clers_of_number(symbol)) : kInvalid;
      }
    }
    return Fault::kNone;
  }

  // `to` is the vertex that a C would close, kNone before the first symbol, which is always E.
  PSPLIT_HD uint32_t next(uint32_t to) {
    if (to == kNone<Valence>) return kE;
    List& list = lists_[valences_.class_of(to)];
    return list.left > 0 ? list.symbols[--list.left] : uint32_t{kInvalid};
  }
  PSPLIT_HD void added(uint32_t symbol, uint32_t v0, uint32_t v1, uint32_t v2) {
    valences_.added(symbol, v0, v1, v2);
  }
  PSPLIT_HD void merged(uint32_t p, uint32_t n) { valences_.merged(p, n); }

 private:
  static constexpr uint8_t kInvalid = 6;
  struct List {
    View<uint32_t> decoded;
    uint8_t* symbols = nullptr;
    uint32_t left = 0;
  };

  List lists_[kLists];
  Valences<Valence> valences_;
};

}  // namespace psplit::core
