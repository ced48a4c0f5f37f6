#include "src/core/corner_table.h"

#include <gtest/gtest.h>

#include <vector>

namespace psplit::core {
namespace {

template <typename Index>
void expect_own_value_for_each_face(uint32_t face_count) {
  std::vector<uint8_t> memory(FaceValues<Index, uint32_t>::bytes(face_count));
  Arena arena(memory.data(), memory.size());
  FaceValues<Index, uint32_t> values;
  ASSERT_TRUE(values.take(face_count, arena));
  values.of_none() = 7;
  for (uint32_t face = 0; face < face_count; ++face) values.of_face(4 * face) = 100 + face;
  for (uint32_t corner = 0; corner < 4 * face_count; ++corner) {
    ASSERT_EQ(values.of_face(corner), 100 + corner / 4);
    ASSERT_EQ(values.at(corner), 100 + corner / 4);
  }
  EXPECT_EQ(values.at(kNone<Index>), 7u);
  EXPECT_EQ(values.at_signed(FaceValues<Index, uint32_t>::as_signed(kNone<Index>)), 7u);
}

TEST(FaceValues, HasOneForEachFaceAndOneForNone) {
  for (const uint32_t face_count : {1u, 440u, 8191u, 8192u, 8193u, 16383u}) {
    SCOPED_TRACE(face_count);
    expect_own_value_for_each_face<uint16_t>(face_count);
    expect_own_value_for_each_face<uint32_t>(face_count);
  }
  EXPECT_LT((FaceValues<uint16_t, bool>::bytes(440)), 460u);
}

}  // namespace
}  // namespace psplit::core
