// Pictures of assets: which triangle covers a sample, what the camera sees, which colours meet, and where
// meshes are.
#include "tools/gltf_psplit/preview/preview.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "gltf_ext/json/json.h"
#include "psplit/decode.h"
#include "psplit/document.h"
#include "psplit/gltf.h"
#include "tests/support/expect.h"
#include "tools/gltf_psplit/preview/picture.h"
#include "tools/gltf_psplit/preview/visibility.h"
#include "tools/gltf_psplit/shapes/shapes.h"

namespace psplit {
namespace {

using Triangle = std::array<ScreenPoint, 3>;
using Faces = std::vector<std::array<uint32_t, 3>>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

size_t covered(const VisibilityBuffer& buffer) {
  size_t count = 0;
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x) count += buffer.face_at(x, y) != kNoFace;
  return count;
}

TEST(Visibility, ATriangleCoversTheCentresInItAndNoOthers) {
  for (const Triangle& triangle :
       {Triangle{{{1, 1, 0.5}, {6, 1, 0.5}, {1, 6, 0.5}}}, Triangle{{{1, 1, 0.5}, {1, 6, 0.5}, {6, 1, 0.5}}}}) {
    VisibilityBuffer buffer({8, 8});
    buffer.draw(triangle, 3);
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        // Centres on the slope, which is neither a top nor a left edge, have x + y = 6.
        const bool inside = x >= 1 && y >= 1 && x + y < 6;
        EXPECT_EQ(buffer.face_at(x, y), inside ? 3 : kNoFace) << x << " " << y;
      }
  }
}

TEST(Visibility, TrianglesThatShareAnEdgeCoverEachCentreOnce) {
  // A fan around the centre of a sample, with edges through other centres.
  const std::vector<ScreenPoint> rim{{0, 0, 0}, {4.5, 0, 0}, {9, 0, 0}, {9, 4.5, 0},
                                     {9, 9, 0}, {4.5, 9, 0}, {0, 9, 0}, {0, 4.5, 0}};
  std::vector<int> times(81, 0);
  for (size_t i = 0; i < rim.size(); ++i) {
    VisibilityBuffer buffer({9, 9});
    buffer.draw({{{4.5, 4.5, 1}, rim[i], rim[(i + 1) % rim.size()]}}, 0);
    for (size_t n = 0; n < times.size(); ++n)
      times[n] += buffer.face_at(static_cast<int>(n % 9), static_cast<int>(n / 9)) == 0;
  }
  EXPECT_EQ(times, std::vector<int>(81, 1));
}

TEST(Visibility, TheNearestFaceStaysAndTheLowerNumberOfTwoAsNear) {
  const auto flat = [](double nearness) {
    return Triangle{{{-9, -9, nearness}, {30, -9, nearness}, {-9, 30, nearness}}};
  };
  const std::vector<std::pair<double, uint32_t>> drawn{{0.25, 1}, {0.5, 7}, {0.5, 5}, {0.4999, 2}};
  std::vector<size_t> order{0, 1, 2, 3};
  do {
    VisibilityBuffer buffer({4, 4});
    for (const size_t i : order) buffer.draw(flat(drawn[i].first), drawn[i].second);
    EXPECT_EQ(covered(buffer), 16u);
    EXPECT_EQ(buffer.face_at(2, 1), 5u);
  } while (std::ranges::next_permutation(order).found);

  // Two triangles intersect: each is visible where it is nearer.
  VisibilityBuffer buffer({8, 8});
  buffer.draw({{{0, -8, 0}, {8, -8, 1}, {0, 24, 0}}}, 0);
  buffer.draw({{{0, -8, 1}, {8, -8, 0}, {0, 24, 1}}}, 1);
  EXPECT_EQ(buffer.face_at(1, 0), 1u);
  EXPECT_EQ(buffer.face_at(5, 0), 0u);
}

TEST(Visibility, WhatIsOutsideFlatOrNotFiniteIsNotDrawn) {
  VisibilityBuffer buffer({8, 8});
  for (const Triangle& triangle :
       {Triangle{{{9, 9, 1}, {20, 9, 1}, {9, 20, 1}}}, Triangle{{{0, 0, 1}, {4, 4, 1}, {8, 8, 1}}},
        Triangle{{{kNan, 0, 1}, {8, 0, 1}, {0, 8, 1}}}, Triangle{{{0, 0, 1}, {8, INFINITY, 1}, {0, 8, 1}}},
        Triangle{{{0, 0, 1}, {1e300, 0, 1}, {0, 8, 1}}}, Triangle{{{-9, 0, 1}, {-1, 0, 1}, {-9, 8, 1}}}})
    buffer.draw(triangle, 0);
  EXPECT_EQ(covered(buffer), 0u);
}

