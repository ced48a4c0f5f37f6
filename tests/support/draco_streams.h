// Draco mesh streams of every kind that libdraco's encoder writes.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/draco_oracle.h"

namespace psplit {

struct DracoStream {
  std::string name;  // unique in its set: the mesh, then the options of the encoder
  std::vector<uint8_t> bytes;
};

enum class StreamSet {
  kSmall,  // hundreds of streams with every feature except giant meshes; takes a second
  kThird,  // every third of kAll, for tests that compare slowly and take long
  kAll,    // some ten thousand streams, of up to two million points, for tests that take long
};

// Makes the streams of the set, always in the same order and with the same bytes, and calls `visit` with each.
// libdraco can decode all of them.
void for_each_draco_stream(const std::function<void(const DracoStream&)>& visit, StreamSet set);

// The streams of kSmall. A process makes them once.
const std::vector<DracoStream>& small_draco_streams();

}  // namespace psplit
