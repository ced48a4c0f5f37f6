// The estimates of memory that --memory admits assets by, held against measured peaks.
#include "tools/gltf_psplit/batch/memory_estimate.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "psplit/encode.h"
#include "tests/support/choose_codings.h"
#include "tests/support/mesh_file_seeds.h"
#include "tests/support/stock_stream.h"
#include "tests/tools/batch/posix/batch_jobs.h"

namespace psplit {
namespace {

// A wavy grid, as the formats store it.
struct Grid {
  using Vector = std::array<float, 3>;
  std::vector<Vector> points;
  std::vector<std::array<uint32_t, 3>> faces;

  explicit Grid(uint32_t size) {
    const auto height = [](float x, float y) {
      return std::sin(x * 0.1f) * std::cos(y * 0.07f) * 5 + std::sin(x * y);
    };
    for (uint32_t y = 0; y <= size; ++y)
      for (uint32_t x = 0; x <= size; ++x) {
        const auto a = static_cast<float>(x), b = static_cast<float>(y);
        points.push_back({a, b, height(a, b)});
      }
    for (uint32_t y = 0; y < size; ++y)
      for (uint32_t x = 0; x < size; ++x) {
        const uint32_t at = y * (size + 1) + x;
        faces.push_back({at, at + 1, at + size + 2});
        faces.push_back({at, at + size + 2, at + size + 1});
      }
  }
  static std::string line(const char* begin, const Vector& v) {
    char text[96];
    std::snprintf(text, sizeof(text), "%s%.6f %.6f %.6f\n", begin, double{v[0]}, double{v[1]}, double{v[2]});
    return text;
  }
  Vector normal(const std::array<uint32_t, 3>& face) const {
    Vector u, v;
    for (size_t i = 0; i < 3; ++i) {
      u[i] = points[face[1]][i] - points[face[0]][i];
      v[i] = points[face[2]][i] - points[face[0]][i];
    }
    return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  }

  // `flat`: each face has a normal, otherwise each point.
  std::string obj(bool flat) const {
    std::string text;
    for (const Vector& point : points) text += line("v ", point);
    if (flat)
      for (const auto& face : faces) text += line("vn ", normal(face));
    else
      for (const Vector& point : points) text += line("vn ", {0, point[2] / 9, 1});
    for (size_t i = 0; i < faces.size(); ++i) {
      text += "f";
      for (const uint32_t point : faces[i])
        text += " " + std::to_string(point + 1) + "//" + std::to_string(flat ? i + 1 : point + 1);
      text += "\n";
    }
    return text;
  }
  std::string ply(bool is_text) const {
    std::string file = std::string("ply\nformat ") + (is_text ? "ascii" : "binary_little_endian") +
                       " 1.0\nelement vertex " + std::to_string(points.size()) +
                       "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                       std::to_string(faces.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const Vector& point : points) {
      if (is_text)
        file += line("", point);
      else
        put(file, point);
    }
    for (const auto& face : faces) {
      if (is_text)
        file += "3 " + std::to_string(face[0]) + " " + std::to_string(face[1]) + " " + std::to_string(face[2]) +
                "\n";
      else
        put(file += '\3', face);
    }
    return file;
  }
  std::string text_stl() const {
    std::string file = "solid grid\n";
    for (const auto& face : faces) {
      file += line("facet normal ", normal(face)) + "outer loop\n";
      for (const uint32_t point : face) file += line("vertex ", points[point]);
      file += "endloop\nendfacet\n";
    }
    return file + "endsolid grid\n";
  }
  std::string binary_stl() const {
    std::vector<StlFacet> facets(faces.size());
    for (size_t i = 0; i < faces.size(); ++i) {
      std::ranges::copy(normal(faces[i]), facets[i].begin());
      for (size_t c = 0; c < 3; ++c) std::ranges::copy(points[faces[i][c]], &facets[i][3 * (c + 1)]);
    }
    return psplit::binary_stl(facets);
  }
  std::string draco() const {
    Mesh mesh;
    mesh.point_count = static_cast<uint32_t>(points.size());
    mesh.faces.assign(faces.begin(), faces.end());
    Attribute position{"POSITION", ComponentType::kFloat32, 3, false, {}};
    position.values.resize(points.size() * sizeof(Vector));
    std::memcpy(position.values.data(), points.data(), position.values.size());
    mesh.attributes.push_back(std::move(position));
    const StockStream stream = must(encode_stock_stream(mesh, choose_codings(mesh, {}), 5));
    return {stream.bytes.begin(), stream.bytes.end()};
  }

