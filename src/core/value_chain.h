// Chains of values, each of which is computed from values before it, by the lanes of a warp. Each component of
// a value has a lane, and as many values as have lanes are computed one after the other. All that does not
// depend on the chain is done for these values at once.
#pragma once

#include "src/core/lanes.h"

namespace psplit::core {

// The value and the component that a lane computes, of all that are computed at once.
template <uint32_t kComponents, Lanes L>
struct ValueLane {
  static constexpr uint32_t kValues = L::size() / kComponents;
  uint32_t value, component;

  PSPLIT_HD explicit ValueLane(L lanes)
      : value(lanes.rank() / kComponents), component(lanes.rank() % kComponents) {}
  // The last lanes may have nothing to do.
  PSPLIT_HD bool is_busy() const { return value < kValues; }
};

// Returns value_of(sources), a component of a value, in each lane of the first `count` values. Source s is the
// same component of value from[s] if that is a lower value, and is known already otherwise. Collective.
template <uint32_t kComponents, uint32_t kSources, Lanes L, typename ValueOf>
PSPLIT_HD int32_t chain_values(L lanes, uint32_t count, int32_t (&sources)[kSources],
                               const uint32_t (&from)[kSources], ValueOf value_of) {
  uint32_t lane = lanes.rank() % kComponents;
  for (uint32_t value = 0; value + 1 < count; ++value, lane += kComponents) {
    const auto known = static_cast<int32_t>(lanes.shuffle(static_cast<uint32_t>(value_of(sources)), lane));
    for (uint32_t s = 0; s < kSources; ++s)
      if (from[s] == value) sources[s] = known;
  }
  return value_of(sources);
}

}  // namespace psplit::core
