#include "encoder/cut_faces.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "encoder/welding/reduce.h"
#include "src/mesh/number_of.h"

namespace psplit {
namespace {

constexpr uint32_t kNone = 0xffffffffu;

using Vector = std::array<double, 3>;

Vector position_of(const Attribute& positions, uint32_t point) {
  Vector position{};
  const std::byte* at = positions.values.data() + point * positions.stride();
  for (double& component : position) {
    component = number_of(at, positions.component_type, positions.normalized);
    at += component_bytes(positions.component_type);
  }
  return position;
}
Vector difference(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double squared_length(const Vector& a) { return a[0] * a[0] + a[1] * a[1] + a[2] * a[2]; }

// Twice the area of the faces. Those without finite positions have none.
double area(const Mesh& mesh, const Attribute& positions, std::span<const uint32_t> faces) {
  double sum = 0;
  for (const uint32_t face : faces) {
    const auto& [a, b, c] = mesh.faces[face];
    const Vector origin = position_of(positions, a), u = difference(position_of(positions, b), origin),
                 v = difference(position_of(positions, c), origin);
    const double doubled = std::sqrt(
        squared_length({u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]}));
    if (std::isfinite(doubled)) sum += doubled;
  }
  return sum;
}

// The squared distance of the nearest point that the faces use.
double distance_to(const Vector& from, const Mesh& mesh, const Attribute& positions,
                   std::span<const uint32_t> faces) {
  double least = HUGE_VAL;
  for (const uint32_t face : faces)
    for (const uint32_t point : mesh.faces[face]) {
      const double squared = squared_length(difference(position_of(positions, point), from));
      if (squared < least) least = squared;
    }
  return least;
}

}  // namespace

namespace {

// The faces that are cut, by vertices.
struct Regular {
  std::vector<std::array<uint32_t, 3>> vertices;  // empty if they are the mesh's own faces
  uint32_t vertex_count = 0;
  std::vector<uint32_t> faces;  // of the mesh; empty if they are all of them
};

// Vertices get numbers in the order in which faces use them. Faces that repeat one go to `residue`.
Regular number_vertices(const Mesh& mesh, std::span<const uint32_t> vertex, std::vector<uint32_t>& residue) {
  Regular regular;
  regular.vertices.reserve(mesh.faces.size());
  std::vector<uint32_t> number(mesh.point_count, kNone);
  for (uint32_t i = 0; i < mesh.faces.size(); ++i) {
    std::array<uint32_t, 3> face{};
    for (size_t c = 0; c < 3; ++c) face[c] = vertex[mesh.faces[i][c]];
    if (repeats_a_point(face)) {  // only if it repeats a point (separate_flat_faces)
      if (residue.empty()) {
        regular.faces.resize(i);
        std::iota(regular.faces.begin(), regular.faces.end(), 0u);
      }
      residue.push_back(i);
      continue;
    }
    for (uint32_t& v : face) {
      if (number[v] == kNone) number[v] = regular.vertex_count++;
      v = number[v];
    }
    if (!residue.empty()) regular.faces.push_back(i);
    regular.vertices.push_back(face);
  }
  return regular;
}

constexpr size_t kCutAtOnce = 1 << 14;  // faces

bool any_repeats_a_point(const Mesh& mesh, const ThreadPool& pool) {
  std::atomic<bool> any = false;
  pool.for_ranges(mesh.faces.size(), kCutAtOnce, [&](size_t begin, size_t end) {
    bool in_range = false;
    for (size_t i = begin; i < end; ++i) in_range |= repeats_a_point(mesh.faces[i]);
    if (in_range) any = true;
  });
  return any;
}

// Lists the faces of each patch, in their order. `place` gets the place of each in its patch, if it has room.
void list_faces(const Partition& partition, const Regular& regular, const ThreadPool& pool,
                std::vector<std::vector<uint32_t>>& patches, std::span<uint32_t> place) {
  const std::vector<uint32_t>& patch_of = partition.patch_of_face;
  std::vector<uint32_t> counts(partition.patch_count, 0);
  for (const uint32_t patch : patch_of) ++counts[patch];
  patches.resize(partition.patch_count);
  // Each task reads all faces, and lists the faces of some patches.
  const auto task_count =
      std::clamp<size_t>(patch_of.size() / kCutAtOnce, 1, static_cast<size_t>(pool.thread_count()));
  pool.for_each(task_count, [&](size_t task) {
    const auto first = static_cast<uint32_t>(uint64_t{partition.patch_count} * task / task_count),
               end = static_cast<uint32_t>(uint64_t{partition.patch_count} * (task + 1) / task_count);
    for (uint32_t patch = first; patch < end; ++patch) patches[patch].reserve(counts[patch]);
    for (uint32_t i = 0; i < patch_of.size(); ++i) {
      if (patch_of[i] < first || patch_of[i] >= end) continue;
      std::vector<uint32_t>& patch = patches[patch_of[i]];
      if (!place.empty()) place[i] = static_cast<uint32_t>(patch.size());
      patch.push_back(regular.faces.empty() ? i : regular.faces[i]);
    }
  });
}

}  // namespace

Cut cut_faces(const WeldedMesh& welded, const PartitionOptions& options,
              std::span<const uint32_t> patch_of_face, const ThreadPool& pool) {
  const Mesh& mesh = *welded.mesh;
  size_t position = 0;
  while (mesh.attributes[position].semantic != "POSITION") ++position;
  const std::vector<uint32_t>& vertex = welded.value_of_point[position];
  Cut cut;
  Regular regular;
  // The paper's method depends on the numbers of vertices.
  if (options.method == PartitionMethod::kMultilevel && are_all_lowest(vertex) &&
      !any_repeats_a_point(mesh, pool))
    regular.vertex_count = mesh.point_count;
  else
    regular = number_vertices(mesh, vertex, cut.residue_faces);
  const size_t count = mesh.faces.size() - cut.residue_faces.size();
  if (count == 0) return cut;
  Partition partition;
  if (patch_of_face.empty()) {
    partition = regular.vertices.empty()
                    ? partition_faces(mesh.faces, regular.vertex_count, options, pool)
                    : partition_faces(std::move(regular.vertices), regular.vertex_count, options, pool);
  } else {
    for (uint32_t i = 0; i < count; ++i)
      partition.patch_of_face.push_back(patch_of_face[regular.faces.empty() ? i : regular.faces[i]]);
    partition.patch_count =
        *std::max_element(partition.patch_of_face.begin(), partition.patch_of_face.end()) + 1;
  }
  const bool has_neighbours = cut.residue_faces.empty() && !partition.neighbours.empty();
  std::vector<uint32_t> place(has_neighbours ? count : 0);  // of each face in its patch
  list_faces(partition, regular, pool, cut.patches, place);
  if (has_neighbours) {
    cut.neighbours = std::move(partition.neighbours);
    pool.for_ranges(count, kCutAtOnce, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i)
        for (uint32_t& next : cut.neighbours[i])
          if (next != kNone)
            next =
                partition.patch_of_face[next] == partition.patch_of_face[i] ? place[next] : PatchMesh::kNoFace;
    });
  }
  std::erase_if(cut.patches, [](const std::vector<uint32_t>& faces) { return faces.empty(); });
  return cut;
}

