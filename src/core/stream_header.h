// The front of a stream of either kind.
#pragma once

#include "src/core/condensed/condensed_stream.h"
#include "src/core/draco_header.h"

namespace psplit::core {

// The kinds of streams that code is compiled for. A kernel for one kind is smaller and needs fewer registers
// than one for both.
#if !defined(PSPLIT_WITHOUT_CONDENSED)
inline constexpr bool kReadsCondensed = true;
enum class StreamKinds : uint8_t { kBoth, kDraco, kCondensed };
#else
// A small module for the web: the container's reader refuses condensed streams, so that none reaches the core.
inline constexpr bool kReadsCondensed = false;
enum class StreamKinds : uint8_t { kDraco, kCondensed, kBoth = kDraco };
#endif

// What a PatchDecoder is started with: read_stream_header reads it from a Draco stream, and
// read_condensed_header (condensed/condensed_header.h) from a condensed stream and its skeleton. Then `body`
// reads the skeleton.
struct StreamHeader : DracoHeader {
  CondensedStream condensed;  // without bytes for a Draco stream

  PSPLIT_HD bool is_condensed() const { return kReadsCondensed && !condensed.bytes.empty(); }
  // Like is_condensed(), but a constant for the compiler if all streams are of one kind.
  template <StreamKinds kKinds>
  PSPLIT_HD bool is_condensed_of() const {
    return kKinds == StreamKinds::kBoth ? is_condensed() : kKinds == StreamKinds::kCondensed;
  }
};

}  // namespace psplit::core
