// That nvcc takes the core for a device as it is. Built where there is a toolkit, never run.
#include "src/core/stitch.h"

namespace psplit::core {

__global__ void decode_one_patch(const uint8_t* stream, size_t stream_bytes, uint8_t* memory,
                                 size_t memory_bytes, Patch<uint16_t>* patch, Fault* fault) {
  StreamHeader header;
  Arena arena(memory, memory_bytes);
  *fault = read_stream_header(stream, stream_bytes, header);
  if (*fault == Fault::kNone) *fault = decode_patch<uint16_t>(header, arena, *patch);
  View<uint16_t> walk;
  auto kind = BorderKind::kNoWalk;
  if (*fault == Fault::kNone) *fault = walk_border(*patch, arena, walk, kind);
}

}  // namespace psplit::core
