#include "gltf_ext/json/json_text.h"

#include <gtest/gtest.h>

namespace psplit {
namespace {

std::string error_of(const std::string& text) { return parse_json(text).status().message(); }

TEST(JsonText, ErrorsSayWhere) {
  EXPECT_EQ(error_of("{\"a\": 1,\n \"b\": [,]}"), "not valid JSON: line 2, column 8");
  EXPECT_EQ(error_of("{\n"), "not valid JSON: line 2, column 1");
  EXPECT_EQ(error_of("\n\n]"), "not valid JSON: line 3, column 1");
  EXPECT_EQ(error_of("{\"a\": 1,}"), "not valid JSON: byte 9");
  EXPECT_EQ(error_of("{} x"), "not valid JSON: byte 4");
  EXPECT_EQ(error_of("[1"), "not valid JSON: byte 3");
  EXPECT_EQ(error_of(""), "not valid JSON: byte 1");
  EXPECT_EQ(error_of("\xEF\xBB\xBF[1, \xff]"), "not valid JSON: byte 5") << "a byte order mark does not count";
  EXPECT_EQ(error_of("[1e999]"), "the JSON has a number that no double holds");
}

}  // namespace
}  // namespace psplit
