// Partitioning: ours beside METIS k-way on the same graph of faces and shared edges, one thread each.
// Counters: replication of vertices in per cent, faces of the largest patch by those of the mean.
#include <benchmark/benchmark.h>
#include <metis.h>

#include <algorithm>
#include <unordered_map>

#include "bench/sample_meshes.h"
#include "encoder/partition/partition.h"

namespace psplit {
namespace {

const Mesh& input() {
  static const Mesh made = bench_mesh(1'000'000, false);
  return made;
}

void report(benchmark::State& state, const std::vector<uint32_t>& patch_of_face, uint32_t patch_count) {
  std::vector<uint64_t> uses;
  std::vector<uint32_t> sizes(patch_count, 0);
  std::vector<bool> used(input().point_count, false);
  for (size_t face = 0; face < patch_of_face.size(); ++face) {
    ++sizes[patch_of_face[face]];
    for (const uint32_t vertex : input().faces[face]) {
      uses.push_back(uint64_t{vertex} << 32 | patch_of_face[face]);
      used[vertex] = true;
    }
  }
  std::sort(uses.begin(), uses.end());
  const auto distinct = static_cast<double>(std::unique(uses.begin(), uses.end()) - uses.begin());
  const auto vertices = static_cast<double>(std::count(used.begin(), used.end(), true));
  state.counters["replication %"] = 100 * (distinct / vertices - 1);
  state.counters["balance"] = static_cast<double>(*std::max_element(sizes.begin(), sizes.end())) * patch_count /
                              static_cast<double>(patch_of_face.size());
}

uint32_t patch_count_of(const benchmark::State& state) {
  return static_cast<uint32_t>(input().faces.size() / static_cast<size_t>(state.range(0)));
}

void ours(benchmark::State& state) {
  const ThreadPool pool(1);
  PartitionOptions options;
  options.patch_count = patch_count_of(state);
  Partition partition;
  for (auto _ : state) partition = partition_faces(input().faces, input().point_count, options, pool);
  report(state, partition.patch_of_face, partition.patch_count);
}

// Faces that share an edge, as METIS takes them.
struct FaceGraph {
  std::vector<idx_t> start{0}, neighbours;
};
FaceGraph make_graph() {
  const auto& faces = input().faces;
  std::unordered_multimap<uint64_t, uint32_t> face_at;
  face_at.reserve(3 * faces.size());
  std::vector<std::vector<idx_t>> around(faces.size());
  for (uint32_t face = 0; face < faces.size(); ++face)
    for (size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(faces[face][k], faces[face][(k + 1) % 3]);
      const uint64_t edge = uint64_t{low} << 32 | high;
      const auto [first, last] = face_at.equal_range(edge);
      for (auto other = first; other != last; ++other) {
        around[face].push_back(static_cast<idx_t>(other->second));
        around[other->second].push_back(static_cast<idx_t>(face));
      }
      face_at.emplace(edge, face);
    }
  FaceGraph graph;
  for (const std::vector<idx_t>& some : around) {
    graph.neighbours.insert(graph.neighbours.end(), some.begin(), some.end());
    graph.start.push_back(static_cast<idx_t>(graph.neighbours.size()));
  }
  return graph;
}

// The graph is given to METIS; ours makes its own.
void metis(benchmark::State& state) {
  static FaceGraph graph = make_graph();
  auto patch_count = static_cast<idx_t>(patch_count_of(state));
  auto face_count = static_cast<idx_t>(input().faces.size());
  std::vector<idx_t> part(input().faces.size());
  idx_t constraints = 1, cut = 0;
  for (auto _ : state)
    METIS_PartGraphKway(&face_count, &constraints, graph.start.data(), graph.neighbours.data(), nullptr,
                        nullptr, nullptr, &patch_count, nullptr, nullptr, nullptr, &cut, part.data());
  report(state, {part.begin(), part.end()}, static_cast<uint32_t>(patch_count));
}

BENCHMARK(ours)->Arg(4800)->Arg(1200)->Arg(440)->Unit(benchmark::kMillisecond)->Name("ours/faces_a_patch");
BENCHMARK(metis)->Arg(4800)->Arg(1200)->Arg(440)->Unit(benchmark::kMillisecond)->Name("metis/faces_a_patch");

}  // namespace
}  // namespace psplit

BENCHMARK_MAIN();
