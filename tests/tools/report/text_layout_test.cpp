#include "tools/gltf_psplit/report/text_layout.h"

#include <gtest/gtest.h>

namespace psplit {
namespace {

TEST(TextTable, AlignsColumns) {
  TextTable table({"codec", "bytes"});
  table.add({"a", "12345"});
  table.add({"longer", "1"});
  EXPECT_EQ(table.to_string(),
            "codec   bytes\n"
            "a       12345\n"
            "longer      1\n");
}

TEST(Printable, ShowsWhatATerminalWouldObey) {
  EXPECT_EQ(printable("a\x1b[2Jb\nc\x7f"), "a\\x1B[2Jb\\x0Ac\\x7F");
  EXPECT_EQ(printable("a\tb\nc", true), "a\tb\nc");
  EXPECT_EQ(printable("\xC2\x9B\xC2\xA0\xE6\xBC\xA2"), "\\u009B\xC2\xA0\xE6\xBC\xA2");
}

TEST(TextTable, KeepsNamedColumns) {
  TextTable table({"codec", "patches", "bytes", "file"});
  table.add({"a", "1", "12345", "x.glb"});
  table.add({"longer", "20", "1", "longer.glb"});
  table.align_last_left();
  table.keep_columns(std::vector<std::string>{"codec", "bytes", "file"});
  EXPECT_EQ(table.to_string(),
            "codec   bytes  file\n"
            "a       12345  x.glb\n"
            "longer      1  longer.glb\n");
}

TEST(WrapText, BreaksBetweenWords) {
  EXPECT_EQ(wrap_text("one two  three", 7, 2), "one two\n  three");
  EXPECT_EQ(wrap_text("one", 2, 2), "one");
  EXPECT_EQ(wrap_text("a longest b", 3, 0), "a\nlongest\nb");
  EXPECT_EQ(wrap_text("", 7, 2), "");
}

}  // namespace
}  // namespace psplit
