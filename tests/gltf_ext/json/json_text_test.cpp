#include "gltf_ext/json/json_text.h"

#include <bit>
#include <cmath>
#include <random>

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
  // Numbers of all sizes: the library's text, unless that has more digits than are needed.
  std::mt19937_64 random(1);
  for (int i = 0; i < 200000; ++i) {
    const uint64_t bits = random();
    double value = std::bit_cast<double>(bits);
    if (i % 2 == 0)
      value = static_cast<float>(std::ldexp(static_cast<double>(bits), static_cast<int>(bits % 96) - 110));
    if (!std::isfinite(value)) continue;
    const std::string line = json_line(value), theirs = Json(value).dump();
    ASSERT_EQ(must(parse_json(line)).get<double>(), value);
    if (line != theirs) {
      ASSERT_LE(line.size(), theirs.size());
      ASSERT_GE(theirs.size(), 15u) << theirs;
    }
  }
}

TEST(JsonText, HasLimits) {
  const auto nested = [](size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); };
  EXPECT_EQ(error_of(nested(kMaxJsonDepth)), "");
  EXPECT_EQ(error_of(nested(kMaxJsonDepth + 1)), "the JSON nests too deeply");
  const auto object = [](int members) {
    std::string text = "{";
    for (int i = 0; i < members; ++i) text += (i > 0 ? ",\"" : "\"") + std::to_string(i) + "\":[{}]";
    return text + "}";
  };
  EXPECT_EQ(error_of(object(16384)), "");
  EXPECT_EQ(error_of(object(16385)), "a JSON object has over 16384 members");
  EXPECT_EQ(json_line(must(parse_json(R"({"a":{"b":1},"c":[[2,{}]],"a":{"d":[]}})"))),
            R"({"a":{"d":[]},"c":[[2,{}]]})");
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
