#include "tools/gltf_psplit/shapes/shapes.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <set>

#include "tests/support/expect.h"

namespace psplit {
namespace {

using Vector = std::array<double, 3>;

std::vector<Mesh> generate(Shape shape, uint64_t faces, uint64_t seed, bool attributes, int threads = 2) {
  return must(generate_shape({shape, faces, seed, attributes, attributes}, ThreadPool(threads)));
}

size_t total_faces(const std::vector<Mesh>& meshes) {
  size_t count = 0;
  for (const Mesh& mesh : meshes) count += mesh.faces.size();
  return count;
}

std::array<float, 3> float3(const Attribute& attribute, uint32_t point) {
  std::array<float, 3> value;
  std::memcpy(value.data(), attribute.values.data() + point * sizeof value, sizeof value);
  return value;
}

Vector subtract(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  return {double{a[0]} - b[0], double{a[1]} - b[1], double{a[2]} - b[2]};
}
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Numbers the points by their positions, which seams do not split.
std::vector<uint32_t> weld_positions(const Mesh& mesh) {
  std::map<std::array<float, 3>, uint32_t> numbers;
  std::vector<uint32_t> vertex(mesh.point_count);
  for (uint32_t p = 0; p < mesh.point_count; ++p)
    vertex[p] =
        numbers.try_emplace(float3(mesh.attributes[0], p), static_cast<uint32_t>(numbers.size())).first->second;
  return vertex;
}

struct Edges {
  size_t repeated = 0, open = 0, vertices = 0, all = 0;
  bool manifold_vertices = true;
};

Edges count_edges(const Mesh& mesh) {
  const std::vector<uint32_t> vertex = weld_positions(mesh);
  std::set<std::pair<uint32_t, uint32_t>> directed;
  std::map<uint32_t, std::map<uint32_t, uint32_t>> around;  // for each vertex: from one neighbour to the next
  Edges edges;
  for (const auto& face : mesh.faces)
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t a = vertex[face[i]], b = vertex[face[(i + 1) % 3]], c = vertex[face[(i + 2) % 3]];
      edges.repeated += !directed.insert({a, b}).second;
      around[a][b] = c;
    }
  for (const auto& [a, b] : directed) edges.open += !directed.contains({b, a});
  edges.vertices = around.size();
  edges.all = (directed.size() + edges.open) / 2;
  for (const auto& [centre, next] : around) {
    // There is one fan: a walk from its start, or from anywhere if it is closed, passes every face.
    std::set<uint32_t> ends;
    for (const auto& [from, to] : next) ends.insert(to);
    uint32_t at = next.begin()->first;
    for (const auto& [from, to] : next)
      if (!ends.contains(from)) at = from;
    size_t steps = 0;
    for (auto entry = next.find(at); entry != next.end() && steps < next.size(); ++steps)
      entry = next.find(entry->second);
    edges.manifold_vertices &= steps == next.size();
  }
  return edges;
}

class EveryShape : public testing::TestWithParam<Shape> {};
INSTANTIATE_TEST_SUITE_P(Shapes, EveryShape,
                         testing::Values(Shape::kTerrain, Shape::kBlob, Shape::kGyroid, Shape::kScene));

TEST_P(EveryShape, HasAboutTheNumberOfFacesAskedFor) {
  for (const uint64_t faces : {10'000u, 60'000u})
    EXPECT_NEAR(static_cast<double>(total_faces(generate(GetParam(), faces, 1, false))),
                static_cast<double>(faces), 0.02 * static_cast<double>(faces));
}

TEST_P(EveryShape, GivesSmallMeshesToo) {
  for (const uint64_t faces : {8u, 50u, 400u}) {
    const std::vector<Mesh> meshes = generate(GetParam(), faces, 1, true);
    EXPECT_GT(total_faces(meshes), 0u);
    EXPECT_LT(total_faces(meshes), 4 * faces + 300);
  }
}

TEST_P(EveryShape, IsTheSameForAnyNumberOfThreads) {
  const std::vector<Mesh> once = generate(GetParam(), 15'000, 5, true, 1);
  for (const int threads : {2, 7}) {
    const std::vector<Mesh> again = generate(GetParam(), 15'000, 5, true, threads);
    ASSERT_EQ(again.size(), once.size());
    for (size_t m = 0; m < once.size(); ++m) {
      EXPECT_EQ(again[m].faces, once[m].faces);
      ASSERT_EQ(again[m].attributes.size(), once[m].attributes.size());
      for (size_t a = 0; a < once[m].attributes.size(); ++a)
        EXPECT_EQ(again[m].attributes[a].values, once[m].attributes[a].values);
    }
  }
}

TEST_P(EveryShape, DiffersBetweenSeeds) {
  EXPECT_NE(generate(GetParam(), 5'000, 1, false)[0].attributes[0].values,
            generate(GetParam(), 5'000, 2, false)[0].attributes[0].values);
}

TEST_P(EveryShape, IsManifoldOrientedAndClosedExceptTerrain) {
  const std::vector<Mesh> meshes = generate(GetParam(), 30'000, 3, true);
  for (size_t m = 0; m < meshes.size(); ++m) {
    const Edges edges = count_edges(meshes[m]);
    EXPECT_EQ(edges.repeated, 0u);
    EXPECT_TRUE(edges.manifold_vertices);
    const bool is_terrain = GetParam() == Shape::kTerrain || (GetParam() == Shape::kScene && m == 0);
    if (is_terrain)
      EXPECT_GT(edges.open, 100u);
    else
      EXPECT_EQ(edges.open, 0u);
  }
}

TEST_P(EveryShape, HasNoEqualUnusedOrDegenerateParts) {
  for (const bool attributes : {false, true})
    for (const Mesh& mesh : generate(GetParam(), 20'000, 4, attributes)) {
      std::set<std::vector<std::byte>> points;
      std::vector<bool> used(mesh.point_count);
      for (uint32_t p = 0; p < mesh.point_count; ++p) {
        std::vector<std::byte> row;
        for (const Attribute& a : mesh.attributes) {
          const auto at = a.values.begin() + static_cast<std::ptrdiff_t>(p * a.stride());
          row.insert(row.end(), at, at + static_cast<std::ptrdiff_t>(a.stride()));
        }
        EXPECT_TRUE(points.insert(std::move(row)).second);
      }
      for (const auto& face : mesh.faces) {
        std::array<std::array<float, 3>, 3> p;
        for (size_t i = 0; i < 3; ++i) {
          ASSERT_LT(face[i], mesh.point_count);
          used[face[i]] = true;
          p[i] = float3(mesh.attributes[0], face[i]);
        }
        const Vector area = cross(subtract(p[1], p[0]), subtract(p[2], p[0]));
        EXPECT_GT(dot(area, area), 0);
      }
      EXPECT_EQ(std::ranges::count(used, false), 0);
    }
}

TEST_P(EveryShape, HasUnitNormalsThatLookOut) {
  for (const Mesh& mesh : generate(GetParam(), 40'000, 6, true)) {
    const Attribute& position = *mesh.find("POSITION");
    const Attribute& normal = *mesh.find("NORMAL");
    size_t agree = 0;
    for (const auto& face : mesh.faces) {
      const auto p = float3(position, face[0]), n = float3(normal, face[0]);
      const Vector out = {n[0], n[1], n[2]};
      EXPECT_NEAR(dot(out, out), 1, 1e-5);
      agree +=
          dot(out, cross(subtract(float3(position, face[1]), p), subtract(float3(position, face[2]), p))) > 0;
    }
    // Normals may differ at creases and at features that are finer than the grid.
    EXPECT_GT(static_cast<double>(agree), 0.85 * static_cast<double>(mesh.faces.size()));
  }
}

TEST_P(EveryShape, HasTextureSeamsInsideTheUnitSquare) {
  for (const Mesh& mesh : generate(GetParam(), 20'000, 7, true)) {
    const std::vector<uint32_t> vertex = weld_positions(mesh);
    EXPECT_GT(mesh.point_count, std::ranges::max(vertex) + 1);
    const Attribute& texcoord = *mesh.find("TEXCOORD_0");
    std::vector<float> values(size_t{2} * mesh.point_count);
    std::memcpy(values.data(), texcoord.values.data(), texcoord.values.size());
    for (const float value : values) EXPECT_TRUE(value >= 0 && value <= 1) << value;
  }
}

TEST_P(EveryShape, HasOnlyPositionsUnlessAskedForMore) {
  for (const Mesh& mesh : generate(GetParam(), 2'000, 1, false)) {
    ASSERT_EQ(mesh.attributes.size(), 1u);
    EXPECT_EQ(mesh.attributes[0].semantic, "POSITION");
    EXPECT_EQ(std::ranges::max(weld_positions(mesh)) + 1, mesh.point_count);
  }
}

TEST(Shapes, LookOutwards) {
  for (const Shape shape : {Shape::kBlob, Shape::kGyroid}) {
    const Mesh mesh = generate(shape, 20'000, 2, false)[0];
    double volume = 0;
    for (const auto& face : mesh.faces) {
      const auto a = float3(mesh.attributes[0], face[0]), b = float3(mesh.attributes[0], face[1]),
                 c = float3(mesh.attributes[0], face[2]);
      volume += dot({a[0], a[1], a[2]}, cross({b[0], b[1], b[2]}, {c[0], c[1], c[2]})) / 6;
    }
    EXPECT_GT(volume, 0.3);
    EXPECT_LT(volume, 4);
  }
}

TEST(Shapes, BlobHasFewHandlesAndGyroidMany) {
  const auto euler = [](const Mesh& mesh) {
    const Edges edges = count_edges(mesh);
    return static_cast<int64_t>(edges.vertices) - static_cast<int64_t>(edges.all) +
           static_cast<int64_t>(mesh.faces.size());
  };
  // Overhangs of its bumps may meet and form a handle.
  EXPECT_NEAR(static_cast<double>(euler(generate(Shape::kBlob, 30'000, 1, true)[0])), 2, 8);
  EXPECT_LT(euler(generate(Shape::kGyroid, 30'000, 1, true)[0]), -100);
}

TEST(Shapes, AreIrregular) {
  const Mesh mesh = generate(Shape::kBlob, 30'000, 1, false)[0];
  std::vector<uint32_t> valence(mesh.point_count);
  for (const auto& face : mesh.faces)
    for (const uint32_t point : face) ++valence[point];
  std::map<uint32_t, size_t> histogram;
  for (const uint32_t v : valence) ++histogram[v];
  for (const uint32_t v : {4u, 5u, 6u, 7u, 8u}) EXPECT_GT(histogram[v], mesh.point_count / 50) << v;
}

TEST(Shapes, SceneHasSixObjectsOfDifferentSizes) {
  const std::vector<Mesh> meshes = generate(Shape::kScene, 60'000, 1, false);
  ASSERT_EQ(meshes.size(), 6u);
  for (size_t i = 1; i < meshes.size(); ++i)
    EXPECT_LT(static_cast<double>(meshes[i].faces.size()),
              0.8 * static_cast<double>(meshes[i - 1].faces.size()));
}

TEST(Shapes, StreamsAreTheWholeMesh) {
  const ThreadPool pool(3);
  for (const Shape shape : {Shape::kTerrain, Shape::kBlob, Shape::kGyroid})
    for (const uint64_t faces : {300u, 70'000u}) {
      const ShapeOptions options{shape, faces, 9, true, false};
      const std::vector<Mesh> whole = must(generate_shape(options, pool));
      const ShapeStream stream = must(ShapeStream::open(options, pool));
      const Mesh& mesh = whole.front();
      EXPECT_EQ(stream.point_count(), mesh.point_count);
      EXPECT_EQ(stream.face_count(), mesh.faces.size());
      ShapePiece all;
      size_t pieces = 0;
      const auto take = [&](ShapePiece&& piece) -> Status {
        ++pieces;
        all.positions.insert(all.positions.end(), piece.positions.begin(), piece.positions.end());
        all.normals.insert(all.normals.end(), piece.normals.begin(), piece.normals.end());
        all.faces.insert(all.faces.end(), piece.faces.begin(), piece.faces.end());
        return {};
      };
      ASSERT_TRUE(stream.read(pool, take).ok());
      EXPECT_GE(pieces, faces > 1000 ? 3u : 1u);
      EXPECT_EQ(all.faces, mesh.faces);
      ASSERT_EQ(all.positions.size(), mesh.point_count);
      ASSERT_EQ(all.normals.size(), mesh.point_count);
      for (uint32_t p = 0; p < mesh.point_count; ++p) {
        EXPECT_EQ(all.positions[p], float3(*mesh.find("POSITION"), p));
        EXPECT_EQ(all.normals[p], float3(*mesh.find("NORMAL"), p));
      }
    }
}

TEST(Shapes, StreamsEndWithTheErrorOfTheirReader) {
  const ThreadPool pool(2);
  const ShapeStream stream = must(ShapeStream::open({Shape::kBlob, 20'000, 1, false, false}, pool));
  int calls = 0;
  const Status status =
      stream.read(pool, [&](ShapePiece&&) { return ++calls == 2 ? runtime_failure("enough") : Status(); });
  EXPECT_EQ(status.message(), "enough");
  EXPECT_EQ(calls, 2);
}

TEST(Shapes, StreamsHaveNeitherChartsNorSeveralMeshes) {
  const ThreadPool pool(1);
  EXPECT_EQ(ShapeStream::open({Shape::kScene, 20'000, 1, false, false}, pool).status().code(),
            StatusCode::kUsage);
  EXPECT_EQ(ShapeStream::open({Shape::kBlob, 20'000, 1, false, true}, pool).status().code(),
            StatusCode::kUsage);
}

// A hash of the bytes, so that a change of the generator shows here.
TEST(Shapes, AreTheMeshesOfEarlierVersions) {
  const std::pair<Shape, uint64_t> hashes[] = {{Shape::kTerrain, 7793790865704247561u},
                                               {Shape::kBlob, 13102126561443740113u},
                                               {Shape::kGyroid, 13691230929770490112u},
                                               {Shape::kScene, 14365990089734788639u}};
  for (const auto& [shape, hash] : hashes) {
    uint64_t sum = 0xcbf29ce484222325;  // FNV-1a
    const auto add = [&](const void* bytes, size_t size) {
      for (size_t i = 0; i < size; ++i) sum = (sum ^ static_cast<const uint8_t*>(bytes)[i]) * 0x100000001b3;
    };
    for (const Mesh& mesh : generate(shape, 12'000, 11, true)) {
      add(mesh.faces.data(), mesh.faces.size() * sizeof(mesh.faces[0]));
      for (const Attribute& attribute : mesh.attributes) add(attribute.values.data(), attribute.values.size());
    }
    EXPECT_EQ(sum, hash);
  }
}

TEST(Shapes, RefuseCountsOutOfRange) {
  const ThreadPool pool(1);
  for (const uint64_t faces : {uint64_t{0}, uint64_t{7}, uint64_t{1} << 60})
    EXPECT_EQ(generate_shape({Shape::kBlob, faces, 1, false, false}, pool).status().code(), StatusCode::kUsage);
}

}  // namespace
}  // namespace psplit
