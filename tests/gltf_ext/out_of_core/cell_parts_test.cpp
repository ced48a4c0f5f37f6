#include "gltf_ext/out_of_core/cell_parts.h"

#include <cstring>
#include <optional>

#include "encoder/welding/reduce.h"
#include "gltf_ext/out_of_core/mesh_spool.h"
#include "gltf_ext/primitive/view_in_place.h"
#include "mesh_files/repair_values.h"
#include "tests/gltf_ext/asset.h"
#include "tests/support/choose_codings.h"
#include "tests/support/mesh_file_seeds.h"
#include "tests/support/test_folder.h"
#include "tools/gltf_psplit/shapes/shapes.h"

namespace psplit {
namespace {

struct Parts {
  Losses losses;
  std::unique_ptr<MeshSpool> spool;
  Expected<std::unique_ptr<CellParts>> parts = Status();
};

Parts parts_of(std::unique_ptr<Parts> result, const std::filesystem::path& folder, uint64_t most_faces) {
  const auto cut = [&]() -> Expected<std::unique_ptr<CellParts>> {
    Expected<Document> document = result->spool->finish({}, -1);
    if (!document) return document.status();
    const auto mesh = LargeMesh::open(must(view_in_place(*document, {0, 0})), {}, {}, "positions");
    if (!mesh) return mesh.status();
    return CellParts::make(*mesh, {folder, {1, 0, most_faces}, 1 << 20}, test_pool());
  };
  result->parts = cut();
  return std::move(*result);
}

std::unique_ptr<Parts> begin(const std::filesystem::path& folder) {
  auto result = std::make_unique<Parts>();
  result->spool = std::make_unique<MeshSpool>(SpoolOptions{folder, 1000}, result->losses);
  return result;
}

// The points in blocks of 1000, as readers pass them.
Parts cut(const Mesh& mesh, const std::filesystem::path& folder, uint64_t most_faces) {
  std::unique_ptr<Parts> result = begin(folder);
  std::vector<Attribute> block = mesh.attributes;
  for (Attribute& attribute : block) attribute.values.clear();
  Status status = result->spool->begin(block, 0, false);
  for (size_t first = 0; first < mesh.point_count && status.ok(); first += 1000) {
    const size_t count = std::min<size_t>(1000, mesh.point_count - first);
    for (size_t i = 0; i < block.size(); ++i) {
      const auto from = mesh.attributes[i].values.begin();
      const auto stride = static_cast<std::ptrdiff_t>(block[i].stride());
      block[i].values.assign(from + static_cast<std::ptrdiff_t>(first) * stride,
                             from + static_cast<std::ptrdiff_t>(first + count) * stride);
    }
    status = result->spool->add_points(block, count, {});
  }
  if (status.ok()) status = result->spool->add_faces(mesh.faces);
  EXPECT_TRUE(status.ok()) << status.to_string();
  return parts_of(std::move(result), folder, most_faces);
}

// The parts as one mesh. Checks what MeshParts promises.
Mesh joined(CellParts& parts) {
  Mesh whole;
  std::vector<std::optional<uint32_t>> point_of_number(parts.shared_count());
  std::vector<int> uses(parts.shared_count());
  for (uint32_t i = 0; i < parts.part_count(); ++i) {
    Expected<MeshPart> part = parts.read(i);
    EXPECT_TRUE(part.ok()) << part.status().to_string();
    if (!part.ok()) return whole;
    const Mesh& mesh = part->mesh;
    EXPECT_FALSE(mesh.faces.empty());
    EXPECT_TRUE(std::ranges::is_sorted(part->shared_points));
    const ReducedMesh reduced = reduce(mesh, {false, true, true}, ThreadPool(1));
    EXPECT_EQ(reduced.merged_points + reduced.dropped_faces + reduced.dropped_points, 0u);
    if (whole.attributes.empty()) whole.attributes = mesh.attributes;
    std::vector<uint32_t> number(mesh.point_count);
    size_t shared = 0;
    for (uint32_t point = 0; point < mesh.point_count; ++point) {
      const bool is_shared = shared < part->shared_points.size() && part->shared_points[shared] == point;
      std::optional<uint32_t> known;
      if (is_shared) {
        const uint32_t shared_number = part->shared_numbers[shared++];
        EXPECT_LT(shared_number, parts.shared_count());
        ++uses[shared_number];
        if (!point_of_number[shared_number])
          point_of_number[shared_number] = whole.point_count;
        else
          known = point_of_number[shared_number];
      }
      number[point] = known.value_or(whole.point_count);
      for (size_t a = 0; a < mesh.attributes.size(); ++a) {
        const size_t stride = mesh.attributes[a].stride();
        const auto from = mesh.attributes[a].values.begin() + static_cast<std::ptrdiff_t>(point * stride);
        if (known) {
          EXPECT_EQ(std::memcmp(&*from, whole.attributes[a].values.data() + *known * stride, stride), 0);
        } else {
          if (whole.point_count == 0) whole.attributes[a].values.clear();
          whole.attributes[a].values.insert(whole.attributes[a].values.end(), from,
                                            from + static_cast<std::ptrdiff_t>(stride));
        }
      }
      if (!known) ++whole.point_count;
    }
    EXPECT_EQ(shared, part->shared_points.size());
    for (const auto& face : mesh.faces)
      whole.faces.push_back({number[face[0]], number[face[1]], number[face[2]]});
  }
  for (const int count : uses) EXPECT_GE(count, 2);
  return whole;
}

// The parts together are what reduce() makes of the whole mesh, with the same counts.
// `more`: points of the input that `mesh` has once.
void expect_as_reduced(CellParts& parts, const Mesh& mesh, uint64_t more = 0) {
  const ReducedMesh expected = reduce(mesh, {false, true, true}, ThreadPool(1));
  const Mesh actual = joined(parts);
  EXPECT_EQ(compare_meshes(expected.mesh, actual), "");
  const CellStatistics& statistics = parts.statistics();
  EXPECT_EQ(statistics.points, mesh.point_count + more);
  EXPECT_EQ(statistics.faces, mesh.faces.size());
  EXPECT_EQ(statistics.kept_faces, expected.mesh.faces.size());
  EXPECT_EQ(statistics.merged_points, expected.merged_points + more);
  EXPECT_EQ(statistics.dropped_faces, expected.dropped_faces);
  EXPECT_EQ(statistics.dropped_points, expected.dropped_points);
}

Mesh shape(uint64_t faces, bool rich) {
  const ShapeOptions options{
      .shape = rich ? Shape::kGyroid : Shape::kBlob, .faces = faces, .normals = rich, .texcoords = rich};
  return std::move(generate_shape(options, test_pool())->front());
}

// Every 7th face gets points of its own, and every 11th repeats one; some points are unused.
Mesh with_duplicates(Mesh mesh) {
  const auto copy_point = [&](uint32_t point) {
    append_points(mesh, point, point + 1);
    return mesh.point_count - 1;
  };
  for (size_t i = 0; i < mesh.faces.size(); ++i) {
    if (i % 7 == 0)
      for (uint32_t& point : mesh.faces[i]) point = copy_point(point);
    if (i % 11 == 0) mesh.faces[i][2] = copy_point(mesh.faces[i][0]);
    if (i % 13 == 0) (void)copy_point(mesh.faces[i][1]);
  }
  // Unused points that equal no other, and a zero of the other sign.
  for (float* const at = reinterpret_cast<float*>(mesh.attributes[0].values.data());
       const size_t point : {size_t{5}, size_t{500}})
    at[3 * point] = -0.0f;
  return mesh;
}

TEST(CellParts, TogetherAreTheReducedMesh) {
  const TestFolder folder;
  for (const bool rich : {false, true}) {
    const Mesh mesh = with_duplicates(shape(20000, rich));
    for (const uint64_t most_faces : {100000u, 9000u, 400u}) {
      Parts parts = cut(mesh, folder, most_faces);
      ASSERT_TRUE(parts.parts.ok()) << parts.parts.status().to_string();
      expect_as_reduced(**parts.parts, mesh);
      if (most_faces > 20000)
        EXPECT_EQ((*parts.parts)->part_count(), 1u);
      else
        EXPECT_GE((*parts.parts)->part_count(), 20000 / most_faces);
    }
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

TEST(CellParts, UnusualMeshes) {
  const TestFolder folder;
  for (const NamedMesh& named : nasty_meshes()) {
    SCOPED_TRACE(named.name);
    MeshFile file;
    file.objects.push_back({"", {{named.mesh, -1}}});
    repair_values(file);
    const Mesh& mesh = file.objects[0].parts[0].mesh;
    const ReducedMesh reduced = reduce(mesh, {false, true, true}, ThreadPool(1));
    Parts parts = cut(mesh, folder, std::max<uint64_t>(10, mesh.faces.size() / 50));
    if (reduced.mesh.faces.empty()) {
      EXPECT_FALSE(parts.parts.ok());
      continue;
    }
    if (!parts.parts.ok()) {  // many faces at one place
      EXPECT_EQ(parts.parts.status().code(), StatusCode::kUnsupported) << parts.parts.status().to_string();
      parts = cut(mesh, folder, 10000);
    }
    ASSERT_TRUE(parts.parts.ok()) << parts.parts.status().to_string();
    expect_as_reduced(**parts.parts, mesh);
  }
}

// Faces between random points: every part shares its points with many others.
TEST(CellParts, FacesAcrossTheWholeMesh) {
  const TestFolder folder;
  Mesh mesh = make_grid(100, 100);
  uint32_t state = 1;
  for (auto& face : mesh.faces)
    for (uint32_t& point : face) point = (state = state * 1664525 + 1013904223) >> 8;
  for (auto& face : mesh.faces)
    for (uint32_t& point : face) point %= mesh.point_count;
  Parts parts = cut(mesh, folder, 1500);
  ASSERT_TRUE(parts.parts.ok()) << parts.parts.status().to_string();
  EXPECT_GT((*parts.parts)->part_count(), 10u);
  expect_as_reduced(**parts.parts, mesh);
}

// Facets of `mesh`, with a normal that `normal_of` gives.
template <typename NormalOf>
std::vector<Facet> facets_of(const Mesh& mesh, const NormalOf& normal_of) {
  std::vector<Facet> facets;
  for (const auto& face : mesh.faces) {
    Facet& facet = facets.emplace_back();
    for (size_t c = 0; c < 3; ++c) facet.corners[c] = position_at(mesh.attributes[0], face[c]);
    facet.normal = normal_of(facets.size() - 1, facet.corners);
  }
  return facets;
}

void expect_facets_as_read(const std::vector<Facet>& facets) {
  const TestFolder folder;
  std::vector<StlFacet> stored(facets.size());
  for (size_t i = 0; i < facets.size(); ++i) std::memcpy(&stored[i], &facets[i], sizeof(Facet));
  const std::string text = binary_stl(stored);
  const std::vector<uint8_t> bytes(text.begin(), text.end());
  Scanner whole(memory_stream(bytes));
  MeshFile file = must(read_stl(whole, {}));
  repair_values(file);

  std::unique_ptr<Parts> started = begin(folder);
  Scanner scanner(memory_stream(bytes));
  ASSERT_TRUE(read_stl(scanner, *started->spool, started->losses).ok());
  Parts parts = parts_of(std::move(started), folder, 700);
  ASSERT_TRUE(parts.parts.ok()) << parts.parts.status().to_string();
  EXPECT_GT((*parts.parts)->part_count(), 1u);
  const Mesh& mesh = file.objects[0].parts[0].mesh;
  expect_as_reduced(**parts.parts, mesh, 3 * facets.size() - mesh.point_count);
}

TEST(CellParts, FacetsAreWeldedAsTheReaderOfStlDoes) {
  const Mesh mesh = shape(5000, false);
  const auto flat = [](size_t, const std::array<Position, 3>& corners) {
    return normal_of_faces(area_vector(corners));
  };
  using Normal = std::array<float, 3>;
  expect_facets_as_read(facets_of(mesh, flat));
  // No normals at all; a few without direction, before and after others; normals of any length.
  expect_facets_as_read(facets_of(mesh, [](size_t, const auto&) { return Normal{0, 0, 0}; }));
  expect_facets_as_read(facets_of(mesh, [&](size_t i, const auto& corners) {
    return i < 10 || i % 100 == 0 ? Normal{0, 0, 0} : flat(i, corners);
  }));
  expect_facets_as_read(facets_of(mesh, [&](size_t i, const auto& corners) {
    Normal normal = flat(i, corners);
    for (float& value : normal) value *= static_cast<float>(1 + i % 3);
    return i % 2 == 0 ? Normal{0, 0, static_cast<float>(1 + i % 4)} : normal;
  }));
}

void expect_equal(const std::vector<AttributeCoding>& actual, const std::vector<AttributeCoding>& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (size_t i = 0; i < actual.size(); ++i) {
    EXPECT_EQ(actual[i].bits, expected[i].bits);
    EXPECT_EQ(actual[i].octahedral, expected[i].octahedral);
    EXPECT_EQ(actual[i].origin, expected[i].origin);
    EXPECT_EQ(actual[i].range, expected[i].range);
  }
}

// Normals without a direction come from the faces around a point, whichever parts these are in.
TEST(CellParts, NormalsWithoutADirection) {
  const TestFolder folder;
  for (const size_t step : {size_t{1}, size_t{50}}) {
    Mesh mesh = shape(10000, true);
    Attribute& normals = mesh.attributes[1];
    ASSERT_EQ(normals.semantic, "NORMAL");
    for (size_t i = 0; i < mesh.point_count; ++i)
      if (step == 1 || i % step == 7 || i < 20) std::memset(normals.values.data() + 12 * i, 0, 12);
    MeshFile file;
    file.objects.push_back({"", {{mesh, -1}}});
    repair_values(file);
    Parts parts = cut(mesh, folder, 1000);
    ASSERT_TRUE(parts.parts.ok()) << parts.parts.status().to_string();
    expect_as_reduced(**parts.parts, file.objects[0].parts[0].mesh);
    EXPECT_EQ(parts.losses.sentences(), file.losses.sentences());
    // The whole mesh has these codings, too.
    Mesh& repaired = file.objects[0].parts[0].mesh;
    const std::vector<AttributeCoding> expected = choose_codings(repaired, {});
    const std::vector<AttributeCoding>& actual = (*parts.parts)->codings();
    expect_equal(actual, expected);
  }
}

TEST(CellParts, CodingsAreThoseOfStoredPoints) {
  const TestFolder folder;
  Mesh mesh = shape(10000, true);
  const ReducedMesh stored = reduce(mesh, {false, true, true}, ThreadPool(1));
  // A point that no face uses, and one of a degenerate face.
  for (const float far : {-1000.0f, 1000.0f}) {
    append_points(mesh, 0, 1);
    std::memcpy(mesh.attributes[0].values.data() + (mesh.point_count - 1) * size_t{12}, &far, sizeof(far));
  }
  mesh.faces.push_back({0, 0, mesh.point_count - 1});
  const Parts parts = cut(mesh, folder, 1000);
  ASSERT_TRUE(parts.parts.ok()) << parts.parts.status().to_string();
  Mesh expected = stored.mesh;
  expect_equal((*parts.parts)->codings(), choose_codings(expected, {}));
}

TEST(CellParts, TooManyNormalsWithoutADirectionAreAnError) {
  const TestFolder folder;
  Mesh mesh = shape(10000, true);
  std::memset(mesh.attributes[1].values.data(), 0, 12 * 2000);
  std::unique_ptr<Parts> result = begin(folder);
  const std::vector<Attribute> layout = mesh.attributes;
  ASSERT_TRUE(result->spool->begin(layout, 0, false).ok());
  const Status status = result->spool->add_points(layout, mesh.point_count, {});
  EXPECT_EQ(status.code(), StatusCode::kUnsupported);
  EXPECT_TRUE(contains(status.message(), "no direction"));
}

TEST(CellParts, EqualPositionsInMassesAreAnError) {
  const TestFolder folder;
  Mesh mesh = make_grid(50, 50);
  std::ranges::fill(mesh.attributes[0].values, std::byte{0});
  Parts parts = cut(mesh, folder, 100);
  ASSERT_FALSE(parts.parts.ok());
  EXPECT_EQ(parts.parts.status().code(), StatusCode::kUnsupported);
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

}  // namespace
}  // namespace psplit
