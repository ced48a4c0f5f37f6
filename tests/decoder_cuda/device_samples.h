// Containers for the tests of devices, and devices with little memory.
#pragma once

#include <gtest/gtest.h>

#include "encoder/coding/quantization.h"
#include "encoder/encode_mesh.h"
#include "src/container/patch_container.h"
#include "tests/decoder_cuda/emulated_device.h"
#include "tests/support/expect.h"
#include "tests/support/patched_samples.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {

inline PatchContainer opened(std::span<const uint8_t> bytes) {
  PatchContainer container = must(open_container(bytes));
  return container;
}

// A grid of `side` * `side` quads with `attribute_count` attributes beside POSITION, all on grids of 12 bits.
inline PatchedSample grid_sample(uint32_t side, uint32_t patch_count, uint32_t attribute_count,
                                 const ThreadPool& pool, int speed = 5) {
  Mesh mesh = make_grid(side, side);
  for (uint32_t k = 0; k < attribute_count; ++k) {
    std::vector<float> values(mesh.point_count);
    for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i * (k + 1) % 101);
    mesh.attributes.push_back(
        make_attribute("_A" + std::to_string(k), ComponentType::kFloat32, 1, false, values));
  }
  std::vector<AttributeCoding> codings;
  for (const Attribute& attribute : mesh.attributes) codings.push_back(*fit_grid(attribute, 12));
  const StreamOptions options{.patch_count = patch_count, .encode_speed = speed, .verify = false};
  return encode_sample("grid", mesh, codings, options, pool);
}

// Limits the memory of emulated devices during its lifetime.
struct ShortMemory {
  explicit ShortMemory(size_t bytes) { EmulatedDevice::memory() = bytes; }
  ~ShortMemory() { EmulatedDevice::memory() = ~size_t{0}; }
  ShortMemory(const ShortMemory&) = delete;
  ShortMemory& operator=(const ShortMemory&) = delete;
};

}  // namespace psplit
