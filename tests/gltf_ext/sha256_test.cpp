#include "gltf_ext/sha256.h"

#include <gtest/gtest.h>

namespace psplit {
namespace {

std::string hash(std::string_view text) {
  Sha256 sha;
  sha.add(text);
  return sha.hex();
}

// The examples that NIST publishes with the standard, and the empty message.
TEST(Sha256, IsThatOfTheStandard) {
  EXPECT_EQ(hash(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(hash("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(hash("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(hash(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, DoesNotCareWhereItIsCut) {
  const std::string text(300, 'x');
  for (size_t cut = 0; cut <= text.size(); ++cut) {
    Sha256 sha;
    sha.add(text.substr(0, cut));
    sha.add(text.substr(cut));
    EXPECT_EQ(sha.hex(), hash(text)) << cut;
  }
}

TEST(Sha256, FramesKeepPartsApart) {
  Sha256 a, b;
  a.add_framed("ab");
  a.add_framed("c");
  b.add_framed("a");
  b.add_framed("bc");
  EXPECT_NE(a.hex(), b.hex());
}

}  // namespace
}  // namespace psplit