 private:
  template <typename Value>
  static void put(std::string& file, const Value& value) {
    file.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
};

class MemoryEstimate : public BatchJobs {
 protected:
  // The worker is a process of its own, and works on this asset only.
  void expect_bound(const std::string& input, const std::string& verb, const std::string& folder, double most) {
    ASSERT_EQ(shell("$P batch " + input + " -o " + folder + " -q -j 2 --progress json --command " + verb), 0)
        << err_;
    const Json memory = Json::parse(out_)["memory"];
    const auto bound = memory["estimate"].get<double>() + static_cast<double>(kProcessMemory);
    const auto peak = memory["peak_of_process"].get<double>();
    EXPECT_GE(bound, peak) << verb << " " << input;
    EXPECT_LE(bound, most * peak) << verb << " " << input;
  }
};

TEST_F(MemoryEstimate, BoundsPeaksOfGltf) {
  if (!kMeasuresMemory) GTEST_SKIP() << "a sanitizer takes memory, too";
  for (const auto& [name, options] :
       std::map<std::string, std::string>{{"terrain", "--shape terrain --faces 150k"},
                                          {"gyroid", "--shape gyroid --faces 80k --normals --texcoords"},
                                          {"scene", "--shape scene --faces 100k --normals"}}) {
    ASSERT_EQ(shell("$P generate " + name + ".glb -q " + options), 0) << err_;
    expect_bound(name + ".glb", "encode", "out", 3);
    expect_bound(name + ".glb", "diff", "out", 3);
    expect_bound("out/" + name + ".glb", "decode", "out2", 3);
    expect_bound("out/" + name + ".glb", "validate", "out2", 3);
  }
  ASSERT_EQ(shell("$P encode terrain.glb stock.glb --patches 1 -q"), 0) << err_;
  expect_bound("stock.glb", "encode", "out", 3);
}

TEST_F(MemoryEstimate, BoundsPeaksOfMeshFiles) {
  if (!kMeasuresMemory) GTEST_SKIP() << "a sanitizer takes memory, too";
  const Grid grid(300);
  const std::map<std::string, std::string> files{
      {"smooth.obj", grid.obj(false)}, {"flat.obj", grid.obj(true)},  {"text.ply", grid.ply(true)},
      {"binary.ply", grid.ply(false)}, {"text.stl", grid.text_stl()}, {"binary.stl", grid.binary_stl()},
      {"grid.drc", grid.draco()}};
  for (const auto& [name, bytes] : files) {
    write(name, bytes);
    // The peak depends on which threads are at work at the same time. The bound of decoding is that of patches;
    // of a mesh file no more is in memory than its arrays.
    expect_bound(name, "encode", "out", 3);
    expect_bound(name, "decode", "out2", 6);
    if (name.ends_with(".drc")) continue;
    ASSERT_EQ(shell("gzip -1 " + name), 0);
    expect_bound(name + ".gz", "encode", "out3", 3);
  }
}

TEST_F(MemoryEstimate, OfBrokenFilesIsFinite) {
  write("a.ply",
        "ply\nformat binary_little_endian 1.0\nelement vertex 99999999999999\nproperty float x\n"
        "element face 99999999999999\nproperty list uchar int vertex_indices\nend_header\n");
  write("a.obj", std::string(100000, 'f'));
  write("b.obj", "f 1 2 3");
  write("a.stl", "solid");
  write("b.stl", "");
  write("a.drc", "DRACO\2\2\1\1");
  write("a.off", "OFF 99999999999999999999 -1");
  write("a.obj.gz", "\x1f\x8b\x08 broken");
  for (const char* name :
       {"a.ply", "a.obj", "b.obj", "a.stl", "b.stl", "a.drc", "a.off", "a.obj.gz", "missing.obj"})
    EXPECT_LT(estimate_memory(path(name), BatchVerb::kEncode), uint64_t{64} << 20) << name;
}

}  // namespace
}  // namespace psplit
