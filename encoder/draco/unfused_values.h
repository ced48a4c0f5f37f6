// Floats from what libdraco decodes as integers, rounded after each operation. A libdraco that was compiled for
// a machine with fused multiply-adds, as Debian's for 64-bit ARM, gives other bits than those of all other
// machines.
#pragma once

#include <draco/mesh/mesh.h>

namespace psplit {

#if defined(__aarch64__)
inline constexpr bool kLibdracoFuses = true;
#else
inline constexpr bool kLibdracoFuses = false;
#endif

// Replaces the floats of quantized attributes and normals in `decoded` by those that this file calculates from
// `coded`: the same stream, decoded without libdraco's transforms (SetSkipAttributeTransform).
void set_unfused_values(const draco::Mesh& coded, draco::Mesh& decoded);

}  // namespace psplit
