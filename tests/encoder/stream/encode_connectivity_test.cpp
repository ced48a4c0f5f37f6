// The connectivity equals that of libdraco's encoder, and the tables equal its decoder's.
#include "encoder/stream/encode_connectivity.h"

#include <algorithm>
#include <random>

#include "encoder/libdraco/patch_stream.h"
#include "tests/encoder/stream/random_soup.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/sanitizers.h"

namespace psplit {
namespace {

// What the tests met.
struct Met {
  size_t streams = 0, refused = 0, valence = 0, handles = 0, components = 0, start_faces = 0, seams = 0,
         flat = 0, more_vertices = 0;
};

// The mesh of a patch, by the numbers of values that libdraco's encoder gets. POSITION is the first attribute.
struct PatchSource {
  std::vector<std::vector<uint32_t>> values;
  std::vector<std::span<const uint32_t>> spans;
  SourceMesh mesh;

  PatchSource(const WeldedMesh& welded, const PatchMesh& patch) {
    for (const std::vector<uint32_t>& value_of_point : welded.value_of_point) {
      std::vector<uint32_t>& value = values.emplace_back();
      for (const uint32_t point : patch.points) value.push_back(value_of_point[point]);
    }
    // Positions become numbers below the number of points.
    std::vector<uint32_t> distinct = values[0];
    std::ranges::sort(distinct);
    for (uint32_t& value : values[0])
      value = static_cast<uint32_t>(std::ranges::lower_bound(distinct, value) - distinct.begin());
    spans.assign(values.begin(), values.end());
    mesh = {static_cast<uint32_t>(patch.points.size()), patch.faces, spans};
  }
};

// Encodes by both, and compares all fields of the connectivity, and the order of faces, points and values.
void compare(const WeldedMesh& welded, const PatchMesh& patch, int speed, Met& met) {
  const std::vector<AttributeCoding> codings(welded.mesh->attributes.size());
  const Expected<EncodedPatch> reference = encode_edgebreaker(welded, patch, codings, speed);
  const PatchSource source(welded, patch);
  const ConnectivityChoices choice = choose_connectivity(speed, patch.faces.size());
  const Expected<EncodedConnectivity> ours = encode_connectivity(source.mesh, choice);
  ASSERT_EQ(ours.ok(), reference.ok()) << ours.status().to_string() << reference.status().to_string();
  if (!ours) {
    ++met.refused;
    return;
  }
  const Expected<DracoFields> read = read_fields(reference->bytes);
  ASSERT_TRUE(read.ok()) << read.status().to_string();
  const DracoFields &expected = *read, &fields = ours->fields;
  // After the header come the traversal, the number of attribute data, and each group's choices.
  const core::View<core::Group<uint32_t>> groups = ours->patch.groups;
  std::vector<uint8_t> choices = {static_cast<uint8_t>(choice.valence ? 2 : 0),
                                  static_cast<uint8_t>(fields.seams.size()),
                                  static_cast<uint8_t>(groups.size())};
  for (size_t g = 0; g < groups.size(); ++g) {
    choices.push_back(static_cast<uint8_t>(groups[g].attribute_data));
    choices.push_back(groups[g].per_corner);
    choices.push_back(groups[g].by_prediction_degree);
  }
  EXPECT_TRUE(std::ranges::equal(choices, std::span(expected.skeleton).subspan(11, choices.size())));
  EXPECT_EQ(fields.vertex_count, expected.vertex_count);
  EXPECT_EQ(fields.face_count, expected.face_count);
  ASSERT_EQ(fields.symbol_count, expected.symbol_count);
  ASSERT_EQ(fields.symbols, expected.symbols);
  EXPECT_EQ(fields.symbol_lists, expected.symbol_lists);
  EXPECT_EQ(fields.start_faces, expected.start_faces);
  EXPECT_EQ(fields.seams, expected.seams);
  ASSERT_EQ(fields.split_events.size(), expected.split_events.size());
  for (size_t i = 0; i < fields.split_events.size(); ++i) {
    EXPECT_EQ(fields.split_events[i].source, expected.split_events[i].source);
    EXPECT_EQ(fields.split_events[i].split, expected.split_events[i].split);
    EXPECT_EQ(fields.split_events[i].right_edge, expected.split_events[i].right_edge);
  }

  const core::Patch<uint32_t>& decoded = ours->patch;
  ASSERT_EQ(decoded.point_count, reference->decoded.point_count);
  ASSERT_EQ(decoded.face_count, reference->decoded.faces.size());
  for (uint32_t i = 0; i < decoded.face_count; ++i)
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t point = decoded.point_at[4 * i + k];
      ASSERT_EQ(point, reference->decoded.faces[i][k]) << "face " << i;
      // The source's point and the reference's have the same values.
      const uint32_t from = ours->point_of_corner[4 * i + k];
      for (const std::vector<uint32_t>& value : source.values)
        ASSERT_EQ(value[from], value[reference->patch_point[point]]) << "face " << i;
    }
  for (size_t g = 0, i = 0; g < decoded.groups.size(); ++g)
    for (uint32_t n = 0; n < decoded.groups[g].count; ++n, ++i)
      EXPECT_EQ(decoded.groups[g].sequence.count, expected.attributes[i].count);

