// Draco mesh streams of every kind that libdraco's encoder writes.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/draco_oracle.h"

namespace psplit {

struct DracoStream {
  std::string name;  // unique in its set: mesh, then what was asked of the encoder
  std::vector<uint8_t> bytes;
};

enum class StreamSet {
  kSmall,  // hundreds of streams with every feature but the giants' ones; a second
  kAll,    // some ten thousand streams, up to two million points in one; ten seconds
};

// Calls `visit` with each stream of the set, in the same order and with the same bytes every time. libdraco
// decodes every one of them.
void for_each_draco_stream(const std::function<void(const DracoStream&)>& visit, StreamSet set);

}  // namespace psplit
