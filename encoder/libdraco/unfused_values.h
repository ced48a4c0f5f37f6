// Floats from what libdraco decodes as integers, rounded after each operation. A libdraco that was compiled for
// a machine with fused multiply-adds, as Debian's for 64-bit ARM, gives other bits than all other machines.
#pragma once

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>

#include <cstdint>
#include <memory>
#include <span>

namespace psplit {

// Lets a decoder give the integers of quantized attributes and normals.
void keep_integers(draco::Decoder& decoder);

// Decodes a mesh with libdraco, to floats as of machines that fuse nothing. keep_quantized: to the integers of
// the stream.
draco::StatusOr<std::unique_ptr<draco::Mesh>> decode_unfused(std::span<const uint8_t> stream,
                                                             bool keep_quantized);

// Replaces the floats of quantized attributes and normals in `decoded` by floats that this file calculates from
// `coded`: the stream with its integers.
void set_unfused_values(const draco::PointCloud& coded, draco::PointCloud& decoded);

}  // namespace psplit
