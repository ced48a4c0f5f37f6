#include "system/uri.h"

#include <fstream>

#include "tests/support/environment.h"
#include "tests/support/expect.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// The bytes as text, or the error.
std::string data_of(const std::string& uri) {
  const Expected<std::vector<uint8_t>> bytes = decode_data_uri(uri);
  return bytes ? std::string(bytes->begin(), bytes->end()) : "error: " + bytes.status().message();
}

TEST(Uri, PercentCodingRoundTrips) {
  EXPECT_EQ(percent_decode(percent_encode("a b/%\xC3\xA9")), "a b/%\xC3\xA9");
  EXPECT_EQ(percent_decode("100%"), "100%");
  EXPECT_EQ(percent_decode("%zz%4"), "%zz%4");
}

// The text "<?>~psplit" has all that the two alphabets write differently.
TEST(Uri, Base64IsReadAsBrowsersReadIt) {
  for (const char* data : {"PD8+fnBzcGxpdA==", "PD8+fnBzcGxpdA", "PD8+fnBzcGxpdA=", "PD8-fnBzcGxpdA==",
                           "PD8+\nfnBz\r\ncGxp\r\ndA==\n", " PD8+ fnBz\tcGxp\fdA = = ", "PD8+fnBzcGxpdA%3D%3D",
                           "PD8%2BfnBz%0AcGxp%0D%0AdA==", "PD8+fnBzcGxpdB=="})
    for (const char* head : {"data:;base64,", "data:application/octet-stream;base64,", "DATA:;BASE64,",
                             "data:a/b;charset=utf-8;base64,", "data:a/b; base64 ,", "\n data:\n;base64,"})
      EXPECT_EQ(data_of(std::string(head) + data), "<?>~psplit") << head << data;
  EXPECT_EQ(data_of("data:;base64,____"), "\xff\xff\xff");
  EXPECT_EQ(data_of("data:;base64,"), "");
  EXPECT_EQ(data_of("data:;base64, = "), "");
}

TEST(Uri, WhatIsWrongInDataIsSaid) {
  EXPECT_EQ(data_of("data:;base64,YWJ*"), "error: character 4 of the data is not base64");
  EXPECT_EQ(data_of("data:;base64,YW\xC2\xA0Jj"), "error: character 3 of the data is not base64");
  EXPECT_EQ(data_of("data:;base64,YQ==YQ=="), "error: character 5 of the data is after the end of base64");
  EXPECT_EQ(data_of("data:;base64,YWJjZ"), "error: base64 data ends early");
  EXPECT_EQ(data_of("data:;base64"), "error: a data URI without data");
  EXPECT_EQ(data_of("data:;notbase64,YWJj"), "YWJj");
  EXPECT_EQ(data_of("data:,a%20b\n%0Ac"), "a b\nc");
}

TEST(Uri, NamesAreFoundAsTheyAreWritten) {
  const TestFolder folder;
  fs::create_directories(folder / "in");
  fs::create_directories(folder / "in/b c");
  const auto path = [&](const char* uri) { return path_of_uri(uri, folder / "in").generic_string(); };
  const auto write = [&](const char* name) { std::ofstream(folder / "in" / name) << "x"; };
  write("a%20b.bin");
  EXPECT_EQ(path("a%20b.bin"), "a%20b.bin") << "only the file of this literal name is there";
  EXPECT_EQ(path("a%2520b.bin"), "a%20b.bin");
  write("a b.bin");
  EXPECT_EQ(path("a%20b.bin"), "a b.bin") << "a URI is first of all a URI";
  EXPECT_EQ(path("a b.bin"), "a b.bin");
  EXPECT_EQ(path("missing%20x.bin"), "missing x.bin");

  write("b c/t%C3%A9#1.png");
  EXPECT_EQ(path("b c\\t%C3%A9#1.png"), "b c/t%C3%A9#1.png");
  write("n#1.png");
  EXPECT_EQ(path("n#1.png"), "n#1.png");
  EXPECT_EQ(path("n%231.png"), "n#1.png");
  write("plain.png");
  for (const char* uri : {"plain.png?v=1", "plain.png#x", "plain.png?a#b", " plain.png\n", "./plain.png"})
    EXPECT_EQ(path(uri), "plain.png") << uri;
  write("p+q.png");
  EXPECT_EQ(path("p+q.png"), "p+q.png");
  EXPECT_EQ(path("p%2Bq.png"), "p+q.png");
  write("100%.png");
  EXPECT_EQ(path("100%.png"), "100%.png");
  EXPECT_EQ(path("100%25.png"), "100%.png");
  if (is_posix()) {
    write("q?.png");
    EXPECT_EQ(path("q?.png"), "q?.png");
    write("r\\s.png");
    EXPECT_EQ(path("r\\s.png"), "r\\s.png") << "no folder r";
  }
}

TEST(Uri, NoReadingLeavesTheFolder) {
  const TestFolder folder;
  fs::create_directories(folder / "in");
  std::ofstream(folder / "x") << "x";
  for (const char* uri : {"../x", "%2e%2e/x", "..%2Fx", "..\\x", "..%5Cx", "../x?v", " ../x", "in/../../x#y",
                          "/x", "file:///x", "FILE:///x", " file:///x", "C:\\x", "\\\\server\\x"})
    EXPECT_EQ(relative_path_of_uri(uri, folder / "in").status().code(), StatusCode::kUnsupported) << uri;
}

}  // namespace
}  // namespace psplit
