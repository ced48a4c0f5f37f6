// Compares psplit's partition with METIS k-way, on the same graph of faces and shared edges, with the paper's
// method, and with meshoptimizer's meshlets if these can be large enough.
//
//   partition_benchmark ROUNDS [FACES]    for a generated mesh, or for PSPLIT_BENCH_MESH's file; a line of JSON
//                                         for each size of patches, for scripts/bench --page partition
//   partition_benchmark --benchmark_...   times only, with Google Benchmark's options, for scripts/bench
//
// METIS gets its graph ready-made; psplit builds its own. psplit, METIS and, in the first two
// rounds, the paper's method, which takes seconds, run in turn. Meshlets are built once.
#include <benchmark/benchmark.h>
#include <meshoptimizer.h>
#include <metis.h>

#include <functional>
#include <string_view>

#include "bench/samples.h"
#include "encoder/partition/cell_graph.h"
#include "encoder/partition/partition.h"
#include "encoder/welding/reduce.h"
#include "gltf_ext/json/json.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

constexpr uint64_t kUsualFaces = 1'000'000;
constexpr uint32_t kPatchFaces[] = {4800, 1200, 440};
constexpr uint32_t kMostMeshletFaces = 512;
constexpr int kMostRoundsOfPaper = 2;

// Points of one position are one, and no face repeats a point: what the encoder cuts.
Mesh surface(uint64_t faces) {
  return reduce(bench_mesh(faces, false), {.drop_degenerate = true}, ThreadPool()).mesh;
}

double ms_of(const std::function<void()>& work) {
  const Stopwatch watch;
  work();
  return watch.ms();
}

struct Quality {
  uint32_t patches = 0, apart = 0, not_disks = 0;  // patches with several components; others that are not disks
  double replication = 0, balance = 0;
};