TEST(Camera, FramesEveryPointAndFillsThePicture) {
  for (const ImageSize size : {ImageSize{1200, 900}, ImageSize{300, 2000}, ImageSize{2000, 300}})
    for (const double scale : {1e-6, 1.0, 1e9}) {
      std::vector<Vec3> points;
      for (int i = 0; i < 500; ++i)
        points.push_back(Vec3{7 + std::sin(i), 0.5 * std::cos(3 * i), 2 * std::sin(7 * i)} * scale);
      Framing whole(size), half(size);
      for (size_t i = 0; i < points.size(); ++i) (i % 2 == 0 ? whole : half).add(points[i]);
      whole.add(half);
      const Camera camera = whole.camera();
      std::map<std::string, std::pair<double, double>> range;
      const auto add = [&](const std::string& name, double value) {
        const auto [entry, added] = range.try_emplace(name, value, value);
        entry->second = {std::min(entry->second.first, value), std::max(entry->second.second, value)};
      };
      for (const Vec3 point : points) {
        const ScreenPoint seen = camera.project(point);
        add("x", seen.x / size.width);
        add("y", seen.y / size.height);
        add("nearness", seen.nearness);
      }
      const auto [left, right] = range["x"];
      const auto [top, bottom] = range["y"];
      EXPECT_GE(std::min(left, top), 0.05 - 1e-9);
      EXPECT_LE(std::max(right, bottom), 0.95 + 1e-9);
      EXPECT_GE(std::max(right - left, bottom - top), 0.8);
      EXPECT_NEAR(left + right, 1, 0.1);
      EXPECT_NEAR(top + bottom, 1, 0.1);
      EXPECT_NEAR(range["nearness"].first, 0, 1e-6);
      EXPECT_NEAR(range["nearness"].second, 1, 1e-6);
    }
}

TEST(Camera, SeesTheFrontFromTheRightAndAbove) {
  Framing framing({100, 100});
  for (const Vec3 corner : {Vec3{-1, -1, -1}, Vec3{1, 1, 1}}) framing.add(corner);
  const Camera camera = framing.camera();
  const auto near = [&](Vec3 p) { return camera.project(p).nearness; };
  EXPECT_GT(near({0, 0, 1}), near({0, 0, -1}));
  EXPECT_GT(near({1, 0, 0}), near({-1, 0, 0}));
  EXPECT_GT(near({0, 1, 0}), near({0, -1, 0}));
  EXPECT_GT(camera.project({1, 0, 0}).x, camera.project({-1, 0, 0}).x);
  EXPECT_LT(camera.project({0, 1, 0}).y, camera.project({0, -1, 0}).y);
}

double distance(Color a, Color b) { return length(a - b); }

// A sheet of side x side patches, each of 2 x 2 quads.
struct Sheet {
  static constexpr uint32_t kSide = 12;
  Faces faces;
  std::vector<uint32_t> face_base{0};
  uint32_t point_count = (2 * kSide + 1) * (2 * kSide + 1);
  Sheet() {
    const auto point = [](uint32_t x, uint32_t y) { return y * (2 * kSide + 1) + x; };
    for (uint32_t patch = 0; patch < kSide * kSide; ++patch) {
      for (uint32_t quad = 0; quad < 4; ++quad) {
        const uint32_t x = patch % kSide * 2 + quad % 2, y = patch / kSide * 2 + quad / 2;
        faces.push_back({point(x, y), point(x + 1, y), point(x, y + 1)});
        faces.push_back({point(x + 1, y), point(x + 1, y + 1), point(x, y + 1)});
      }
      face_base.push_back(static_cast<uint32_t>(faces.size()));
    }
  }
};