void order_patches(const Mesh& mesh, const PatchOrder& order, Cut& cut) {
  if (order.by == PatchOrder::By::kCut) return;
  const Attribute* const positions = mesh.find("POSITION");
  if (positions == nullptr || positions->component_count != 3) return;
  const auto key = [&](const std::vector<uint32_t>& faces) {
    return order.by == PatchOrder::By::kSize ? -area(mesh, *positions, faces)
                                             : distance_to(order.point, mesh, *positions, faces);
  };
  std::vector<std::pair<double, uint32_t>> keys;
  for (uint32_t i = 0; i < cut.patches.size(); ++i) keys.emplace_back(key(cut.patches[i]), i);
  std::sort(keys.begin(), keys.end());  // equal ones stay as they were
  std::vector<std::vector<uint32_t>> ordered;
  for (const auto& [_, patch] : keys) ordered.push_back(std::move(cut.patches[patch]));
  cut.patches = std::move(ordered);
}

// Takes the points in ascending order from bits. Sorting them took half of the time.
void PatchExtractor::take_used(std::vector<uint32_t>& points) {
  for (size_t i = 0; i < used_words_.size(); ++i)
    for (uint64_t words = std::exchange(used_words_[i], 0); words != 0; words &= words - 1) {
      const size_t word = i * 64 + static_cast<size_t>(std::countr_zero(words));
      for (uint64_t bits = std::exchange(used_[word], 0); bits != 0; bits &= bits - 1)
        points.push_back(static_cast<uint32_t>(word * 64 + static_cast<size_t>(std::countr_zero(bits))));
    }
}

PatchMesh PatchExtractor::extract(std::span<const uint32_t> faces,
                                  std::span<const std::array<uint32_t, 3>> neighbours) {
  PatchMesh patch;
  if (!neighbours.empty()) {
    patch.neighbours.reserve(faces.size());
    for (const uint32_t face : faces) patch.neighbours.push_back(neighbours[face]);
  }
  for (const uint32_t face : faces)
    for (const uint32_t point : mesh_.faces[face]) {
      used_[point / 64] |= uint64_t{1} << point % 64;
      used_words_[point / 4096] |= uint64_t{1} << point / 64 % 64;
    }
  patch.points.reserve(faces.size() / 2 + 64);
  take_used(patch.points);
  for (uint32_t i = 0; i < patch.points.size(); ++i) number_[patch.points[i]] = i;
  patch.faces.reserve(faces.size());
  for (const uint32_t face : faces) {
    const auto& [a, b, c] = mesh_.faces[face];
    patch.faces.push_back({number_[a], number_[b], number_[c]});
  }
  return patch;
}

Residue extract_residue(const Mesh& mesh, std::span<const uint32_t> residue_faces,
                        std::span<const uint8_t> is_in_patch, bool standalone) {
  Residue residue;
  residue.patch = PatchExtractor(mesh).extract(residue_faces, {});
  residue.face_count = static_cast<uint32_t>(residue_faces.size());
  std::vector<uint8_t> is_used(is_in_patch.begin(), is_in_patch.end());
  for (const uint32_t point : residue.patch.points) {
    residue.owned_count += is_in_patch[point] == 0 ? 1 : 0;
    is_used[point] = 1;
  }
  for (uint32_t point = 0; point < mesh.point_count; ++point) {
    if (is_used[point] != 0) continue;
    ++residue.owned_count;
    residue.patch.points.push_back(point);
  }
  while (residue.patch.faces.size() * 3 < residue.patch.points.size()) residue.patch.faces.push_back({0, 0, 0});
  if (standalone) return residue;
  // Decoders take a copy's values from its owner, so any value may be stored here. The one before costs least.
  for (const uint32_t point : residue.patch.points)
    residue.patch.value_points.push_back(is_in_patch[point] == 0 ? point
                                         : residue.patch.value_points.empty()
                                             ? residue.patch.points.front()
                                             : residue.patch.value_points.back());
  return residue;
}

}  // namespace psplit
