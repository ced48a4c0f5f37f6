// `--compat khr`: patches that any loader of KHR_draco_mesh_compression opens.
#include <algorithm>
#include <set>

#include "gltf_ext/json/json_fields.h"
#include "psplit/document.h"
#include "tests/gltf_ext/asset.h"

namespace psplit {
namespace {

EncodeDocumentOptions khr(uint64_t patches, bool lossless = true) {
  const EncodeDocumentOptions options =
      DocumentOptions{.patches = {.count = patches}, .lossless = lossless, .compat = Compat::kKhr};
  return options;
}

// The triangles as values at their corners, independent of the numbers of points.
std::multiset<std::vector<std::byte>> triangles_of(const Mesh& mesh) {
  std::multiset<std::vector<std::byte>> triangles;
  for (const auto& face : mesh.faces) {
    std::array<std::vector<std::byte>, 3> corners;
    for (size_t c = 0; c < 3; ++c)
      for (const Attribute& attribute : mesh.attributes) {
        const auto begin = attribute.values.begin() + static_cast<std::ptrdiff_t>(face[c] * attribute.stride());
        corners[c].insert(corners[c].end(), begin, begin + static_cast<std::ptrdiff_t>(attribute.stride()));
      }
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    std::vector<std::byte> triangle;
    for (const auto& corner : corners) triangle.insert(triangle.end(), corner.begin(), corner.end());
    triangles.insert(std::move(triangle));
  }
  return triangles;
}

std::multiset<std::vector<std::byte>> all_triangles(const Document& document, size_t mesh = 0) {
  std::multiset<std::vector<std::byte>> all;
  for (size_t p = 0; p < document.json()["meshes"][mesh]["primitives"].size(); ++p) {
    Expected<Mesh> part = read(document, mesh, p);
    EXPECT_TRUE(part) << part.status().to_string();
    if (part) all.merge(triangles_of(*part));
  }
  return all;
}

TEST(CompatKhr, APrimitiveAPatchAndTogetherTheSameTriangles) {
  const Mesh mesh = rich_mesh(30, 20);
  Document document = document_from_mesh(mesh);
  primitive_of(document)["material"] = 0;
  document.json()["materials"] = Json::array({Json::object()});
  const auto reports = must(encode(document, khr(6)));
  const Json& primitives = document.json()["meshes"][0]["primitives"];
  ASSERT_EQ(primitives.size(), 6u);
  EXPECT_EQ(count_in(document, kExtensionName), 0u);
  EXPECT_EQ(document.json()["extensionsRequired"], Json::array({"KHR_draco_mesh_compression"}));
  std::set<int64_t> views;
  uint64_t bytes = 0;
  for (const Json& primitive : primitives) {
    EXPECT_EQ(primitive["material"], 0);
    const auto view = primitive["extensions"]["KHR_draco_mesh_compression"]["bufferView"].get<int64_t>();
    views.insert(view);
    bytes += buffer_view_bytes(document, view)->size();
  }
  EXPECT_EQ(views.size(), 6u);
  EXPECT_EQ(reports[0].bytes, bytes);
  EXPECT_EQ(reports[0].streams.size(), 6u);
  EXPECT_EQ(document.json()["bufferViews"].size(), 6u);  // the plain geometry is gone
  EXPECT_EQ(all_triangles(document), triangles_of(mesh));
  // The accessors of each primitive describe its own patch.
  for (size_t p = 0; p < primitives.size(); ++p) {
    const Expected<Mesh> part = read(document, 0, p);
    EXPECT_EQ(accessor_of(document, "POSITION", 0, p)["count"], part->point_count);
    EXPECT_EQ(accessor_of(document, "indices", 0, p)["count"], 3 * part->faces.size());
  }
  ASSERT_TRUE(decode(document).ok());
  EXPECT_EQ(all_triangles(document), triangles_of(mesh));
}

TEST(CompatKhr, AssetsWithoutMeshesStayWhatTheyAre) {
  Document document = new_document();
  document.json().erase("meshes");
  const Json before = document.json();
  ASSERT_TRUE(encode(document, khr(4)));
  EXPECT_EQ(document.json(), before);
}

// A seam of pairs of points that are equal in all attributes, also in weights. Unused points precede them.
TEST(CompatKhr, SkinnedPointsAreMergedWhereOthersGo) {
  constexpr uint32_t kUnused = 7;
  const Mesh grid = rich_mesh(6, 6);
  Mesh mesh = take_points(grid, {0, 1, 2, 3, 4, 5, 6});
  mesh.faces = grid.faces;
  for (int copy = 0; copy < 2; ++copy) append_mesh(mesh, {grid.point_count, {}, grid.attributes});
  for (size_t i = 0; i < mesh.faces.size(); ++i)
    for (uint32_t& point : mesh.faces[i]) point += kUnused + (i % 2 == 0 ? 0 : grid.point_count);
  Document document = document_from_mesh(mesh);
  const auto reports = must(encode(document, khr(1, false)));
  EXPECT_EQ(accessor_of(document, "POSITION")["count"], grid.point_count);
}

TEST(CompatKhr, BordersAreClosedWhenQuantized) {
  const Mesh mesh = make_grid(30, 20);
  Document document = document_from_mesh(mesh), stitched = document;
  ASSERT_TRUE(encode(document, khr(5, false)));
  EncodeDocumentOptions options = khr(5, false);
  options.compat = Compat::kNone;
  ASSERT_TRUE(encode(stitched, options));
  EXPECT_EQ(all_triangles(document), all_triangles(stitched));
}

TEST(CompatKhr, MorphTargetsOfEachPatchFollowIt) {
  const Mesh mesh = make_grid(20, 20);
  Document document = document_from_mesh(mesh);
  const AccessorData deltas = make_data(ComponentType::kFloat32, 3, values_of<float>(mesh.attributes[0]));
  primitive_of(document)["targets"] =
      Json::array({{{"POSITION", append_accessor(document, deltas, 34962, true)}}});
  document.json()["meshes"][0]["weights"] = Json::array({0.5});
  ASSERT_TRUE(encode(document, khr(4)));
  ASSERT_EQ(document.json()["meshes"][0]["primitives"].size(), 4u);
  for (size_t p = 0; p < 4; ++p) {
    const auto morphs = read_morph_targets(document, {0, p});
    ASSERT_TRUE(morphs && morphs->size() == 1);
    EXPECT_EQ((*morphs)[0].data.values, read(document, 0, p)->find("POSITION")->values);
  }
}

TEST(CompatKhr, FallbackLeavesTheExtensionOptional) {
  const Mesh mesh = make_grid(20, 20);
  Document document = document_from_mesh(mesh);
  EncodeDocumentOptions options = khr(4);
  options.fallback = Fallback::kUncompressed;
  ASSERT_TRUE(encode(document, options));
  EXPECT_FALSE(document.json().contains("extensionsRequired"));
  for (Json& primitive : document.json()["meshes"][0]["primitives"]) primitive.erase("extensions");
  EXPECT_EQ(all_triangles(document), triangles_of(mesh));
}

TEST(CompatKhr, EqualPrimitivesShareTheirPatchesAndOthersKeepTheirPlace) {
  const Mesh mesh = make_grid(20, 20);
  Document document = document_from_mesh(mesh);
  Json lines = primitive_of(document);
  lines["mode"] = 1;
  const Json triangles = primitive_of(document);
  document.json()["meshes"][0]["primitives"] = Json::array({triangles, lines, triangles});
  document.json()["meshes"].push_back({{"primitives", Json::array({triangles})}});
  const auto reports = must(encode(document, khr(3)));
  ASSERT_EQ(reports.size(), 4u);
  EXPECT_EQ(reports[1].skipped, "points or lines");
  const Json& first = document.json()["meshes"][0]["primitives"];
  ASSERT_EQ(first.size(), 7u);
  EXPECT_EQ(first[3]["mode"], 1);
  for (size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(first[k], first[4 + k]);
    EXPECT_EQ(first[k], document.json()["meshes"][1]["primitives"][k]);
  }
  EXPECT_EQ(all_triangles(document, 1), triangles_of(mesh));
  EXPECT_EQ(read_accessor(document, first[3]["attributes"]["POSITION"].get<int64_t>())->values,
            mesh.attributes[0].values);
}

TEST(CompatKhr, TakesWhatIsInPatchesAlready) {
  const Mesh mesh = make_grid(20, 20);
  Document document = document_from_mesh(mesh);
  EncodeDocumentOptions options = khr(4);
  options.compat = Compat::kNone;
  ASSERT_TRUE(encode(document, options));
  ASSERT_TRUE(encode(document, khr(5)));
  EXPECT_EQ(count_in(document, kExtensionName), 0u);
  EXPECT_EQ(document.json()["meshes"][0]["primitives"].size(), 5u);
  EXPECT_EQ(all_triangles(document), triangles_of(mesh));
}

TEST(CompatKhr, DegenerateFacesArePatchesOfTheirOwnAndUnusedPointsGo) {
  Mesh mesh = make_grid(6, 6);
  mesh.faces.push_back({2, 2, 3});
  std::vector<float> positions = values_of<float>(mesh.attributes[0]);
  positions.insert(positions.end(), {50, 50, 50});
  mesh = make_mesh(positions, mesh.faces);
  Document document = document_from_mesh(mesh);
  EncodeDocumentOptions options = khr(2);
  options.keep_degenerate = true;
  const auto reports = must(encode(document, options));
  EXPECT_EQ(reports[0].statistics.dropped_points, 1u);
  EXPECT_EQ(document.json()["meshes"][0]["primitives"].size(), 3u);
  EXPECT_EQ(all_triangles(document), triangles_of(mesh));
}

}  // namespace
}  // namespace psplit