TEST(PatchColors, NeighboursDiffer) {
  const Sheet sheet;
  const std::vector<Color> colors = patch_colors(sheet.faces, sheet.point_count, sheet.face_base);
  ASSERT_EQ(colors.size(), Sheet::kSide * Sheet::kSide);
  for (uint32_t patch = 0; patch < colors.size(); ++patch) {
    const Color color = colors[patch];
    const uint32_t x = patch % Sheet::kSide, y = patch / Sheet::kSide;
    const Color left = x > 0 ? colors[patch - 1] : Color{},
                above = y > 0 ? colors[patch - Sheet::kSide] : Color{};
    EXPECT_GT(std::min(distance(color, left), distance(color, above)), 0.15) << x << " " << y;
    EXPECT_LT(std::max({color.x, color.y, color.z}), 1);
    EXPECT_GT(std::min({color.x, color.y, color.z}), 0);
  }
}

TEST(PatchColors, FollowThoseThatOthersTook) {
  const Faces faces{{0, 1, 2}};
  const std::vector<uint32_t> face_base{0, 1};
  std::vector<Color> taken;
  for (size_t first = 0; first < 8; ++first) {
    const Color color = patch_colors(faces, 3, face_base, first).at(0);
    for (const Color other : taken) EXPECT_GT(distance(color, other), 0.1) << first;
    taken.push_back(color);
  }
}

Document parse(const char* text) {
  Document document = new_document();
  document.json() = Json::parse(text);
  return document;
}

void expect_near(Vec3 a, Vec3 b) { EXPECT_LT(length(a - b), 1e-12) << a.x << " " << a.y << " " << a.z; }

TEST(Scene, TransformsAreThoseOfTheHierarchy) {
  const auto instances = must(scene_instances(parse(
      R"({"meshes": [{}, {}], "scene": 1, "scenes": [{}, {"nodes": [0, 3]}], "nodes": [{"translation": [1, 2, 3], "scale": [2, 2, 2], "children": [1], "mesh": 1}, {"rotation": [0, 0, 0.7071067811865476, 0.7071067811865476], "children": [2]}, {"matrix": [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1], "mesh": 0}, {"mesh": 0}, {"mesh": 0}]})")));
  std::map<size_t, std::vector<Transform>> of_mesh;
  for (const MeshInstance& instance : instances) of_mesh[instance.mesh].push_back(instance.to_world);
  ASSERT_EQ(of_mesh[0].size(), 2u);
  ASSERT_EQ(of_mesh[1].size(), 1u);
  expect_near(of_mesh[1][0].point({1, 1, 1}), {3, 4, 5});
  std::ranges::sort(of_mesh[0], {}, [](const Transform& t) { return length(t.origin); });
  expect_near(of_mesh[0][0].point({1, 2, 3}), {1, 2, 3});
  // Mirrored and moved to (6, -1, 0), turned to (1, 6, 0), doubled and moved.
  expect_near(of_mesh[0][1].point({1, 1, 0}), {3, 14, 3});
  const Transform& mirror = of_mesh[0][1];
  EXPECT_NEAR(dot(mirror.normal({0, 1, 1}), mirror.direction({5, 1, -1})), 0, 1e-12);
}

TEST(Scene, WithoutScenesEveryMeshIsThereOnce) {
  const auto instances = must(scene_instances(parse(R"({"meshes": [{}, {}, {}], "nodes": [{"mesh": 1}]})")));
  EXPECT_EQ(instances.size(), 3u);
}

TEST(Scene, MayBeDeepButNotRound) {
  Document document = parse(R"({"meshes": [{}], "scenes": [{"nodes": [0]}], "nodes": []})");
  constexpr int kDepth = 100000;
  for (int i = 0; i < kDepth; ++i)
    document.json()["nodes"].push_back({{"children", Json::array({i + 1})}, {"translation", {1, 0, 0}}});
  document.json()["nodes"].push_back({{"mesh", 0}});
  const auto deep = must(scene_instances(document));
  EXPECT_EQ(deep.at(0).to_world.origin.x, kDepth);

  document.json()["nodes"].back()["children"] = {0};
  EXPECT_EQ(scene_instances(document).status().code(), StatusCode::kInvalidInput);
}

TEST(Scene, NodesMayHaveSeveralParentsButNotWithoutEnd) {
  Document document = parse(R"({"meshes": [{}], "scenes": [{"nodes": [0]}], "nodes": []})");
  for (int i = 1; i <= 5; ++i) document.json()["nodes"].push_back({{"children", {i, i}}});
  document.json()["nodes"].push_back({{"mesh", 0}});
  EXPECT_EQ(scene_instances(document).value().size(), 32u);
  for (int i = 6; i <= 64; ++i) {
    document.json()["nodes"].back() = {{"children", {i, i}}};
    document.json()["nodes"].push_back({{"mesh", 0}});
  }
  EXPECT_EQ(scene_instances(document).status().code(), StatusCode::kInvalidInput);
}

