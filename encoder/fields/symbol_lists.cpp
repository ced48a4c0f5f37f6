#include "encoder/fields/symbol_lists.h"

#include <algorithm>

#include "src/container/claims.h"

namespace psplit {
namespace {

bool are_clers(const std::vector<uint8_t>& symbols) {
  constexpr uint32_t kClers =
      1u << core::kC | 1u << core::kS | 1u << core::kL | 1u << core::kR | 1u << core::kE;
  return std::all_of(symbols.begin(), symbols.end(),
                     [](uint8_t symbol) { return symbol < 8 && (kClers >> symbol & 1) != 0; });
}

// Whether the events are as core::add_faces requires.
bool are_events(const std::vector<core::SplitEvent>& events, uint32_t symbol_count) {
  for (size_t i = 0; i < events.size(); ++i)
    if (events[i].split >= symbol_count || (i > 0 && events[i].source > events[i - 1].source)) return false;
  return true;
}

}  // namespace

uint32_t component_count(const DracoFields& fields) {
  std::vector<bool> has_event(fields.symbols.size());
  for (const core::SplitEvent& event : fields.split_events)
    if (event.split > event.source) has_event[event.split] = true;
  uint32_t count = 0;
  for (size_t i = 0; i < fields.symbols.size(); ++i) {
    count += fields.symbols[i] == core::kE ? 1 : 0;
    count -= fields.symbols[i] == core::kS && !has_event[i] ? 1 : 0;
  }
  return count;
}

Expected<std::vector<uint8_t>> lists_of_symbols(const DracoFields& fields) {
  const auto s_count =
      static_cast<uint64_t>(std::count(fields.symbols.begin(), fields.symbols.end(), core::kS));
  const uint64_t faces = fields.face_count, limit = fields.vertex_count + s_count;
  // So the memory is a small multiple of what the fields take.
  const bool fit = are_clers(fields.symbols) && fields.symbols.size() == fields.symbol_count &&
                   faces >= fields.symbol_count && faces <= fields.symbol_count + fields.start_faces.size() &&
                   faces < core::kMaxFaces<uint32_t> && limit <= 3 * faces + s_count && limit < 0xfffffff0u &&
                   are_events(fields.split_events, fields.symbol_count);
  std::vector<uint8_t> lists(fields.symbols.size());
  const core::ConnectivityCounts counts{fields.face_count, static_cast<uint32_t>(limit), fields.symbol_count,
                                        static_cast<uint32_t>(fields.split_events.size())};
  core::Fault fault = fit ? core::Fault::kNone : core::Fault::kCounts;
  if (fit && fields.symbol_count > 0)
    fault = add_faces_alone(counts, fields.split_events, [&](const Valences& valences) {
      return NotedLists(valences, fields.symbols.data(), lists.data());
    });
  if (fault != core::Fault::kNone) return status_of(fault);
  return lists;
}

void fill_lists(const std::vector<uint8_t>& lists, DracoFields& fields) {
  for (std::vector<uint8_t>& list : fields.symbol_lists) list.clear();
  for (size_t i = fields.symbols.size(); i-- > 1;)
    fields.symbol_lists[lists[i]].push_back(static_cast<uint8_t>(core::number_of_clers(fields.symbols[i])));
}

Status list_symbols(DracoFields& fields) {
  const Expected<std::vector<uint8_t>> lists = lists_of_symbols(fields);
  if (!lists) return lists.status();
  fill_lists(*lists, fields);
  return {};
}

}  // namespace psplit
