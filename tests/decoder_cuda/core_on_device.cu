// That nvcc takes the core for a device as it is. Built where there is a toolkit, never run.
#include <new>

#include "decoder_cuda/warp_lanes.cuh"
#include "src/core/bit_groups.h"
#include "src/core/stitch.h"

namespace psplit::core {

__global__ void decode_one_patch(const uint8_t* stream, size_t stream_bytes, uint8_t* memory,
                                 size_t memory_bytes, Patch<uint16_t>* patch, Fault* fault) {
  StreamHeader header;
  Arena arena(memory, memory_bytes);
  *fault = read_stream_header(stream, stream_bytes, header);
  if (*fault == Fault::kNone) *fault = decode_patch<uint16_t>(header, arena, *patch);
  View<uint16_t> walk;
  if (*fault == Fault::kNone) *fault = walk_border(*patch, arena, walk);
}

__global__ void decode_by_warp(const StreamHeader* header, Arena* arena, PatchDecoder<uint16_t>* decoder,
                               Patch<uint16_t>* patch, uint8_t* values, Fault* fault) {
  const WarpLanes lanes;
  if (lanes.rank() == 0) new (decoder) PatchDecoder<uint16_t>(*header, *arena, *patch);
  lanes.sync();
  const Fault decoded = decode_together(lanes, *decoder);
  if (lanes.rank() == 0) *fault = decoded;
  if (decoded != Fault::kNone || patch->attributes.empty()) return;
  const Attribute<uint16_t>& attribute = patch->attributes[0];
  patch->write_values(lanes, attribute, [&](uint32_t point) { return values + point * attribute.stride(); });
}

__global__ void cooperate(const uint8_t* stream, size_t stream_bytes, View<uint32_t> values,
                          View<uint16_t> counts, Fault* fault) {
  const WarpLanes lanes;
  fill(lanes, counts, uint16_t{1});
  const uint32_t group_count = scan_array(lanes, counts);
  const uint64_t most = reduce_max(lanes, uint64_t{values[lanes.rank()]});
  const uint32_t components = broadcast(lanes, static_cast<uint32_t>(most), 0);
  ByteReader reader(stream, stream_bytes);
  const View<const uint32_t> tags(values.data(), group_count);
  const Fault tagged = read_tagged(lanes, reader, tags, components, values);
  if (lanes.rank() == 0) *fault = tagged;
}

}  // namespace psplit::core
