// Symbols for core::add_faces that pass through: read from one representation, and stored in the other.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "src/condensed/draco_fields.h"
#include "src/core/edgebreaker_symbols.h"

namespace psplit {

using SymbolLists = std::array<std::vector<uint8_t>, DracoFields::kSymbolLists>;

// The symbols of the valence traversal's lists, by number.
inline constexpr uint8_t kClersOfNumber[5] = {core::kC, core::kS, core::kL, core::kR, core::kE};
inline constexpr uint8_t kNumberOfClers[8] = {0, 1, 0, 2, 0, 3, 0, 4};

// Symbols of the standard traversal. Each is also stored.
class StoredStandardSymbols : public core::StandardSymbols {
 public:
  StoredStandardSymbols(core::BitReader bits, uint8_t* out) : StandardSymbols(bits), out_(out) {}
  uint32_t next(uint32_t to) {
    const uint32_t symbol = StandardSymbols::next(to);
    *out_++ = static_cast<uint8_t>(symbol);
    return symbol;
  }

 private:
  uint8_t* out_;
};

// The valences of the faces that are decoded, which choose the list of the next symbol (core::ValenceSymbols).
class Valences {
 public:
  // `room` zeros, which the caller keeps.
  explicit Valences(core::View<uint32_t> valences) : valences_(valences) {}

  static size_t room(const core::ConnectivityCounts& counts) { return size_t{counts.vertex_limit} + 3; }
  static size_t bytes(const core::ConnectivityCounts& counts) {
    return core::Arena::bytes<uint32_t>(room(counts));
  }

  // For the vertex that a C would close.
  uint32_t list(uint32_t to) const { return std::clamp(valences_[to], 2u, 7u) - 2; }

  // For core::add_faces.
  void added(uint32_t symbol, uint32_t v0, uint32_t v1, uint32_t v2) {
    valences_[v0] += symbol == core::kE ? 2 : symbol == core::kL || symbol == core::kR ? 1 : 0;
    valences_[v1] += symbol == core::kE || symbol == core::kL ? 2 : 1;
    valences_[v2] += symbol == core::kE || symbol == core::kR ? 2 : 1;
  }
  void merged(uint32_t p, uint32_t n) { valences_[p] += valences_[n]; }
  void brought(uint32_t, uint32_t) {}

 private:
  core::View<uint32_t> valences_;
};

// Takes symbols from the lists, which have symbols 0 to 4, and stores them in their order.
class ListedSymbols : public Valences {
 public:
  ListedSymbols(core::View<uint32_t> valences, const SymbolLists& lists, uint8_t* out)
      : Valences(valences), lists_(&lists), out_(out) {
    for (size_t i = 0; i < lists.size(); ++i) left_[i] = lists[i].size();
  }
  uint32_t next(uint32_t to) {
    constexpr uint8_t kInvalid = 6;
    uint8_t symbol = core::kE;  // the first
    if (to != core::kNone<uint32_t>) {
      size_t& left = left_[list(to)];
      symbol = left > 0 ? kClersOfNumber[(*lists_)[list(to)][--left]] : kInvalid;
    }
    *out_++ = symbol;
    return symbol;
  }

 private:
  const SymbolLists* lists_;
  std::array<size_t, DracoFields::kSymbolLists> left_;
  uint8_t* out_;
};

// Takes core::Clers in their order, and notes the list of each except the first.
class NotedLists : public Valences {
 public:
  NotedLists(core::View<uint32_t> valences, const uint8_t* symbols, uint8_t* lists)
      : Valences(valences), symbols_(symbols), lists_(lists) {}
  uint32_t next(uint32_t to) {
    *lists_++ = static_cast<uint8_t>(to != core::kNone<uint32_t> ? list(to) : 0);
    return *symbols_++;
  }

 private:
  const uint8_t* symbols_;
  uint8_t* lists_;
};

// The components of the mesh: the edges that wait when all symbols are decoded. Each E begins one, and each S
// ends one, unless it takes an edge that a split event set aside. The splits of the events are symbols.
uint32_t component_count(const DracoFields& fields);

// The list that has each symbol in a valence traversal, from vertex_count, face_count, symbol_count, symbols,
// split_events and start_faces. 0 for the first symbol, which no list has. Errors: kInvalidInput if they do not
// form a mesh.
Expected<std::vector<uint8_t>> lists_of_symbols(const DracoFields& fields);

}  // namespace psplit
