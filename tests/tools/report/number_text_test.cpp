#include "tools/gltf_psplit/report/number_text.h"

#include <gtest/gtest.h>

#include <limits>

namespace psplit {
namespace {

TEST(NumberText, IsForPeople) {
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

TEST(NumberText, BytesHaveThreeDigits) {
  EXPECT_EQ(as_bytes(0), "0 bytes");
  EXPECT_EQ(as_bytes(1), "1 byte");
  EXPECT_EQ(as_bytes(999), "999 bytes");
  EXPECT_EQ(as_bytes(1000), "1.00 kB");
  EXPECT_EQ(as_bytes(1184000), "1.18 MB");
  EXPECT_EQ(as_bytes(34100000), "34.1 MB");
  EXPECT_EQ(as_bytes(341000000), "341 MB");
  EXPECT_EQ(as_bytes(999499), "999 kB");
  EXPECT_EQ(as_bytes(999600), "1.00 MB");
  EXPECT_EQ(as_bytes(9996), "10.0 kB");
  EXPECT_EQ(as_bytes(99960), "100 kB");
  EXPECT_EQ(as_bytes(UINT64_MAX), "18.4 EB");
}

}  // namespace
}  // namespace psplit
