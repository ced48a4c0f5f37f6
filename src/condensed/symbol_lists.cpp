#include "src/condensed/symbol_lists.h"

#include <memory>

#include "src/core/edgebreaker.h"

namespace psplit {
namespace {

bool are_clers(const std::vector<uint8_t>& symbols) {
  constexpr uint32_t kClers =
      1u << core::kC | 1u << core::kS | 1u << core::kL | 1u << core::kR | 1u << core::kE;
  return std::ranges::all_of(symbols, [](uint8_t symbol) { return symbol < 8 && (kClers >> symbol & 1) != 0; });
}

// Whether the events are as core::add_faces requires.
bool are_events(const std::vector<core::SplitEvent>& events, uint32_t symbol_count) {
  for (size_t i = 0; i < events.size(); ++i)
    if (events[i].split >= symbol_count || (i > 0 && events[i].source > events[i - 1].source)) return false;
  return true;
}

}  // namespace

Status list_symbols(DracoFields& fields) {
  using core::Arena;
  const auto s_count = static_cast<uint64_t>(std::ranges::count(fields.symbols, core::kS));
  const uint64_t faces = fields.face_count, limit = fields.vertex_count + s_count;
  // So the memory is a small multiple of what the fields take.
  const bool fit = are_clers(fields.symbols) && fields.symbols.size() == fields.symbol_count &&
                   faces >= fields.symbol_count && faces <= fields.symbol_count + fields.start_faces.size() &&
                   faces < core::kMaxFaces<uint32_t> && limit <= 3 * faces + s_count && limit < 0xfffffff0u &&
                   are_events(fields.split_events, fields.symbol_count);
  for (std::vector<uint8_t>& list : fields.symbol_lists) list.clear();
  core::Connectivity<uint32_t> mesh;
  mesh.counts = {fields.face_count, static_cast<uint32_t>(limit), fields.symbol_count,
                 static_cast<uint32_t>(fields.split_events.size())};
  core::Fault fault = fit ? core::Fault::kNone : core::Fault::kCounts;
  if (fault == core::Fault::kNone && fields.symbol_count > 0) {
    const size_t size = core::Connectivity<uint32_t>::bytes(mesh.counts) + Valences::bytes(mesh.counts) +
                        core::WaitingEdges<uint32_t>::bytes(mesh.counts);
    const std::unique_ptr<uint8_t[]> memory(new uint8_t[size]);
    Arena arena(memory.get(), size);
    core::View<uint32_t> valences;
    core::WaitingEdges<uint32_t> waiting;
    mesh.allocate(arena);
    arena.take(valences, Valences::room(mesh.counts));
    core::fill(valences, 0u);
    core::fill(mesh.table.opposite, core::kNone<uint32_t>);
    fault = waiting.start({fields.split_events.data(), fields.split_events.size()}, fields.symbol_count, arena);
    if (fault == core::Fault::kNone)
      fault =
          core::add_faces(ListingSymbols(valences, fields.symbols.data(), fields.symbol_lists), waiting, mesh);
  }
  for (std::vector<uint8_t>& list : fields.symbol_lists) std::ranges::reverse(list);
  return fault == core::Fault::kNone ? Status() : invalid_input(core::fault_text(fault));
}

}  // namespace psplit
