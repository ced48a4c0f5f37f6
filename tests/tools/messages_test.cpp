#include "tools/gltf_psplit/messages.h"

#include <gtest/gtest.h>

#include <limits>

#include "tools/gltf_psplit/progress.h"

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

TEST(Progress, ShowsABarOnlyWhereThereAreSteps) {
  EXPECT_EQ(progress_line("encoding", 0, 0, 1.25), "encoding 1.2 s");
  EXPECT_EQ(progress_line("encoding", 0, 1, 2), "encoding 2.0 s");
  EXPECT_EQ(progress_line("encoding", 1, 2, 3), "encoding [###############...............] 1/2 3.0 s");
  EXPECT_EQ(progress_line("encoding", 5, 2, 3), "encoding [##############################] 5/2 3.0 s");
}

}  // namespace
}  // namespace psplit
