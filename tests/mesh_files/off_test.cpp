#include "mesh_files/off.h"

#include "tests/mesh_files/mesh_text.h"

namespace psplit {
namespace {

TEST(Off, HeadersOfEveryFormSayTheSame) {
  const std::string body = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 0 1 2\n";
  for (const std::string header :
       {"OFF\n4 2 0\n", "OFF 4 2 0\n", "# made by a test\nOFF # yes\n\n4 2 5\n# vertices\n", "OFF\r\n4 2 0\r\n",
        "OFF\n4 2\n", "\n  OFF\n4 2 0 # counts\n"}) {
    const Expected<Asset> asset = read_text(header + body);
    EXPECT_EQ(mesh_of(asset).faces.size(), 3u) << header;
    EXPECT_EQ(warnings_of(asset), "") << header;
  }
  // Without the keyword, the name decides the format.
  EXPECT_EQ(mesh_of(read_text("4 2 0\n" + body, "a.off")).faces.size(), 3u);
}

TEST(Off, VariantsHaveTheirAttributes) {
  const auto mesh = [](const std::string& keyword, const std::string& more, std::string* warnings = nullptr) {
    const Expected<Asset> asset =
        read_text(keyword + "\n3 1 0\n0 0 0" + more + "\n1 0 0" + more + "\n0 1 0" + more + "\n3 0 1 2\n");
    if (warnings != nullptr) *warnings = warnings_of(asset);
    return mesh_of(asset);
  };
  EXPECT_EQ(floats_of(mesh("NOFF", " 0 0 1"), "NORMAL")[2], 1);
  EXPECT_EQ(floats_of(mesh("COFF", " 1 0 0.5"), "COLOR_0"),
            (std::vector<float>{1, 0, 0.5f, 1, 0, 0.5f, 1, 0, 0.5f}));
  EXPECT_EQ(floats_of(mesh("COFF", " 255 0 51 255"), "COLOR_0").size(), 12u);
  EXPECT_EQ(floats_of(mesh("COFF", " 255 0 51 255"), "COLOR_0")[2], 0.2f);
  EXPECT_EQ(floats_of(mesh("STOFF", " 0.5 0.25"), "TEXCOORD_0")[1], 0.75f);
  const Mesh all = mesh("STCNOFF", " 0 1 0 1 0 0 1 0.5 0.25");
  EXPECT_EQ(floats_of(all, "NORMAL")[1], 1);
  EXPECT_EQ(floats_of(all, "COLOR_0").size(), 12u);
  EXPECT_EQ(floats_of(all, "TEXCOORD_0")[0], 0.5f);
  std::string warnings;
  EXPECT_EQ(mesh("OFF", " 255 0 0", &warnings).attributes.size(), 1u);
  EXPECT_EQ(warnings, "3 vertices have more numbers than the header states, which are left out\n");
}

TEST(Off, PolygonsAndTheirColoursAreRead) {
  const Expected<Asset> asset = read_text(
      "OFF\n5 3 0\n0 0 0\n2 0 0\n2 2 0\n1 0.5 0\n0 2 0\n5 0 1 2 3 4 0.5 0.5 0.5 # grey\n3 0 1 2 255 0 0\n2 0 "
      "1\n");
  EXPECT_EQ(mesh_of(asset).faces.size(), 4u);
  EXPECT_NEAR(area_of(mesh_of(asset)), 2.5 + 2, 1e-6);
  EXPECT_EQ(warnings_of(asset),
            "1 face of fewer than 3 corners is left out\n2 faces have colours, which are left out\n");
}

TEST(Off, ErrorsSayWhere) {
  const std::string three = "0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_EQ(message_of("OFF\n3 1 0\n" + three + "3 0 1 3\n"), "line 6: a face names vertex 3, but there are 3");
  EXPECT_EQ(message_of("OFF\n3 1 0\n" + three + "3 0 1 -1\n"),
            "line 6: a face names vertex -1, but there are 3");
  EXPECT_EQ(message_of("OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n"),
            "line 4: the position of vertex 1 is not finite");
  EXPECT_EQ(message_of("OFF\n3 1 0\n" + three + "3 0 1 2\n7\n"),
            "line 7: \"7\" is more than the header states");
  EXPECT_EQ(message_of("OFF\n353535235358 6 0\n" + three),
            "line 2: the header claims 353535235358 vertices and 6 faces, and 19 bytes follow");
  EXPECT_EQ(message_of("OFF\n9223372036854775807 9223372036854775807 0\n").substr(0, 25),
            "line 2: the header claims");
  EXPECT_EQ(message_of("OFF\nx 6 0\n"), "line 2: \"x\" is not a number of vertices, faces or edges");
  EXPECT_EQ(message_of("OFF BINARY\n", "a.off", StatusCode::kUnsupported), "OFF: binary files are not read");
  EXPECT_EQ(message_of("4OFF\n", "a.off", StatusCode::kUnsupported),
            "OFF: only vertices of three dimensions are read");
  EXPECT_EQ(message_of("OFF\n3 0 0\n" + three, "a.off", StatusCode::kUnsupported),
            "has no triangles: only a .drc file is made of points");
}

TEST(Off, EveryTruncationIsRefused) {
  const std::string file = "COFF\n3 2 0\n0 0 0 1 0 0\n1 0 0 0 1 0\n0 1 0 0 0 1\n3 0 1 2\n3 2 1 0\n";
  ASSERT_TRUE(read_text(file).ok());
  for (size_t size = 0; size + 1 < file.size(); ++size)
    EXPECT_FALSE(read_text(file.substr(0, size), "a.off").ok()) << size;
}

}  // namespace
}  // namespace psplit
