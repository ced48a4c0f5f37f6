#include <gtest/gtest.h>

#include <array>
#include <random>

#include "psplit/mesh.h"

namespace psplit {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity(),
                kNan = std::numeric_limits<float>::quiet_NaN();
using Doubles = std::vector<double>;

ValueBounds bounds_of(size_t components, const std::vector<float>& values) {
  ValueBounds bounds;
  const size_t stride = components * sizeof(float);
  bounds.add(ComponentType::kFloat32, components, reinterpret_cast<const std::byte*>(values.data()),
             values.size() / components, stride);
  bounds.finish();
  return bounds;
}

TEST(ValueBounds, LeaveOutWhatIsNotFinite) {
  for (const float strange : {kInfinity, -kInfinity, kNan}) {
    const ValueBounds three = bounds_of(3, {strange, 5, strange, -2, 7, strange, 4, strange, strange});
    EXPECT_EQ(three.least, (Doubles{-2, 5, 0}));
    EXPECT_EQ(three.most, (Doubles{4, 7, 0}));
    const ValueBounds two = bounds_of(2, {strange, -3, -1, strange});
    EXPECT_EQ(two.least, (Doubles{-1, -3}));
    EXPECT_EQ(two.most, (Doubles{-1, -3}));
  }
}

TEST(ValueBounds, AreThoseOfEachComponent) {
  std::mt19937 random(1);
  for (const size_t components : {1u, 2u, 3u, 4u, 9u})
    for (size_t count = 1; count < 40; ++count) {
      std::vector<float> values(components * count);
      for (float& value : values) value = std::uniform_real_distribution<float>(-9, 9)(random);
      const ValueBounds bounds = bounds_of(components, values);
      for (size_t c = 0; c < components; ++c) {
        double least = 10, most = -10;
        for (size_t i = c; i < values.size(); i += components) {
          least = std::min(least, static_cast<double>(values[i]));
          most = std::max(most, static_cast<double>(values[i]));
        }
        EXPECT_EQ(bounds.least[c], least) << components << ' ' << count;
        EXPECT_EQ(bounds.most[c], most) << components << ' ' << count;
      }
    }
}

TEST(ValueBounds, OfIntegersWithAStrideAddUp) {
  const std::array<uint16_t, 12> values = {9, 2, 65535, 1, 8, 3, 0, 1, 4, 4, 7, 1};
  ValueBounds bounds;
  const auto* bytes = reinterpret_cast<const std::byte*>(values.data());
  bounds.add(ComponentType::kUint16, 3, bytes, 1, 8);
  bounds.add(ComponentType::kUint16, 3, bytes + 8, 2, 8);
  bounds.finish();
  EXPECT_EQ(bounds.least, (Doubles{4, 2, 0}));
  EXPECT_EQ(bounds.most, (Doubles{9, 4, 65535}));
}

}  // namespace
}  // namespace psplit
