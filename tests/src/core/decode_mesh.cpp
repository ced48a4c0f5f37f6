#include "tests/src/core/decode_mesh.h"

namespace psplit::core {

template <typename Index>
Fault decode(const StreamHeader& header, RawMesh& out) {
  return decode<Index>(
      [&](Arena& arena, Patch<Index>& patch) { return decode_patch<Index>(header, arena, patch); }, kOneLane,
      out);
}

template <typename Index>
Fault decode_by_warp(const StreamHeader& header, LaneOrder order, RawMesh& out) {
  const auto run = [&](auto body) { run_warp([&](EmulatedLanes lanes) { body(lanes); }, order); };
  const auto decode_with = [&](Arena& arena, Patch<Index>& patch) {
    PatchDecoder<Index> decoder(header, arena, patch);
    Fault faults[EmulatedLanes::size()];
    run([&](auto lanes) {
      const Fault fault = decoder.start(lanes);
      faults[lanes.rank()] = fault == Fault::kNone ? finish_together(lanes, decoder) : fault;
    });
    for (const Fault fault : faults) EXPECT_EQ(fault_text(fault), fault_text(faults[0])) << "lanes disagree";
    return faults[0];
  };
  return decode<Index>(decode_with, run, out);
}

template <typename Index>
Fault decode_in_workspace(const StreamHeader& header, size_t stream_bytes, const RawMesh& expected,
                          RawMesh& out) {
  ValueCounts values{expected.point_count, static_cast<uint32_t>(expected.attributes.size()), 0};
  for (const RawAttribute& attribute : expected.attributes)
    values.components += static_cast<uint32_t>(attribute.component_count);
  std::vector<uint8_t> memory(workspace_bytes<Index>(header, stream_bytes, values));
  Arena arena(memory.data(), memory.size());
  const auto patch = std::make_unique<Patch<Index>>();
  if (const Fault fault = decode_patch<Index>(header, arena, *patch); fault != Fault::kNone) return fault;
  out = raw_mesh(*patch);
  return expect_walk_by_definition(*patch, arena);
}

#define PSPLIT_DECODE_WITH(Index)                                                 \
  template Fault decode<Index>(const StreamHeader&, RawMesh&);                    \
  template Fault decode_by_warp<Index>(const StreamHeader&, LaneOrder, RawMesh&); \
  template Fault decode_in_workspace<Index>(const StreamHeader&, size_t, const RawMesh&, RawMesh&);
PSPLIT_DECODE_WITH(uint16_t)
PSPLIT_DECODE_WITH(uint32_t)
#undef PSPLIT_DECODE_WITH

void InStep::expect_as_alone(const StreamHeader (&headers)[kCount]) {
  Arena arenas[kCount];
  std::optional<PatchDecoder<uint16_t>> decoders[kCount];
  PatchDecoder<uint16_t>* pointers[kCount];
  Fault faults[kCount];
  for (uint32_t n = 0; n < kCount; ++n) {
    arenas[n] = Arena(&memory_[n * kMemory], kMemory);
    patches_[n] = {};
    pointers[n] = &decoders[n].emplace(headers[n], arenas[n], patches_[n]);
  }
  decode_in_step(pointers, faults);
  for (uint32_t n = 0; n < kCount; ++n) {
    RawMesh alone;
    ASSERT_EQ(fault_text(decode<uint16_t>(headers[n], alone)), fault_text(faults[n]));
    const bool is_whole = faults[n] == Fault::kNone;
    ASSERT_TRUE(!is_whole || raw_mesh(patches_[n]) == alone);
    ++(is_whole ? whole : broken);
  }
}

}  // namespace psplit::core