TEST(Scene, MalformedNodesAreErrors) {
  for (const char* nodes :
       {R"([{"mesh": 1}])", R"([{"mesh": -1}])", R"([{"mesh": "0"}])", R"([{"children": [1]}])",
        R"([{"children": [0]}])", R"([{"children": ["a"]}])", R"([{"translation": [1, 2]}])",
        R"([{"scale": 3}])", R"([{"matrix": [1]}])", R"([{"rotation": [0, 0, 0, "1"]}])", "[]"}) {
    Document document = parse(R"({"meshes": [{}], "scenes": [{"nodes": [0]}]})");
    document.json()["nodes"] = Json::parse(nodes);
    EXPECT_EQ(scene_instances(document).status().code(), StatusCode::kInvalidInput) << nodes;
  }
  EXPECT_EQ(scene_instances(parse(R"({"scenes": [{}], "scene": 1})")).status().code(),
            StatusCode::kInvalidInput);
}

TEST(Png, KeepsSizeAndPixels) {
  Image image{{37, 21}, {}};
  for (int i = 0; i < 37 * 21 * 4; ++i) image.rgba.push_back(static_cast<uint8_t>(i * 7));
  const auto file = must(encode_png(image));
  ASSERT_EQ(png_sig_cmp(file.data(), 0, 8), 0);
  png_image read{};
  read.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_memory(&read, file.data(), file.size()), 0);
  EXPECT_EQ(read.width, 37u);
  EXPECT_EQ(read.height, 21u);
  EXPECT_EQ(read.format, static_cast<png_uint_32>(PNG_FORMAT_RGBA));
  std::vector<uint8_t> pixels(PNG_IMAGE_SIZE(read));
  ASSERT_NE(png_image_finish_read(&read, nullptr, pixels.data(), 0, nullptr), 0);
  EXPECT_EQ(pixels, image.rgba);
}

// Two faces of a cube that meet at an edge towards the camera.
PictureMesh roof() {
  return {.positions = {{0, 0, 1}, {1, 0, 0}, {1, 1, 0}, {0, 1, 1}, {0, 0, -1}, {0, 1, -1}},
          .normals = std::vector<std::array<float, 3>>(6),
          .faces = {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}},
          .patch_end = {2, 4},
          .patch_color = {{1, 0, 0}, {0, 0, 1}}};
}

std::array<int, 4> pixel(const Image& image, double x, double y) {
  const auto column = static_cast<size_t>(x * image.size.width),
             row = static_cast<size_t>(y * image.size.height);
  std::array<int, 4> parts{};
  for (size_t i = 0; i < 4; ++i)
    parts[i] = image.rgba[(row * static_cast<size_t>(image.size.width) + column) * 4 + i];
  return parts;
}

TEST(Picture, ShowsPatchesInTheirColoursBeforeNothing) {
  const ThreadPool pool(2);
  const std::vector<PictureMesh> meshes{roof()};
  const std::vector<MeshInstance> instances{{0, {}}};
  const auto image = draw_picture(meshes, instances, {120, 100}, pool);
  ASSERT_TRUE(image) << image.status().to_string();
  ASSERT_EQ(image->rgba.size(), 120u * 100 * 4);
  EXPECT_EQ(pixel(*image, 0.01, 0.01), (std::array<int, 4>{}));
  EXPECT_EQ(pixel(*image, 0.99, 0.99), (std::array<int, 4>{}));
  size_t red = 0, blue = 0, soft = 0;
  for (size_t i = 0; i < image->rgba.size(); i += 4) {
    if (image->rgba[i + 3] > 0 && image->rgba[i + 3] < 255) ++soft;
    if (image->rgba[i + 3] < 255) continue;
    red += image->rgba[i] > 60 && image->rgba[i + 2] == 0;
    blue += image->rgba[i + 2] > 60 && image->rgba[i] == 0;
  }
  EXPECT_GT(red, 200u);
  EXPECT_GT(blue, 200u);
  EXPECT_GT(soft, 50u);  // edges
}

