#include "mesh_files/plain_rows.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <random>

#include "mesh_files/plain_numbers.h"
#include "mesh_files/ply.h"
#include "tests/mesh_files/mesh_text.h"

namespace psplit {
namespace {

// What the C library makes of the same text, bit for bit. Numbers near the middle of two floats are among them.
TEST(ParseFloat, RoundsAsTheStandardLibrary) {
  std::mt19937 random(1);
  int plain_count = 0;
  for (int i = 0; i < 200'000; ++i) {
    char text[64];
    const auto bits = static_cast<uint32_t>(random());
    float value = 0;
    std::memcpy(&value, &bits, sizeof value);
    if (!std::isfinite(value)) continue;
    if (i % 2 == 0)
      value = std::ldexp(static_cast<float>(random() % 2'000'001) - 1e6f, static_cast<int>(random() % 40) - 30);
    const float next = std::nextafter(value, HUGE_VALF);
    const double middle = 0.5 * (double{value} + double{next});
    switch (random() % 4) {
      case 0: std::snprintf(text, sizeof text, "%.*g", static_cast<int>(random() % 12), double{value}); break;
      case 1:
        std::snprintf(text, sizeof text, "%.*f", static_cast<int>(random() % 9), std::fmod(double{value}, 1e6));
        break;
      case 2: std::snprintf(text, sizeof text, "%.*g", 15 + static_cast<int>(random() % 3), middle); break;
      default: std::snprintf(text, sizeof text, "%.*e", static_cast<int>(random() % 10), double{value}); break;
    }
    const std::string_view word(text);
    const float expected = std::strtof(text, nullptr);
    const std::optional<float> read = parse_float(word);
    ASSERT_TRUE(read) << word;
    EXPECT_EQ(std::memcmp(&*read, &expected, sizeof expected), 0) << word << ' ' << *read << ' ' << expected;
    float plain = 0;
    const bool is_plain = parse_plain_float(text, text + word.size(), plain) == text + word.size();
    plain_count += is_plain ? 1 : 0;
    // Eight characters are taken at once, where eight are left.
    const std::string row = std::string(word) + " 12345678 9\n";
    const char* const end = parse_plain_float(row.data(), row.data() + row.size(), plain);
    ASSERT_EQ(end, is_plain ? row.data() + word.size() : nullptr) << word;
    if (is_plain) {
      EXPECT_EQ(std::memcmp(&plain, &expected, sizeof expected), 0) << word << ' ' << plain;
    }
  }
  EXPECT_GT(plain_count, 50'000);
  for (const char* word : {"", "-", ".", "+-1", "1e", "1e+", "1.2.3", "0x1", "1 ", "--1", "e5"})
    EXPECT_FALSE(parse_float(word)) << word;
  EXPECT_EQ(parse_float("-0").value(), 0.0f);
  EXPECT_TRUE(std::signbit(parse_float("-0").value()));
}

TEST(ParseFloat, KnowsWhatLibrariesPrintForNoNumber) {
  for (const char* word : {"nan",        "NaN",  "-nan",  "+NAN",    "nan(ind)",     "-nan(ind)", "NaN(snan)",
                           "nan(0x7ff)", "NaNQ", "nans",  "1.#QNAN", "-1.#IND",      "1.#IND000", "1.#SNAN",
                           "-1.#QNAN0",  "1.#J", "-1.#J", "1.#R",    "1.#QNANe+000", "+1.#qnan"}) {
    EXPECT_TRUE(std::isnan(parse_float(word).value_or(0))) << word;
    EXPECT_TRUE(std::isnan(parse_double(word).value_or(0))) << word;
  }
  for (const char* word : {"inf", "Infinity", "+INF", "1.#INF", "1.#inf00", "+1.#INF", "1.#INF00e+000"}) {
    EXPECT_EQ(parse_float(word), std::optional(HUGE_VALF)) << word;
    EXPECT_EQ(parse_double(word), std::optional(HUGE_VAL)) << word;
    if (word[0] != '+') {
      EXPECT_EQ(parse_double("-" + std::string(word)), std::optional(-HUGE_VAL)) << word;
    }
  }
  for (const char* word : {"1.#", "1.#1", "1.#.", "2.#IND", "1#IND", "1.#IN D", "1.#IND!", "nan(", "nan)",
                           "nan(-)", "nano", "--1.#IND", "#IND"})
    EXPECT_FALSE(parse_float(word)) << word;
}

TEST(ParseInteger, TakesDigitsAfterASign) {
  EXPECT_EQ(parse_integer("0"), 0);
  EXPECT_EQ(parse_integer("000123456789"), 123456789);
  EXPECT_EQ(parse_integer("999999999"), 999999999);
  EXPECT_EQ(parse_integer("4294967296"), 4294967296);
  EXPECT_EQ(parse_integer("-7"), -7);
  EXPECT_EQ(parse_integer("+7"), 7);
  for (const char* word : {"", "-", "1.0", "7x", "99999999999999999999"})
    EXPECT_FALSE(parse_integer(word)) << word;
}

// Up to nine digits, whatever comes after them.
TEST(ParseInteger, OfARowEndsWithItsDigits) {
  std::mt19937 random(1);
  for (size_t digits = 0; digits <= 11; ++digits)
    for (int after = 0; after < 256; ++after) {
      if (after >= '0' && after <= '9') continue;
      std::string row;
      for (size_t i = 0; i < digits; ++i) row += static_cast<char>('0' + random() % 10);
      row += std::string{static_cast<char>(after), static_cast<char>(random())} + "12345678";
      uint32_t value = 0;
      const char* const end = parse_plain_integer(row.data(), row.data() + row.size(), value);
      const bool is_plain = digits >= 1 && digits <= 9;
      ASSERT_EQ(end, is_plain ? row.data() + digits : nullptr) << row;
      if (is_plain) {
        ASSERT_EQ(value, std::stoul(row)) << row;
      }
    }
}

constexpr uint32_t kPoints = 30'000, kFaces = 50'000;

// A text with rows of every kind. With `plain`, all of them are plain.
std::string text_of(bool plain) {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex " + std::to_string(kPoints) +
      "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar "
      "green\nproperty uchar blue\nelement face " +
      std::to_string(kFaces) + "\nproperty list uchar int vertex_indices\nend_header\n";
  const auto odd = [&](uint32_t i, uint32_t step) { return !plain && i % step == step - 1; };
  for (uint32_t i = 0; i < kPoints; ++i) {
    text += odd(i, 997) ? "\n\t" : "";
    text +=
        std::to_string(i) + (odd(i, 1201) ? ".5e+0 " : ".5 ") + (odd(i, 4001) ? "\n" : "") + "-1e-3  0.25\t";
    text += std::to_string(i % 256) + (odd(i, 7001) ? " 1.0" : " 1") + " 255" + (odd(i, 13) ? " \r\n" : "\n");
  }
  for (uint32_t i = 0; i < kFaces; ++i) {
    const uint32_t a = i % (kPoints - 3);
    text += odd(i, 5003) ? "4 " + std::to_string(a + 3) + ' ' : "3 ";
    text += std::to_string(a) + ' ' + (odd(i, 6007) ? "+" : "") + std::to_string(a + 1) + ' ' +
            std::to_string(a + 2);
    text += odd(i, 7) ? "  \n" : "\n";
  }
  return text;
}

TEST(PlainRows, AreWhatOneWordAfterTheOtherSays) {
  for (const bool plain : {true, false}) {
    const std::string text = text_of(plain);
    for (const int threads : {1, 3}) {
      Expected<Scanner> scanner = open_scanner(memory_stream(bytes_of(text)));
      ASSERT_TRUE(scanner.ok());
      const MeshFile file = must(read_ply(*scanner, ThreadPool(threads)));
      const Mesh& mesh = file.objects.at(0).parts.at(0).mesh;
      ASSERT_EQ(mesh.point_count, kPoints);
      std::vector<float> positions(size_t{3} * kPoints);
      ASSERT_EQ(mesh.attributes[0].values.size(), positions.size() * sizeof(float));
      std::memcpy(positions.data(), mesh.attributes[0].values.data(), positions.size() * sizeof(float));
      for (uint32_t i = 0; i < kPoints; ++i) {
        ASSERT_EQ(positions[3 * i], static_cast<float>(i) + 0.5f);
        ASSERT_EQ(positions[3 * i + 1], -1e-3f);
        ASSERT_EQ(positions[3 * i + 2], 0.25f);
        const std::byte* const color = mesh.attributes[1].values.data() + 3 * i;
        ASSERT_EQ(color[0], static_cast<std::byte>(i % 256));
        ASSERT_EQ(color[1], std::byte{1});
        ASSERT_EQ(color[2], std::byte{255});
      }
      size_t next = 0;
      for (uint32_t i = 0; i < kFaces; ++i) {
        const uint32_t a = i % (kPoints - 3);
        if (!plain && i % 5003 == 5002) {
          next += 2;
          continue;
        }
        ASSERT_EQ(mesh.faces[next++], (std::array<uint32_t, 3>{a, a + 1, a + 2})) << i;
      }
      EXPECT_EQ(next, mesh.faces.size());
    }
  }
}

TEST(PlainRows, ErrorsNameTheLine) {
  const auto error_of = [](std::string text, const std::string& row, const std::string& with) {
    const size_t at = text.find(row);
    EXPECT_NE(at, std::string::npos);
    const auto line = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n') + 1;
    text.replace(at, row.size(), with);
    EXPECT_TRUE(message_of(text).starts_with("line " + std::to_string(line))) << message_of(text);
    return message_of(text);
  };
  const std::string text = text_of(true);
  error_of(text, "20000.5 -1e-3", "20000.5.5 -1e-3");
  error_of(text, "20000.5 -1e-3", "nan -1e-3");
  EXPECT_NE(error_of(text, "3 20000 20001 20002", "3 20000 30000 1").find("vertex 30000"), std::string::npos);
  EXPECT_NE(error_of(text, "3 20000 20001 20002", "3 20000 1 2 3").find("more than the header"),
            std::string::npos);
}

}  // namespace
}  // namespace psplit
