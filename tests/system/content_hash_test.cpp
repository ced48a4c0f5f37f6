#include "system/content_hash.h"

#include <gtest/gtest.h>

namespace psplit {
namespace {

std::string hash(std::string_view text) {
  ContentHash hash;
  hash.add({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
  return hash.hex();
}

// The digits that `xxhsum -H2` prints: names of files must not change from one build to another.
TEST(ContentHash, IsXxh3Of128Bits) {
  EXPECT_EQ(hash(""), "99aa06d3014798d86001c324468d497f");
  EXPECT_EQ(hash("abc"), "06b05ab6733a618578af5f94892f3950");
}

TEST(ContentHash, FramesKeepPartsApart) {
  ContentHash a, b;
  a.add_framed("ab");
  a.add_framed("c");
  b.add_framed("a");
  b.add_framed("bc");
  EXPECT_NE(a.hex(), b.hex());
}

}  // namespace
}  // namespace psplit
