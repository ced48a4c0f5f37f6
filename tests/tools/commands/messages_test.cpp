#include "tools/gltf_psplit/commands/messages.h"

#include <gtest/gtest.h>

#include <limits>

namespace psplit {
namespace {

TEST(Messages, WritesNumbersForPeople) {
  EXPECT_EQ(with_separators(0), "0");
  EXPECT_EQ(with_separators(999), "999");
  EXPECT_EQ(with_separators(1000), "1,000");
  EXPECT_EQ(with_separators(1234567), "1,234,567");
  EXPECT_EQ(with_decimals(3.14159, 2), "3.14");
  EXPECT_EQ(with_decimals(std::numeric_limits<double>::infinity(), 2), "-");
  EXPECT_EQ(as_percent(0.0321), "+3.2 %");
  EXPECT_EQ(as_percent(-0.5), "-50.0 %");
  EXPECT_EQ(as_duration(12.34), "12.3 ms");
  EXPECT_EQ(as_duration(4560), "4.56 s");
  EXPECT_EQ(counted(1, "patch"), "1 patch");
  EXPECT_EQ(counted(2000, "patch"), "2,000 patches");
  EXPECT_EQ(counted(0, "face"), "0 faces");
}

TEST(Messages, AlignsTables) {
  TextTable table({"codec", "bytes"});
  table.add({"a", "12345"});
  table.add({"longer", "1"});
  EXPECT_EQ(table.to_string(),
            "codec   bytes\n"
            "a       12345\n"
            "longer      1\n");
}

TEST(Messages, KeepsColumnsOfTables) {
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

}  // namespace
}  // namespace psplit
