// fused yes|no: whether the core's arithmetic of values was compiled to fused multiply-adds. It compares the
// values that the core writes with values that are rounded after each operation. Exits with 77 if this
// processor has no such instructions.
//
// tests/CMakeLists.txt compiles it twice for machines that can fuse: with the project's flags, where it may
// not, and with -ffp-contract=fast, which shows that the comparison notices it.
#include <cstdint>
#include <cstdio>
#include <cstring>

#include "src/core/value_writer.h"

namespace {

using namespace psplit::core;  // a program, not a library

constexpr uint32_t kCount = 4096, kBits = 14, kMax = (1u << kBits) - 1;
constexpr float kOrigin[3] = {-0.371f, 12.6f, 0.0917f};
constexpr float kRange = 1.7f;

// A result that is stored is rounded, and is no part of a longer operation.
float rounded(float value) {
  volatile float stored = value;
  return stored;
}

uint32_t different_values(const Attribute<uint16_t>& attribute, const float (&expected)[kCount][3]) {
  static float written[kCount][3];
  const ValueWriter<uint16_t> writer(attribute, psplit::DataType::kFloat32);
  writer.write<true>(
      SerialLanes(), kCount, [](uint32_t point) { return point; },
      [](uint32_t point) { return reinterpret_cast<uint8_t*>(written[point]); });
  uint32_t count = 0;
  for (uint32_t i = 0; i < kCount; ++i) count += std::memcmp(written[i], expected[i], sizeof expected[i]) != 0;
  return count;
}

uint32_t different_positions() {
  static int32_t values[kCount * 4];
  static float expected[kCount][3];
  Attribute<uint16_t> attribute;
  attribute.components = 3;
  attribute.coding = Coding::kQuantized;
  attribute.bits = kBits;
  attribute.range = kRange;
  uint8_t origin[sizeof kOrigin];
  std::memcpy(origin, kOrigin, sizeof kOrigin);
  attribute.origin = origin;
  const float step = rounded(kRange / static_cast<float>(kMax));
  uint32_t random = 1;
  for (uint32_t i = 0; i < kCount; ++i) {
    for (uint32_t k = 0; k < 3; ++k) {
      random = random * 1664525 + 1013904223;
      const auto value = static_cast<int32_t>(random >> (32 - kBits));
      values[i * value_stride(3) + k] = value;
      expected[i][k] = rounded(rounded(static_cast<float>(value) * step) + kOrigin[k]);
    }
  }
  attribute.values = View<int32_t>(values, kCount * 4);
  return different_values(attribute, expected);
}

uint32_t different_normals() {
  static int32_t values[kCount * 2];
  static float expected[kCount][3];
  Attribute<uint16_t> attribute;
  attribute.components = 3;
  attribute.coding = Coding::kNormal;
  attribute.bits = 10;
  attribute.values = View<int32_t>(values, kCount * 2);
  const int32_t largest = (1 << attribute.bits) - 2;
  const float scale = rounded(2.0f / static_cast<float>(largest));
  for (uint32_t i = 0; i < kCount; ++i) {
    // One half of the square, which is not folded.
    const auto s = static_cast<int32_t>(i % 1021) + 1, t = largest / 2;
    values[2 * i] = s;
    values[2 * i + 1] = t;
    const float y = rounded(rounded(static_cast<float>(s) * scale) - 1.0f);
    const float z = rounded(rounded(static_cast<float>(t) * scale) - 1.0f);
    const float x = rounded(rounded(1.0f - (y < 0 ? -y : y)) - (z < 0 ? -z : z));
    const float square = rounded(rounded(rounded(x * x) + rounded(y * y)) + rounded(z * z));
    const float inverse = rounded(1.0f / rounded(__builtin_sqrtf(square)));
    expected[i][0] = rounded(x * inverse);
    expected[i][1] = rounded(y * inverse);
    expected[i][2] = rounded(z * inverse);
  }
  return different_values(attribute, expected);
}

}  // namespace

int main(int, char** arguments) {
#if defined(__x86_64__)
  if (!__builtin_cpu_supports("fma")) return 77;
#endif
  const bool wanted = std::strcmp(arguments[1], "yes") == 0;
  const uint32_t positions = different_positions(), normals = different_normals();
  std::printf("of %u each, fused: %u positions, %u normals\n", kCount, positions, normals);
  return (wanted ? positions > 0 && normals > 0 : positions == 0 && normals == 0) ? 0 : 1;
}
