// Symbols for core::add_faces that pass through: read from one representation, and stored in the other.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "encoder/fields/draco_fields.h"
#include "src/core/edgebreaker.h"

namespace psplit {

// Symbols for core::add_faces. Each is also stored.
template <typename Symbols>
class StoredSymbols : public Symbols {
 public:
  StoredSymbols(const Symbols& symbols, uint8_t* out) : Symbols(symbols), out_(out) {}
  uint32_t next(uint32_t to) {
    const uint32_t symbol = Symbols::next(to);
    *out_++ = static_cast<uint8_t>(symbol);
    return symbol;
  }

 private:
  uint8_t* out_;
};

// Numbers of valences choose the list of the next symbol (core::Valences::class_of).
using Valences = core::Valences<uint32_t>;

// Takes core::Clers in their order, and notes the list of each except the first.
class NotedLists : public Valences {
 public:
  NotedLists(const Valences& valences, const uint8_t* symbols, uint8_t* lists)
      : Valences(valences), symbols_(symbols), lists_(lists) {}
  uint32_t next(uint32_t to) {
    *lists_++ = static_cast<uint8_t>(to != core::kNone<uint32_t> ? class_of(to) : 0);
    return *symbols_++;
  }

 private:
  const uint8_t* symbols_;
  uint8_t* lists_;
};

// Runs core::add_faces for its symbols; the mesh is not kept. make_symbols(valences) returns them; `valences`
// are started. The counts and the events may be anything that the caller has memory for.
template <typename MakeSymbols>
core::Fault add_faces_alone(const core::ConnectivityCounts& counts, const std::vector<core::SplitEvent>& events,
                            MakeSymbols make_symbols) {
  const size_t size = core::Connectivity<uint32_t>::bytes(counts) + Valences::bytes(counts) +
                      core::WaitingEdges<uint32_t>::bytes(counts);
  const std::unique_ptr<uint8_t[]> memory(new uint8_t[size]);
  core::Arena arena(memory.get(), size);
  core::Connectivity<uint32_t> mesh;
  mesh.counts = counts;
  Valences valences;
  core::WaitingEdges<uint32_t> waiting;
  if (!mesh.allocate(arena)) return core::Fault::kWorkspace;
  core::fill(mesh.table.opposite, core::kNone<uint32_t>);
  core::Fault fault = valences.start(counts, arena);
  if (fault == core::Fault::kNone)
    fault = waiting.start({events.data(), events.size()}, counts.symbol_count, arena);
  return fault == core::Fault::kNone ? core::add_faces(make_symbols(valences), waiting, mesh) : fault;
}

// The components of the mesh: the edges that wait when all symbols are decoded. Each E begins one, and each S
// ends one, unless it takes an edge that a split event set aside. The splits of the events are symbols.
uint32_t component_count(const DracoFields& fields);

// The list that has each symbol in a valence traversal, from vertex_count, face_count, symbol_count, symbols,
// split_events and start_faces. 0 for the first symbol, which no list has. Errors: kInvalidInput if they do not
// form a mesh.
Expected<std::vector<uint8_t>> lists_of_symbols(const DracoFields& fields);

// Fills symbol_lists from `symbols` and the list of each.
void fill_lists(const std::vector<uint8_t>& lists, DracoFields& fields);

}  // namespace psplit