// For a patch: whether its faces are connected by edges, and vertices - edges + faces.
struct Shape2d {
  bool is_connected = true;
  int64_t euler = 0;
};
Shape2d shape_of(const Mesh& mesh, std::span<const uint32_t> faces) {
  std::vector<uint32_t> vertices;
  std::vector<std::pair<uint64_t, uint32_t>> sides;
  for (uint32_t i = 0; i < faces.size(); ++i)
    for (size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(mesh.faces[faces[i]][k], mesh.faces[faces[i]][(k + 1) % 3]);
      vertices.push_back(mesh.faces[faces[i]][k]);
      sides.emplace_back(uint64_t{low} << 32 | high, i);
    }
  std::sort(vertices.begin(), vertices.end());
  std::sort(sides.begin(), sides.end());
  std::vector<uint32_t> parent(faces.size());
  for (uint32_t i = 0; i < parent.size(); ++i) parent[i] = i;
  const auto root = [&](uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  Shape2d shape;
  uint32_t components = static_cast<uint32_t>(faces.size());
  for (size_t i = 0; i < sides.size(); ++i) {
    if (i == 0 || sides[i].first != sides[i - 1].first) {
      --shape.euler;
      continue;
    }
    const uint32_t a = root(sides[i].second), b = root(sides[i - 1].second);
    if (a != b) --components;
    parent[a] = b;
  }
  shape.is_connected = components == 1;
  shape.euler += std::unique(vertices.begin(), vertices.end()) - vertices.begin();
  shape.euler += static_cast<int64_t>(faces.size());
  return shape;
}

Quality quality_of(const Mesh& mesh, const std::vector<uint32_t>& patch_of_face, uint32_t patch_count) {
  Quality quality;
  std::vector<std::vector<uint32_t>> patches(patch_count);
  for (uint32_t face = 0; face < patch_of_face.size(); ++face) patches[patch_of_face[face]].push_back(face);
  std::vector<uint8_t> used(mesh.point_count, 0);
  uint64_t copies = 0;
  size_t largest = 0;
  for (const std::vector<uint32_t>& patch : patches) {
    if (patch.empty()) continue;
    ++quality.patches;
    largest = std::max(largest, patch.size());
    const Shape2d shape = shape_of(mesh, patch);
    if (!shape.is_connected)
      ++quality.apart;
    else if (shape.euler != 1)
      ++quality.not_disks;
    std::vector<uint32_t> points;
    for (const uint32_t face : patch)
      points.insert(points.end(), mesh.faces[face].begin(), mesh.faces[face].end());
    std::sort(points.begin(), points.end());
    points.erase(std::unique(points.begin(), points.end()), points.end());
    copies += points.size();
    for (const uint32_t point : points) used[point] = 1;
  }
  const auto points = static_cast<uint64_t>(std::count(used.begin(), used.end(), 1));
  quality.replication = static_cast<double>(copies - points) / static_cast<double>(points);
  quality.balance = static_cast<double>(largest) * quality.patches / static_cast<double>(patch_of_face.size());
  return quality;
}

struct MetisGraph {
  std::vector<idx_t> start{0}, neighbours;
};
MetisGraph metis_graph(const FaceGraph& faces) {
  MetisGraph graph;
  for (uint32_t face = 0; face < faces.cell_count(); ++face) {
    faces.for_each_link(face,
                        [&](uint32_t next, uint32_t) { graph.neighbours.push_back(static_cast<idx_t>(next)); });
    graph.start.push_back(static_cast<idx_t>(graph.neighbours.size()));
  }
  return graph;
}

std::vector<uint32_t> metis(MetisGraph& graph, uint32_t patch_count) {
  auto face_count = static_cast<idx_t>(graph.start.size() - 1), parts = static_cast<idx_t>(patch_count);
  std::vector<idx_t> part(graph.start.size() - 1);
  idx_t constraints = 1, cut = 0;
  METIS_PartGraphKway(&face_count, &constraints, graph.start.data(), graph.neighbours.data(), nullptr, nullptr,
                      nullptr, &parts, nullptr, nullptr, nullptr, &cut, part.data());
  return {part.begin(), part.end()};
}

// Meshlets of at most `most_faces` faces. meshoptimizer does not say which faces the triangles of a meshlet
// are, so they are searched.
std::vector<uint32_t> meshlets(const Mesh& mesh, size_t most_faces, double& ms) {
  constexpr size_t kMostVertices = 255;
  const size_t index_count = 3 * mesh.faces.size();
  const std::vector<std::array<float, 3>> at = positions_of(mesh);
  std::vector<meshopt_Meshlet> made(meshopt_buildMeshletsBound(index_count, kMostVertices, most_faces));
  std::vector<unsigned int> vertices(made.size() * kMostVertices);
  std::vector<unsigned char> triangles(made.size() * most_faces * 3);
  ms = ms_of([&] {
    made.resize(meshopt_buildMeshlets(made.data(), vertices.data(), triangles.data(), mesh.faces.data()->data(),
                                      index_count, at.data()->data(), at.size(), sizeof at[0], kMostVertices,
                                      most_faces, 0));
  });
  std::map<std::array<uint32_t, 3>, std::vector<uint32_t>> faces_of;
  const auto key = [](std::array<uint32_t, 3> face) {
    std::sort(face.begin(), face.end());
    return face;
  };
  for (uint32_t face = 0; face < mesh.faces.size(); ++face) faces_of[key(mesh.faces[face])].push_back(face);
  std::vector<uint32_t> patch_of(mesh.faces.size());
  for (uint32_t patch = 0; patch < made.size(); ++patch)
    for (uint32_t i = 0; i < made[patch].triangle_count; ++i) {
      std::array<uint32_t, 3> face{};
      for (uint32_t k = 0; k < 3; ++k)
        face[k] = vertices[made[patch].vertex_offset + triangles[made[patch].triangle_offset + 3 * i + k]];
      std::vector<uint32_t>& same = faces_of[key(face)];
      patch_of[same.back()] = patch;
      same.pop_back();
    }
  return patch_of;
}

Json contender(const Mesh& mesh, const std::vector<uint32_t>& patch_of,
               const std::vector<double>& one_thread_ms, const std::vector<double>& two_threads_ms) {
  const Quality quality = quality_of(mesh, patch_of, *std::max_element(patch_of.begin(), patch_of.end()) + 1);
  return {{"patches", quality.patches},      {"replication", quality.replication},
          {"balance", quality.balance},      {"apart", quality.apart},
          {"not_disks", quality.not_disks},  {"one_thread_ms", one_thread_ms},
          {"two_threads_ms", two_threads_ms}};
}

void compare(const Mesh& mesh, int rounds) {
  const ThreadPool one(1), two(2);
  MetisGraph for_metis = metis_graph(face_graph(mesh.faces, mesh.point_count, two));
  for (const uint32_t patch_faces : kPatchFaces) {
    const auto patch_count = static_cast<uint32_t>(std::max<size_t>(1, mesh.faces.size() / patch_faces));
    PartitionOptions options, paper;
    options.patch_count = paper.patch_count = patch_count;
    paper.method = PartitionMethod::kPaper;
    paper.distance = PathDistance::kGeodesic;
    std::vector<uint32_t> ours, theirs, papers;
    const auto partition = [&](const PartitionOptions& how, const ThreadPool& pool) {
      return partition_faces(mesh.faces, mesh.point_count, how, pool).patch_of_face;
    };
    std::vector<double> one_ms, two_ms, theirs_ms, papers_ms;
    for (int i = 0; i < rounds; ++i) {
      theirs_ms.push_back(ms_of([&] { theirs = metis(for_metis, patch_count); }));
      one_ms.push_back(ms_of([&] { ours = partition(options, one); }));
      two_ms.push_back(ms_of([&] { ours = partition(options, two); }));
      if (i < kMostRoundsOfPaper) papers_ms.push_back(ms_of([&] { papers = partition(paper, two); }));
    }
    Json line{{"faces", mesh.faces.size()},
              {"patch_faces", patch_faces},
              {"psplit", contender(mesh, ours, one_ms, two_ms)},
              {"METIS", contender(mesh, theirs, theirs_ms, {})},
              {"paper", contender(mesh, papers, {}, papers_ms)}};
    if (patch_faces <= kMostMeshletFaces) {
      double ms = 0;
      const std::vector<uint32_t> patch_of = meshlets(mesh, patch_faces, ms);
      line["meshlets"] = contender(mesh, patch_of, {ms}, {});
    }
    std::printf("%s\n", line.dump().c_str());
    std::fflush(stdout);
  }
}

const Mesh& usual_mesh() {
  static const Mesh mesh = surface(kUsualFaces);
  return mesh;
}

void measure_ours(benchmark::State& state, uint32_t patch_faces, int thread_count) {
  const Mesh& mesh = usual_mesh();
  const ThreadPool pool(thread_count);
  PartitionOptions options;
  options.patch_count = static_cast<uint32_t>(mesh.faces.size() / patch_faces);
  for (auto _ : state) benchmark::DoNotOptimize(partition_faces(mesh.faces, mesh.point_count, options, pool));
}

void measure_metis(benchmark::State& state, uint32_t patch_faces) {
  const Mesh& mesh = usual_mesh();
  static MetisGraph graph = metis_graph(face_graph(mesh.faces, mesh.point_count, ThreadPool()));
  for (auto _ : state)
    benchmark::DoNotOptimize(metis(graph, static_cast<uint32_t>(mesh.faces.size() / patch_faces)));
}

void register_all() {
  const auto add = [](const std::string& name, auto measure) {
    benchmark::RegisterBenchmark(name.c_str(), measure)->Unit(benchmark::kMillisecond)->UseRealTime();
  };
  for (const uint32_t patch_faces : kPatchFaces) {
    const std::string name = "partition/" + std::to_string(patch_faces);
    for (const int thread_count : {1, 2})
      add(name + "/psplit/threads:" + std::to_string(thread_count),
          [=](benchmark::State& state) { measure_ours(state, patch_faces, thread_count); });
    add(name + "/metis", [=](benchmark::State& state) { measure_metis(state, patch_faces); });
  }
}

}  // namespace
}  // namespace psplit

int main(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]).starts_with("--benchmark_")) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
    psplit::register_all();
    benchmark::RunSpecifiedBenchmarks();
    return 0;
  }
  if (argc < 2) return std::fprintf(stderr, "usage: partition_benchmark ROUNDS [FACES] | --benchmark_...\n"), 1;
  const uint64_t faces = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : psplit::kUsualFaces;
  psplit::compare(psplit::surface(faces), std::max(1, std::atoi(argv[1])));
}
