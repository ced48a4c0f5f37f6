#include "encoder/cut_faces.h"

#include <algorithm>
#include <array>
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

Cut cut_faces(const WeldedMesh& welded, const PartitionOptions& options,
              std::span<const uint32_t> patch_of_face, const ThreadPool& pool) {
  const Mesh& mesh = *welded.mesh;
  size_t position = 0;
  while (mesh.attributes[position].semantic != "POSITION") ++position;
  const std::vector<uint32_t>& vertex = welded.value_of_point[position];
  uint32_t vertex_count = 0;
  Cut cut;
  std::vector<uint32_t> regular;  // none: all faces, as nearly always
  std::vector<std::array<uint32_t, 3>> vertices;
  vertices.reserve(mesh.faces.size());
  {
    std::vector<uint32_t> number(mesh.point_count, kNone);
    for (uint32_t i = 0; i < mesh.faces.size(); ++i) {
      std::array<uint32_t, 3> face{};
      for (size_t c = 0; c < 3; ++c) face[c] = vertex[mesh.faces[i][c]];
      if (repeats_a_point(face)) {  // only if it repeats a point (separate_flat_faces)
        if (cut.residue_faces.empty()) {
          regular.resize(i);
          std::iota(regular.begin(), regular.end(), 0u);
        }
        cut.residue_faces.push_back(i);
        continue;
      }
      for (uint32_t& v : face) {
        if (number[v] == kNone) number[v] = vertex_count++;
        v = number[v];
      }
      if (!cut.residue_faces.empty()) regular.push_back(i);
      vertices.push_back(face);
    }
  }
  if (vertices.empty()) return cut;
  const auto count = static_cast<uint32_t>(vertices.size());
  const auto face_of = [&](uint32_t i) { return cut.residue_faces.empty() ? i : regular[i]; };
  Partition partition;
  if (patch_of_face.empty()) {
    partition = partition_faces(std::move(vertices), vertex_count, options, pool);
  } else {
    for (uint32_t i = 0; i < count; ++i) partition.patch_of_face.push_back(patch_of_face[face_of(i)]);
    partition.patch_count =
        *std::max_element(partition.patch_of_face.begin(), partition.patch_of_face.end()) + 1;
  }
  cut.patches.resize(partition.patch_count);
  const bool has_neighbours = cut.residue_faces.empty() && !partition.neighbours.empty();
  std::vector<uint32_t> place(has_neighbours ? count : 0);  // of each face in its patch
  for (uint32_t i = 0; i < count; ++i) {
    std::vector<uint32_t>& patch = cut.patches[partition.patch_of_face[i]];
    if (has_neighbours) place[i] = static_cast<uint32_t>(patch.size());
    patch.push_back(face_of(i));
  }
  if (has_neighbours) {
    cut.neighbours = std::move(partition.neighbours);
    constexpr size_t kGrain = 1 << 14;
    pool.for_ranges(count, kGrain, [&](size_t begin, size_t end) {
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

PatchMesh PatchExtractor::extract(std::span<const uint32_t> faces,
                                  std::span<const std::array<uint32_t, 3>> neighbours) {
  PatchMesh patch;
  if (!neighbours.empty()) {
    patch.neighbours.reserve(faces.size());
    for (const uint32_t face : faces) patch.neighbours.push_back(neighbours[face]);
  }
  patch.faces.reserve(faces.size());
  for (const uint32_t face : faces)
    for (const uint32_t point : mesh_.faces[face])
      if (number_[point] == kNone) {
        number_[point] = 0;
        patch.points.push_back(point);
      }
  std::sort(patch.points.begin(), patch.points.end());
  for (uint32_t i = 0; i < patch.points.size(); ++i) number_[patch.points[i]] = i;
  for (const uint32_t face : faces) {
    const auto& [a, b, c] = mesh_.faces[face];
    patch.faces.push_back({number_[a], number_[b], number_[c]});
  }
  for (const uint32_t point : patch.points) number_[point] = kNone;
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
