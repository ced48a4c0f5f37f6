#include "gltf_ext/json/json_text.h"

#include <cmath>

#include "tests/support/expect.h"

namespace psplit {
namespace {

std::string error_of(const std::string& text) { return parse_json(text).status().message(); }

TEST(JsonText, NumbersHaveTheFewestDigits) {
  const std::string text =
      R"({"a":[0.707106709,1.0,-0.0,1e-07,1e+300,12345678901234567,5.0],"b\\\"0.7071067090000001":"0.7071067090000001"})";
  EXPECT_EQ(json_line(must(parse_json(text))), text);
  EXPECT_EQ(json_line(must(parse_json("0.7071067090000001"))), "0.707106709");
  EXPECT_EQ(json_lines(must(parse_json("[0.7071067090000001]"))), "[\n  0.707106709\n]");
  // Floats as glTF has them, in nine digits.
  for (uint32_t i = 0; i < 100000; ++i) {
    const double value = std::round(std::ldexp(static_cast<double>(i * 2654435761u), -32) * 1e9) / 1e9;
    const std::string line = json_line(Json(value));
    ASSERT_LE(line.size(), 12u) << line;
    ASSERT_EQ(must(parse_json(line)).get<double>(), value);
  }
}

TEST(JsonText, IsThatOfTheLibrary) {
  const Json json = {{"none", nullptr},
                     {"flags", {true, false}},
                     {"empty", {{"object", Json::object()}, {"array", Json::array()}}},
                     {"integers", {0, -1, INT64_MIN, INT64_MAX, UINT64_MAX}},
                     {"floats", {0.5, -2.0, 1e-300, std::nan("")}},
                     {"a \"name\" \\ \n\t\x01\x7f", "\xC3\xA4, a broken \xC3 and \xF0\x9F\x98\x80"}};
  EXPECT_EQ(json_line(json), json.dump(-1, ' ', false, Json::error_handler_t::replace));
  EXPECT_EQ(json_lines(json), json.dump(2, ' ', false, Json::error_handler_t::replace));
}

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
