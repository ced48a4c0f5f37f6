// The border part of a condensed stream: values of the first attribute at places of its border walk that no
// other stream owns. They are needed before the stream is decoded, and by the streams that share them. The
// stitch map says which stream owns a value. Specification: "border parts"
// (gltf_ext/PSPLIT_mesh_draco_patches).
//
//   start_border_part    makes the tokens of a stream's part ready; after their steps,
//   place_own_values     puts the values of the part to their places in the stream's walk
//   copy_shared_values   copies the values that other streams own, when those are at their places
#pragma once

#include "src/core/components.h"
#include "src/core/condensed/condensed_stream.h"
#include "src/core/condensed/token_steps.h"
#include "src/core/integer_vectors.h"
#include "src/core/lanes.h"
#include "src/core/stitch_reader.h"
#include "src/core/symbols.h"

namespace psplit::core {

// Starts the tokens of the part of a stream with models.has_borders: the first value, then differences.
// `symbols` has room for border_count values of border_components numbers each, `table_of` for a number for
// each value. After all steps of `tokens`, its section is at the end of the part.
PSPLIT_HD inline Fault start_border_part(const CondensedStream& stream, View<uint8_t> table_of,
                                         View<uint32_t> symbols, TokenSequence& tokens) {
  SectionReader section = stream.numbers(stream.numbers_end);
  if (const Fault fault = section.start_words(stream.first_section); fault != Fault::kNone) return fault;
  TableSet tables;
  for (uint32_t t = 0; t < 2; ++t) {
    tables.tables[t] = stream.models.border_tables[t];
    if (stream.border_count > t && tables.tables[t] == kNoTable) return Fault::kEntropy;
  }
  for (uint32_t i = 0; i < stream.border_count; ++i) table_of[i] = i > 0;
  tokens.start(section, stream.models, tables, stream.border_components, table_of.first(stream.border_count),
               symbols);
  return Fault::kNone;
}

// The most places that a border walk can have.
PSPLIT_HD inline uint32_t most_places(const CondensedStream& stream, uint32_t reference_count) {
  return stream.border_count + reference_count;
}

// The values at the places of one stream's border walk.
struct WalkValues {
  View<int32_t> values;  // one component after the other
  View<uint8_t> is_own;  // whether no run of the stream's stitch map has the place
  uint32_t length = 0;
};

// Both functions are compiled for values of three components, and for any number of them if kComponents is 0.
template <uint32_t kComponents>
PSPLIT_HD Fault place_own_values(const StitchRow& row, const CondensedStream& stream, WalkValues& out) {
  const size_t components = kComponents != 0 ? kComponents : stream.border_components;
  // The previous value: a copy in registers, or a pointer if the number of components is not known here.
  int32_t value[kComponents != 0 ? kComponents : 1] = {};
  const int32_t* last = nullptr;
  // A place is never after the values that are still to be read.
  const int32_t* from = out.values.data() + out.values.size() - stream.border_count * components;
  uint32_t place = 0, left = stream.border_count;
  const auto place_next = [&](uint32_t count) {
    int32_t* to = out.values.data() + place * components;
    for (uint32_t i = 0; i < count; ++i, to += components, from += components) {
      for (size_t k = 0; k < components; ++k) {
        const auto difference = static_cast<int32_t>(signed_of_symbol(static_cast<uint32_t>(from[k])));
        if constexpr (kComponents != 0)
          to[k] = value[k] = wrapping_add(value[k], difference);
        else
          to[k] = wrapping_add(last != nullptr ? last[k] : 0, difference);
      }
      if constexpr (kComponents == 0) last = to;
    }
    fill(View<uint8_t>(out.is_own.data() + place, count), uint8_t{1});
    place += count;
    left -= count;
  };
  StitchReader reader(row);
  for (StitchReader::Run run; reader.next_run(run);) {
    if (run.begin - place > left) return Fault::kStitchRun;
    place_next(static_cast<uint32_t>(run.begin) - place);
    fill(View<uint8_t>(out.is_own.data() + place, run.length), uint8_t{0});
    place += run.length;
  }
  if (reader.broken()) return Fault::kStitchMap;
  place_next(left);
  out.length = place;
  return Fault::kNone;
}
template <uint32_t kComponents, Lanes L, typename WalkOf>
PSPLIT_HD Fault copy_shared_values(L lanes, const StitchRow& row, const CondensedStream& stream, WalkOf walk_of,
                                   const WalkValues& out) {
  const size_t components = kComponents != 0 ? kComponents : stream.border_components;
  bool missing = false;
  StitchReader reader(row);
  for (StitchReader::Run run; reader.next_run(run);) {
    const WalkValues owner = walk_of(run.owner);
    int32_t* const to = out.values.data() + static_cast<size_t>(run.begin) * components;
    for_each_lane_item(lanes, run.length, [&](uint32_t i) {
      const size_t place = run.place(i);
      if (PSPLIT_UNLIKELY(place >= owner.length || owner.is_own[place] == 0)) {
        missing = true;
        return;
      }
      for (size_t k = 0; k < components; ++k) to[i * components + k] = owner.values[place * components + k];
    });
  }
  return any(lanes, missing) ? Fault::kStitchOwner : Fault::kNone;
}

// `out` has room for most_places. The values of the part are at the end of out.values, the first one and then
// differences, as symbols. Sets out.length. The values of places in runs are not set.
PSPLIT_HD inline Fault place_own_values(const StitchRow& row, const CondensedStream& stream, WalkValues& out) {
  return stream.border_components == 3 ? place_own_values<3>(row, stream, out)
                                       : place_own_values<0>(row, stream, out);
}

// Copies the values at places in runs. walk_of(stream) returns the WalkValues of a stream whose own values are
// at their places. Collective.
template <Lanes L, typename WalkOf>
PSPLIT_HD Fault copy_shared_values(L lanes, const StitchRow& row, const CondensedStream& stream, WalkOf walk_of,
                                   const WalkValues& out) {
  return stream.border_components == 3 ? copy_shared_values<3>(lanes, row, stream, walk_of, out)
                                       : copy_shared_values<0>(lanes, row, stream, walk_of, out);
}

}  // namespace psplit::core
