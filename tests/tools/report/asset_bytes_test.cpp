#include "tools/gltf_psplit/report/asset_bytes.h"

#include <gtest/gtest.h>

namespace psplit {
namespace {

TEST(AssetBytes, SizesNameTexturesApart) {
  EXPECT_EQ(sizes_text({{34100000, 0}, {1180000, 0}}), "1.18 MB from 34.1 MB (3.5 %)");
  EXPECT_EQ(sizes_text({{9800000, 7500000}, {7600000, 7500000}}),
            "7.60 MB from 9.80 MB (77.6 %), of which textures 7.50 MB");
  EXPECT_EQ(sizes_text({{9800000, 7500000}, {2300000, 0}}),
            "2.30 MB from 9.80 MB (23.5 %), of which textures 0 bytes from 7.50 MB");
  EXPECT_EQ(sizes_text({{0, 0}, {2300000, 0}}), "2.30 MB");  // from a pipe
  EXPECT_EQ(sizes_text({{0, 0}, {2300000, 500000}}), "2.30 MB, of which textures 500 kB");
  EXPECT_EQ(sizes_text({{1000, 0}, {6600, 0}}), "6.60 kB from 1.00 kB (6.6 times)");
  EXPECT_EQ(sizes_text({{9800000, 0}, {0, 0}}), "");  // to stdout
}

TEST(AssetBytes, TheLastLineLeavesOutUnknownSizes) {
  EXPECT_EQ(written_text("out.glb", {{34100000, 0}, {1180000, 0}}, "2 primitives decoded; 1.11 s"),
            "out.glb: 1.18 MB from 34.1 MB (3.5 %); 2 primitives decoded; 1.11 s");
  EXPECT_EQ(written_text("-", {{34100000, 0}, {0, 0}}, "2 primitives decoded"), "stdout: 2 primitives decoded");
}

}  // namespace
}  // namespace psplit