  ++met.streams;
  met.valence += choice.valence;
  met.handles += !fields.split_events.empty();
  met.components += fields.start_faces.size() > 1;
  met.start_faces += std::ranges::count(fields.start_faces, 1) > 0;
  met.seams +=
      std::ranges::any_of(fields.seams, [](const auto& flags) { return std::ranges::count(flags, 1) > 0; });
  met.flat += fields.face_count < patch.faces.size();
  met.more_vertices += fields.vertex_count > source.mesh.point_count;
}

void expect_all(const Met& met) {
  for (const size_t feature :
       {met.streams, met.valence, met.handles, met.components, met.start_faces, met.seams})
    EXPECT_GT(feature, 0u);
}

TEST(EncodeConnectivity, MeshesAreAsByLibdraco) {
  Met met;
  for (const NamedMesh& named : all_meshes()) {
    if (named.mesh.faces.empty()) continue;
    SCOPED_TRACE(named.name);
    Mesh mesh = named.mesh;
    std::stable_partition(mesh.attributes.begin(), mesh.attributes.end(),
                          [](const Attribute& attribute) { return attribute.semantic == "POSITION"; });
    const WeldedMesh welded = weld(mesh, ThreadPool(1));
    for (const int speed : {0, 4, 5, 7, 10}) {
      SCOPED_TRACE(speed);
      compare(welded, whole_mesh(mesh), speed, met);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
  expect_all(met);
}

TEST(EncodeConnectivity, RandomMeshesAreAsByLibdraco) {
  Met met;
  const size_t count = random_rounds(6000);
  for (size_t seed = 0; seed < count; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    SoupMaker maker(seed);
    Soup soup;
    maker.make(seed % 40 == 0 ? 5000 : seed % 4 == 0 ? 300 : 30, soup);
    compare(soup.welded, soup.patch, static_cast<int>(seed % 11), met);
    if (testing::Test::HasFatalFailure()) return;
  }
  expect_all(met);
  EXPECT_GT(met.flat, 0u);
  EXPECT_GT(met.more_vertices, 0u);
  EXPECT_GT(met.refused, 0u);
  RecordProperty("streams", static_cast<int>(met.streams));
}

// Faces around a few vertices: more than the encoder lists by their edges.
void make_hubs(std::mt19937_64& random, Soup& soup) {
  const auto below = [&](uint32_t n) { return static_cast<uint32_t>(random() % n); };
  const uint32_t rim = 3 + below(below(2) == 0 ? 8 : 200), faces = 70 + below(2500), kind = below(4);
  const uint32_t flipped = 2 + below(20);
  soup.mesh.point_count = rim + 2;
  for (uint32_t i = 0; i < faces; ++i) {
    const uint32_t a = 2 + (kind == 0 ? i % rim : below(rim)), b = a + 1 == rim + 2 ? 2 : a + 1;
    std::array<uint32_t, 3> face{0, a, b};             // sheets around a vertex,
    if (kind == 1) face = {0, 1, a};                   // pages at an edge,
    if (kind == 2) face = {0, a, 2 + below(rim)};      // any faces of a vertex,
    if (kind == 3 && below(2) == 0) face = {1, b, a};  // or sheets between two
    if (below(flipped) == 0) std::swap(face[1], face[2]);
    std::rotate(face.begin(), face.begin() + below(3), face.end());
    soup.mesh.faces.push_back(face);
  }
  soup.welded.mesh = &soup.mesh;
  std::vector<uint32_t>& value = soup.welded.value_of_point.emplace_back(soup.mesh.point_count);
  for (uint32_t point = 0; point < value.size(); ++point) value[point] = point;
  soup.mesh.attributes.push_back(
      make_attribute("POSITION", ComponentType::kUint8, 1, false, std::vector<uint8_t>(soup.mesh.point_count)));
  soup.patch = whole_mesh(soup.mesh);
}

TEST(EncodeConnectivity, VerticesOfManyFacesAreAsByLibdraco) {
  Met met;
  std::mt19937_64 random(1);
  for (size_t round = 0; round < random_rounds(300); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    Soup soup;
    make_hubs(random, soup);
    compare(soup.welded, soup.patch, static_cast<int>(round % 11), met);
    if (testing::Test::HasFatalFailure()) return;
  }
  EXPECT_GT(met.streams, 0u);
  EXPECT_GT(met.more_vertices, 0u);
}

}  // namespace
}  // namespace psplit
