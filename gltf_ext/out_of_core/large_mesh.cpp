#include "gltf_ext/out_of_core/large_mesh.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "encoder/coding/quantization.h"
#include "gltf_ext/primitive/view_in_place.h"
#include "mesh_files/mesh_file.h"

namespace psplit {
namespace {

constexpr size_t kBlockBytes = size_t{1} << 20;

void release_values(const ValuesView& values, size_t first, size_t count) {
  const auto* const begin = reinterpret_cast<const uint8_t*>(values.at(first));
  release_mapped({begin, (count - 1) * values.step() + values.value_bytes()});
}

}  // namespace

Expected<LargeMesh> LargeMesh::open(MeshView view, std::span<const uint8_t> numbers, Options options,
                                    const std::string& positions) {
  LargeMesh mesh(std::move(view), std::move(options));
  for (size_t i = 0; i < mesh.mesh_.attributes.size(); ++i) {
    const auto& [semantic, values] = mesh.mesh_.attributes[i];
    const bool is_float = values.component_type == ComponentType::kFloat32 && values.component_count == 3;
    if (values.component_type == ComponentType::kUint32)
      return unsupported(semantic + " holds 32-bit integers");
    if (semantic == "POSITION") {
      if (!is_float) return unsupported("positions that are not floats do not fit into --memory");
      mesh.position_ = i;
      mesh.position_offset_ = mesh.record_bytes_;
    }
    mesh.attributes_.push_back(
        {semantic, values.component_type, values.component_count, values.normalized, {}});
    mesh.record_bytes_ += values.value_bytes();
  }
  if (!numbers.empty()) {
    mesh.mesh_.attributes.push_back(
        {"", {ComponentType::kUint32, 3, false, mesh.mesh_.point_count, std::as_bytes(numbers)}});
    mesh.record_bytes_ += mesh.mesh_.attributes.back().values.value_bytes();
  }
  if (mesh.mesh_.point_count == UINT32_MAX) return unsupported("more points than 32 bits can count");
  if (mesh.face_count() == 0) return unsupported("has no triangles");
  Status status = mesh.measure_positions(positions);
  if (status.ok()) status = mesh.measure_faces();
  if (!status.ok()) return status;
  return mesh;
}

Status LargeMesh::measure_positions(const std::string& name) {
  uint64_t first = 0;
  std::optional<uint64_t> not_finite;
  const auto measure = [&](std::span<const Position> positions) {
    for (size_t i = 0; i < positions.size() && !not_finite; ++i) {
      // In memory, positions that are not finite are stored exactly. They belong to no cell.
      if (!is_finite(positions[i])) not_finite = first + i;
      for (size_t axis = 0; axis < 3; ++axis) {
        box_.low[axis] = std::min(box_.low[axis], positions[i][axis]);
        box_.high[axis] = std::max(box_.high[axis], positions[i][axis]);
      }
    }
    first += positions.size();
  };
  Status status = for_each_position(measure);
  if (status.ok() && not_finite)
    return invalid_input(name + ": the position of point " + std::to_string(*not_finite) + " is not finite");
  return status;
}

Status LargeMesh::measure_faces() {
  uint64_t first = 0;
  return for_each_face([&](std::span<const Face> faces) -> Status {
    for (size_t i = 0; i < faces.size() && options_.samples_edges; ++i) {
      const auto [a, b, c] = faces[i];
      if (edges_.wants(first + i)) edges_.add(first + i, {position_at(a), position_at(b), position_at(c)});
    }
    if (options_.samples_edges) release_values(mesh_.attributes[position_].values, 0, mesh_.point_count);
    first += faces.size();
    if (!has_proper_face_) look_for_proper_face(faces);
    return {};
  });
}

Position LargeMesh::position_at(uint32_t point) const {
  Position position;
  std::memcpy(position.data(), mesh_.attributes[position_].values.at(point), sizeof(position));
  return position;
}

// Looks at no more faces once it has found one.
void LargeMesh::look_for_proper_face(std::span<const Face> faces) {
  std::array<std::vector<uint8_t>, 3> records;
  for (std::vector<uint8_t>& record : records) record.resize(record_bytes_);
  for (size_t i = 0; i < faces.size() && !has_proper_face_; ++i) {
    const auto [a, b, c] = faces[i];
    if (a == b || b == c || c == a) continue;
    has_proper_face_ = options_.keep_duplicates;
    if (has_proper_face_) continue;
    for (size_t k = 0; k < 3; ++k) gather(faces[i][k], 1, records[k]);
    has_proper_face_ = records[0] != records[1] && records[1] != records[2] && records[2] != records[0];
  }
}

// The records of consecutive points.
void LargeMesh::gather(uint64_t first, size_t count, std::span<uint8_t> records) const {
  const auto begin = static_cast<size_t>(first);
  size_t offset = 0;
  for (size_t i = 0; i < mesh_.attributes.size(); ++i) {
    const ValuesView& values = mesh_.attributes[i].values;
    const size_t width = values.value_bytes();
    Attribute column{
        mesh_.attributes[i].semantic, values.component_type, values.component_count, values.normalized, {}};
    column.values.resize(count * width);
    for (size_t k = 0; k < count; ++k)
      std::memcpy(column.values.data() + k * width, values.at(begin + k), width);
    release_values(values, begin, count);
    if (wanted_bits(column, options_.coding) > 0) trim_noise(column);
    for (size_t k = 0; k < count; ++k)
      std::memcpy(records.data() + k * record_bytes_ + offset, column.values.data() + k * width, width);
    offset += width;
  }
}

Status LargeMesh::for_each_point(const VisitPoints& visit) const {
  const uint64_t at_once = kBlockBytes / (3 * record_bytes_) * 3;
  std::vector<uint8_t> records;
  for (uint64_t first = 0; first < point_count(); first += at_once) {
    const auto count = static_cast<size_t>(std::min(at_once, point_count() - first));
    records.resize(count * record_bytes_);
    gather(first, count, records);
    if (Status status = visit(first, records); !status.ok()) return status;
  }
  return {};
}

Position LargeMesh::position_of(const uint8_t* record) const {
  Position position;
  std::memcpy(position.data(), record + position_offset_, sizeof(position));
  return position;
}

Status LargeMesh::for_each_position(const std::function<void(std::span<const Position>)>& visit) const {
  constexpr uint64_t kAtOnce = kBlockBytes / sizeof(Position);
  std::vector<Position> positions;
  for (uint64_t first = 0; first < point_count(); first += kAtOnce) {
    positions.resize(static_cast<size_t>(std::min(kAtOnce, point_count() - first)));
    for (size_t i = 0; i < positions.size(); ++i) positions[i] = position_at(static_cast<uint32_t>(first + i));
    release_values(mesh_.attributes[position_].values, static_cast<size_t>(first), positions.size());
    visit(positions);
  }
  return {};
}

Status LargeMesh::read_faces(uint64_t first, std::span<Face> faces) const {
  const size_t begin = static_cast<size_t>(3 * first), count = 3 * faces.size();
  Status status = read_indices(mesh_.indices, begin, mesh_.point_count, {faces.front().data(), count});
  if (!is_soup()) release_values(mesh_.indices, begin, count);
  return status;
}

Status LargeMesh::for_each_face(const std::function<Status(std::span<const Face>)>& visit) const {
  constexpr uint64_t kAtOnce = kBlockBytes / sizeof(Face);
  std::vector<Face> faces;
  for (uint64_t first = 0; first < face_count(); first += kAtOnce) {
    faces.resize(static_cast<size_t>(std::min(kAtOnce, face_count() - first)));
    if (Status status = read_faces(first, faces); !status.ok()) return status;
    if (Status status = visit(faces); !status.ok()) return status;
  }
  return {};
}

}  // namespace psplit