TEST(Picture, DrawsEveryInstanceWhereItStands) {
  const ThreadPool pool(1);
  const std::vector<PictureMesh> meshes{roof(), {}};
  Transform up, mirrored;
  up.origin = {0, 4, 0};
  mirrored.x = {-1, 0, 0};
  mirrored.origin = {1, -4, 0};
  const std::vector<MeshInstance> instances{{1, {}}, {0, up}, {1, up}, {0, mirrored}};
  const auto image = must(draw_picture(meshes, instances, {60, 200}, pool));
  std::vector<bool> rows;
  for (int y = 0; y < 200; ++y) {
    bool any = false;
    for (int x = 0; x < 60; ++x) any |= pixel(image, (x + 0.5) / 60, (y + 0.5) / 200)[3] > 0;
    if (rows.empty() || rows.back() != any) rows.push_back(any);
  }
  EXPECT_EQ(rows, (std::vector<bool>{false, true, false, true, false}));
}

TEST(Picture, OfNothingIsAnError) {
  const ThreadPool pool(1);
  const auto code = [&](const PictureMesh& mesh) {
    const MeshInstance instance{0, {}};
    return draw_picture({&mesh, 1}, {&instance, 1}, {64, 64}, pool).status().code();
  };
  EXPECT_EQ(code({}), StatusCode::kUnsupported);
  PictureMesh flat = roof();
  for (auto& position : flat.positions) position = {1, 2, 3};
  EXPECT_EQ(code(flat), StatusCode::kUnsupported);
  PictureMesh infinite = roof();
  for (auto& position : infinite.positions) position = {NAN, INFINITY, 3};
  EXPECT_EQ(code(infinite), StatusCode::kUnsupported);
  // A point that is not finite removes its faces, and no others.
  PictureMesh one = roof();
  one.positions[4] = {NAN, 0, 0};
  EXPECT_EQ(code(one), StatusCode::kOk);
}

// The ratios of red to green among the opaque pixels of a picture, in linear light. Shading does not change
// them.
std::set<int> hues(const Image& image) {
  const auto linear = [](uint8_t encoded) { return std::pow((encoded / 255.0 + 0.055) / 1.055, 2.4); };
  std::set<int> found;
  for (size_t i = 0; i < image.rgba.size(); i += 4)
    if (image.rgba[i + 3] == 255 && std::min(image.rgba[i], image.rgba[i + 1]) > 70)
      found.insert(
          static_cast<int>(std::lround(4 * std::log2(linear(image.rgba[i]) / linear(image.rgba[i + 1])))));
  return found;
}

TEST(Preview, ColoursByPatchWithTheSameBytesForAnyNumberOfThreads) {
  const ThreadPool one(1), two(2);
  const auto shapes = must(generate_shape({Shape::kBlob, 20000, 3, false, false}, two));
  Document document = document_from_mesh(shapes.front());
  const auto plain = must(draw_preview(document, {200, 150}, cpu_backend(), two));
  EXPECT_LE(hues(plain).size(), 2u);

  EncodeDocumentOptions options;
  options.patches.count = 12;
  ASSERT_TRUE(encode_document(document, options, cpu_backend(), two));
  const auto split = must(draw_preview(document, {200, 150}, cpu_backend(), two));
  EXPECT_GE(hues(split).size(), 6u);
  const auto alone = must(draw_preview(document, {200, 150}, cpu_backend(), one));
  EXPECT_EQ(split.rgba, alone.rgba);
}

TEST(Preview, LeavesOutWhatHasNoTriangles) {
  const ThreadPool pool(1);
  const auto shapes = must(generate_shape({Shape::kBlob, 500, 3, false, false}, pool));
  Document document = document_from_mesh(shapes.front());
  const auto primitives = [&]() -> Json& { return document.json()["meshes"][0]["primitives"]; };
  Json points = primitives()[0], placeless = primitives()[0];
  points["mode"] = 0;
  placeless["attributes"].erase("POSITION");
  const auto before = draw_preview(document, {64, 64}, cpu_backend(), pool);
  primitives().push_back(points);
  primitives().push_back(placeless);
  const auto after = draw_preview(document, {64, 64}, cpu_backend(), pool);
  ASSERT_TRUE(before && after);
  EXPECT_EQ(before->rgba, after->rgba);
  primitives() = Json::array({points});
  EXPECT_EQ(draw_preview(document, {64, 64}, cpu_backend(), pool).status().code(), StatusCode::kUnsupported);
}

}  // namespace
}  // namespace psplit
