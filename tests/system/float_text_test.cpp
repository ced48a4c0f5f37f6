// Numbers are read as by std::from_chars, also where a library has none for floats.
#include "system/float_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <string>

namespace psplit {
namespace {

template <typename T>
void expect_same(const std::string& text) {
  SCOPED_TRACE(text);
  const char *const begin = text.data(), *const end = begin + text.size();
  T usual = -7, by_stream = -7;
  const std::from_chars_result a = read_float(begin, end, usual),
                               b = read_float_by_stream(begin, end, by_stream);
  EXPECT_EQ(a.ptr - begin, b.ptr - begin);
  if (usual == usual && std::fpclassify(usual) == FP_SUBNORMAL && b.ec == std::errc::result_out_of_range)
    return;
  EXPECT_EQ(a.ec, b.ec);
  if (std::isnan(usual))
    EXPECT_TRUE(std::isnan(by_stream));
  else
    EXPECT_EQ(usual, by_stream);
}

void expect_both(const std::string& text) {
  expect_same<float>(text);
  expect_same<double>(text);
}

TEST(FloatText, OddFormsAreReadAlike) {
  for (const char* text : {"",
                           "-",
                           "+1",
                           " 1",
                           "1 ",
                           "1.",
                           ".5",
                           ".",
                           "-.5e1",
                           "-.",
                           "1e",
                           "1e+",
                           "1e-",
                           "1e5x",
                           "1E5",
                           "1e+05",
                           "0x1p3",
                           "1_000",
                           "1,5",
                           "1.5.5",
                           "--1",
                           "inf",
                           "-inf",
                           "INF",
                           "infinity",
                           "infinit",
                           "nan",
                           "-nan",
                           "NaN",
                           "1e400",
                           "-1e400",
                           "1e-400",
                           "1e39",
                           "0e999999",
                           "00012",
                           "-0",
                           "3.4028236e38",
                           "1.17549435e-38",
                           "9007199254740993",
                           "0.1e1.5",
                           "e5",
                           "i",
                           "n"})
    expect_both(text);
}

TEST(FloatText, RandomNumbersAreReadAlike) {
  std::mt19937_64 random(1);
  constexpr char kCharacters[] = "0123456789.e-+";
  for (int round = 0; round < 20000; ++round) {
    std::string text;
    for (size_t length = 1 + random() % 24; text.size() < length;)
      text += kCharacters[random() % (sizeof kCharacters - 1)];
    expect_both(text);
  }
  for (int round = 0; round < 20000; ++round) {
    const auto digits = static_cast<double>(random());
    char text[64];
    std::snprintf(text, sizeof text, "%.17g", std::ldexp(digits, static_cast<int>(random() % 200) - 160));
    expect_both(text);
  }
}

}  // namespace
}  // namespace psplit
