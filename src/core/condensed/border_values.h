// The values of the first attribute at the border of each patch, which are known before the patch is decoded. A
// stream has those that it owns in its border part (border_part.h). The stitch map says which streams own the
// others. Specification: "border parts" (gltf_ext/PSPLIT_mesh_draco_patches).
//
//   place_own_values     for each stream: puts the values of its border part to their places
//   copy_shared_values   when that is done for its owners: copies the values that they own
#pragma once

#include "src/core/components.h"
#include "src/core/condensed/border_part.h"
#include "src/core/integer_vectors.h"
#include "src/core/lanes.h"
#include "src/core/stitch_reader.h"
#include "src/core/symbols.h"

namespace psplit::core {

// The most places that a border walk can have.
PSPLIT_HD inline uint32_t most_places(const CondensedStream& stream, uint32_t reference_count) {
  return stream.border_count + reference_count;
}

// By place of one stream's border walk.
struct WalkValues {
  View<int32_t> values;  // one component after the other
  View<uint8_t> is_own;  // whether no run of the stream's stitch map has the place
  uint32_t length = 0;
};

// Both functions are compiled for values of three components, and for any number of them if kComponents is 0.
template <uint32_t kComponents>
PSPLIT_HD Fault place_own_values(const StitchRow& row, const CondensedStream& stream, WalkValues& out) {
  const size_t components = kComponents != 0 ? kComponents : stream.border_components;
  // The value before the next one: a copy, or where it is if the number of components is not known.
  int32_t value[kComponents != 0 ? kComponents : 1] = {};
  const int32_t* last = nullptr;
  // A place is never behind the values that are still to be read.
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
