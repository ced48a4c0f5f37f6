// Encodes one patch, or a whole mesh, as one Draco stream with libdraco: what encoder/stream is compared with.
// Without libdraco (PSPLIT_WITH_DRACO=OFF) each call returns kUsage.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/stream/patch_mesh.h"
#include "encoder/welding/weld.h"
#include "psplit/base.h"
#include "psplit/encode.h"

namespace psplit {

// Debian's libdraco for 64-bit ARM fuses multiply-adds. So its encoder rounds a few values to the step beside
// that of other machines.
#if defined(__aarch64__)
inline constexpr bool kLibdracoFuses = true;
#else
inline constexpr bool kLibdracoFuses = false;
#endif

// What encode_stream does, by libdraco's encoder and decoder.
Expected<EncodedPatch> encode_edgebreaker(const WeldedMesh& welded, const PatchMesh& patch,
                                          std::span<const AttributeCoding> codings, int encode_speed,
                                          bool with_values = false);
// What write_sequential_stream does, by libdraco's encoder.
Expected<std::vector<uint8_t>> encode_sequential(const WeldedMesh& welded, const PatchMesh& patch,
                                                 std::span<const AttributeCoding> codings, int encode_speed);

// About the memory that libdraco's encoder takes to count the symbols of an attribute: it has an entry for
// every number up to the largest symbol. At speeds 0 and 1, which compare predictions, it takes eight times as
// much (measured: 7.5). 0 if no grid has enough bits for more than 64 MB.
uint64_t symbol_table_bytes(const WeldedMesh& welded, const PatchMesh& patch,
                            std::span<const AttributeCoding> codings, int encode_speed);

}  // namespace psplit
