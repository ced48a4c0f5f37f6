// Positions that doubles or decimals say and floats do not: an origin is subtracted from them, and becomes the
// translation of their node.
#include "mesh_files/origin.h"

#include <set>

#include "tests/mesh_files/far_mesh.h"
#include "tests/mesh_files/mesh_text.h"

namespace psplit {
namespace {

Asset read_with(const std::string& text, const OriginChoice& choice, const char* name = "test") {
  Asset asset = must(read_asset(memory_stream(bytes_of(text)), name, describe_stream, choice));
  return asset;
}

PrecisePosition origin_of(const Asset& asset, size_t node = 0) {
  const Json& json = asset.document.json()["nodes"][node];
  if (!json.contains("translation")) return {};
  return json["translation"].get<PrecisePosition>();
}

OriginChoice exact() {
  OriginChoice choice;
  choice.bits = 0;
  choice.is_lossless = true;
  return choice;
}

// The grid of far_points() is there: its points are distinct, and each is where the file says.
void expect_far_grid(const Asset& asset) {
  const PrecisePosition origin = origin_of(asset);
  for (size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(origin[axis], std::round(origin[axis]));
    EXPECT_NEAR(origin[axis], kFarCorner[axis], 2);
  }
  const Mesh mesh = must(read_primitive(asset.document, {0, 0}, cpu_backend(), ThreadPool(1)));
  EXPECT_EQ(mesh.faces.size(), far_faces().size());
  const std::vector<float> floats = floats_of(mesh, "POSITION");
  std::set<PrecisePosition> expected, found;
  for (const PrecisePosition& point : far_points())
    expected.insert(
        {std::round((point[0] - kFarCorner[0]) / kFarStep), std::round((point[1] - kFarCorner[1]) / kFarStep)});
  for (size_t i = 0; i < floats.size(); i += 3) {
    const double x = origin[0] + double{floats[i]} - kFarCorner[0];
    const double y = origin[1] + double{floats[i + 1]} - kFarCorner[1];
    EXPECT_NEAR(x, std::round(x / kFarStep) * kFarStep, 1e-6);
    EXPECT_NEAR(y, std::round(y / kFarStep) * kFarStep, 1e-6);
    found.insert({std::round(x / kFarStep), std::round(y / kFarStep)});
  }
  EXPECT_EQ(found, expected);
}

TEST(Origin, DoublesFarFromTheOriginOfTheirMap) {
  for (const std::string& text : {far_ply(true), far_ply(false), far_obj(), far_off(), far_stl()}) {
    SCOPED_TRACE(text.substr(0, 30));
    const Asset asset = read_with(text, {});
    expect_far_grid(asset);
    ASSERT_EQ(asset.warnings.size(), 1u);
    EXPECT_TRUE(contains(asset.warnings[0], "positions are relative to the origin 500000,5400001,301"));
    EXPECT_TRUE(contains(asset.warnings[0], "off by up to 0.2"));
    // Exact positions take the same.
    EXPECT_EQ(origin_of(read_with(text, exact())), origin_of(asset));
  }
}

TEST(Origin, CornersOfFacetsInATextMeet) {
  const Asset asset = read_with(far_stl(), {});
  EXPECT_EQ(must(read_primitive(asset.document, {0, 0}, cpu_backend(), ThreadPool(1))).point_count,
            far_points().size());
}

// Without doubles there is nothing to keep: these bytes are as they always were.
TEST(Origin, NotWhereFloatsAreEnough) {
  const std::string near = "v 0.1 0.2 0.3\nv 5.123456789 0 0\nv 0 7.987654321 0\nf 1 2 3\n";
  const std::string of_floats =
      "v 500000.5 5400000 300\nv 500001 5400000.5 300\nv 500000 5400001 300\nf 1 2 3\n";
  const std::string small = "v 100.1 0 0\nv 101.123456 0 0\nv 100 0.987654 0\nf 1 2 3\n";
  for (const std::string& text : {near, of_floats, small}) {
    const Asset asset = read_with(text, {});
    EXPECT_EQ(origin_of(asset), PrecisePosition{}) << text;
    EXPECT_TRUE(asset.warnings.empty());
  }
  EXPECT_EQ(floats_of(mesh_of(read_text(near, "a.obj")), "POSITION"),
            (std::vector<float>{0.1f, 0.2f, 0.3f, 5.123456789f, 0, 0, 0, 7.987654321f, 0}));
  // Finer than the default grid, floats are not.
  OriginChoice fine;
  fine.bits = 21;
  EXPECT_NE(origin_of(read_with(small, fine)), PrecisePosition{});
  EXPECT_EQ(origin_of(read_with(near, exact())), PrecisePosition{});
}

TEST(Origin, TheUserDecides) {
  OriginChoice choice;
  choice.by = OriginChoice::By::kNone;
  const Asset none = read_with(far_obj(), choice);
  EXPECT_EQ(origin_of(none), PrecisePosition{});
  ASSERT_EQ(none.warnings.size(), 1u);
  EXPECT_TRUE(contains(none.warnings[0], "positions are off by up to 0.2"));

  choice.by = OriginChoice::By::kGiven;
  choice.given = {{100, -2.5, 0}};
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement "
      "face 1\nproperty list uchar int vertex_indices\nend_header\n101 0 0\n102 0 0\n101 1 0\n3 0 1 2\n";
  const Asset given = read_with(ply, choice);
  EXPECT_EQ(origin_of(given), choice.given[0]);
  EXPECT_EQ(floats_of(mesh_of(Expected<Asset>(read_with(ply, choice))), "POSITION"),
            (std::vector<float>{1, 2.5f, 0, 2, 2.5f, 0, 1, 3.5f, 0}));
}

// Objects that touch stay together. Objects that are far from each other cannot.
TEST(Origin, OfSeveralObjects) {
  const auto square = [](const char* name, double x, int first) {
    char text[400];
    const auto at = [&](int i) { return first + i; };
    std::snprintf(text, sizeof(text), "o %s\nv %.3f 5.123 0\nv %.3f 5.321 0\nv %.3f 5.999 0\nf %d %d %d\n",
                  name, x + 0.001, x + 0.503, x + 0.777, at(0), at(1), at(2));
    return std::string(text);
  };
  const Asset near = read_with(square("a", 9000000, 1) + square("b", 9000001, 4), {}, "a.obj");
  EXPECT_EQ(origin_of(near, 0), (PrecisePosition{9000001, 6, 0}));
  EXPECT_EQ(origin_of(near, 1), origin_of(near, 0));
  for (const double other : {9100000.0, -9000000.0}) {
    const Asset far = read_with(square("a", 9000000, 1) + square("b", other, 4), {}, "a.obj");
    EXPECT_NEAR(origin_of(far, 0)[0], 9000000, 1);
    EXPECT_NEAR(origin_of(far, 1)[0], other, 1);
    EXPECT_TRUE(contains(
        warnings_of(Expected<Asset>(read_with(square("a", 9000000, 1) + square("b", other, 4), {}, "a.obj"))),
        "positions of 2 objects"));
  }
}

// Degrees: whole numbers are no help. The differences are exact all the same.
TEST(Origin, OfASmallExtent) {
  const std::string text =
      "v 12.3456781 48.1234567 0\nv 12.3456912 48.1234567 0\nv 12.3456781 48.1234698 0\nf 1 2 3\n";
  const Asset asset = read_with(text, exact());
  const PrecisePosition origin = origin_of(asset);
  const std::vector<float> floats = floats_of(mesh_of(Expected<Asset>(read_with(text, exact()))), "POSITION");
  EXPECT_NEAR(origin[0] + double{floats[0]}, 12.3456781, 1e-11);
  EXPECT_NEAR(origin[0] + double{floats[3]}, 12.3456912, 1e-11);
  EXPECT_EQ(std::ldexp(origin[0], 20), std::round(std::ldexp(origin[0], 20)));
  // Far too small for its place.
  const std::string dust = "v 0 500000.3 0\nv 1e-320 500000.3 0\nv 0 500000.3 1e-320\nf 1 2 3\n";
  EXPECT_NEAR(origin_of(read_with(dust, exact(), "a.obj"))[1], 500000.3, 1);
}

TEST(Origin, SaysWhatIsLostOfExactPositions) {
  const Asset asset = read_with(far_obj(), exact());
  EXPECT_TRUE(contains(warnings_of(Expected<Asset>(read_with(far_obj(), exact()))), "not floats exactly"));
  const std::string binary = "v 500000.0009765625 0 0\nv 500001 0 0\nv 500000 1 0\nf 1 2 3\n";
  EXPECT_FALSE(contains(warnings_of(Expected<Asset>(read_with(binary, exact()))), "not floats exactly"));
  EXPECT_NE(origin_of(read_with(binary, exact())), PrecisePosition{});
}

// In floats, this polygon is a line.
TEST(Origin, PolygonsAreCutInDoubles) {
  const std::string text =
      "v 5400000.01 9400000.01 0\nv 5400000.04 9400000.01 0\nv 5400000.02 9400000.02 0\nv 5400000.01 "
      "9400000.04 0\nv "
      "5400009 9400009 0\nf 1 2 3 4\nf 1 2 5\n";
  const Asset asset = read_with(text, {}, "a.obj");
  EXPECT_FALSE(contains(warnings_of(Expected<Asset>(read_with(text, {}, "a.obj"))), "crosses itself"));
  const Mesh mesh = must(read_primitive(asset.document, {0, 0}, cpu_backend(), ThreadPool(1)));
  EXPECT_EQ(mesh.faces.size(), 3u);
}

// Three corners are on a line in floats, but not in the digits of the text. All other files are cut by floats,
// too.
TEST(Origin, PolygonsNearTheOriginAreCutInFloats) {
  const std::string text =
      "v -0.007237 0.012117 0.434917\nv -0.007258 0.010717 0.436658\nv -0.006566 0.012505 0.437107\nv "
      "-0.006902 "
      "0.012311 0.436012\nf 1 2 3 4\n";
  const Mesh mesh = mesh_of(read_text(text, "a.obj"));
  ASSERT_EQ(mesh.faces.size(), 2u);
  EXPECT_EQ(mesh.faces[0], (std::array<uint32_t, 3>{1, 2, 3}));
  EXPECT_EQ(mesh.faces[1], (std::array<uint32_t, 3>{1, 3, 0}));
}

TEST(Origin, AnIntegerOf32BitsIsNotAFloat) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty int x\nproperty int y\nproperty int z\nelement face "
      "1\nproperty list uchar int vertex_indices\nend_header\n500000001 0 0\n500000002 0 0\n500000001 1 0\n3 0 "
      "1 "
      "2\n";
  EXPECT_NEAR(origin_of(read_with(ply, {}))[0], 500000001, 1);
}

TEST(Origin, DoublesWhoseFloatsAreThoseOfTheirWords) {
  for (const char* word :
       {"0.1", "500000.123", "1.00000005960464477539062500000001", "16777217.0000000000001", "-0", "1e-50",
        "1.4e-45", "3e38", "nan", "-1e-7", "16777217", "0.30000001192092895508"}) {
    const std::optional<float> once = parse_float(word);
    const std::optional<double> precise = parse_precise(word);
    ASSERT_EQ(once.has_value(), precise.has_value()) << word;
    if (!once || std::isnan(*once)) continue;
    EXPECT_EQ(static_cast<float>(*precise), *once) << word;
    EXPECT_NEAR(*precise, *parse_double(word), 1e-15 * std::fabs(*precise)) << word;
  }
  EXPECT_EQ(*parse_precise("500000.123"), 500000.123);
  EXPECT_FALSE(parse_precise("1e39"));
  EXPECT_FALSE(parse_precise("x"));
}

}  // namespace
}  // namespace psplit
