#include "gltf_ext/out_of_core/mesh_spool.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "encoder/coding/quantization.h"
#include "gltf_ext/files/operating_system.h"
#include "gltf_ext/mesh_files/repair_values.h"
#include "gltf_ext/primitive/view_in_place.h"

namespace psplit {
namespace {

constexpr size_t kBlockBytes = size_t{1} << 20;
constexpr uint64_t kMostPoints = UINT32_MAX - 1;

}  // namespace

Expected<std::unique_ptr<MeshSpool>> MeshSpool::create(SpoolOptions options, Losses& losses) {
  std::unique_ptr<MeshSpool> spool(new MeshSpool(std::move(options), losses));
  Expected<AppendFile> points = AppendFile::create(spool->options_.folder);
  if (!points) return points.status();
  Expected<AppendFile> faces = AppendFile::create(spool->options_.folder);
  if (!faces) return faces.status();
  spool->points_ = std::move(*points);
  spool->faces_ = std::move(*faces);
  return spool;
}

Status MeshSpool::begin(std::span<const Attribute> layout, size_t) {
  for (size_t i = 0; i < layout.size(); ++i) {
    if (options_.skip.contains(layout[i].semantic)) skipped_.push_back(layout[i].semantic);
    // Facets are records whose normals are left out when they are read.
    if (options_.skip.contains(layout[i].semantic) && !is_soup_) continue;
    attributes_.push_back(layout[i]);
    kept_.push_back(i);
  }
  for (size_t i = 0; i < attributes_.size(); ++i) {
    attributes_[i].values.clear();
    offsets_.push_back(record_bytes_);
    record_bytes_ += attributes_[i].stride();
    if (attributes_[i].semantic == "POSITION") position_ = i;
    if (attributes_[i].semantic == kPointNumber) has_numbered_points_ = true;
    if (attributes_[i].semantic == "NORMAL" && options_.repairs) normal_ = i;
  }
  return {};
}

Status MeshSpool::measure_positions(const Attribute& positions) {
  Position position;
  for (size_t at = 0; at < positions.values.size(); at += sizeof(position)) {
    std::memcpy(position.data(), positions.values.data() + at, sizeof(position));
    if (!std::ranges::all_of(position, [](float value) { return std::isfinite(value); }))
      return invalid_input("a position is not finite");
    include(position);
  }
  return {};
}

Status MeshSpool::too_many_zero_normals() const {
  return unsupported("more than " + std::to_string(options_.most_zero_normals) +
                     " normals have no direction, and others have one: they do not fit into --memory");
}

Status MeshSpool::repair_block_normals(Attribute& normals, size_t count) {
  std::vector<uint32_t> zeros;
  changed_normals_ += normalize(normals, static_cast<uint32_t>(point_count_), zeros);
  // Those without a direction are equal, whatever their bytes are: they are replaced or left out later.
  for (const uint32_t zero : zeros)
    std::memset(normals.values.data() + (zero - point_count_) * normals.stride(), 0, normals.stride());
  const bool only_zeros_before = zero_count_ == point_count_;
  zero_count_ += zeros.size();
  if (only_zeros_before && zeros.size() == count) return {};  // it is enough to count them
  if (zero_count_ > options_.most_zero_normals) return too_many_zero_normals();
  if (only_zeros_before)
    for (uint32_t point = 0; point < point_count_; ++point) zeros_.push_back(point);
  zeros_.insert(zeros_.end(), zeros.begin(), zeros.end());
  return {};
}

Status MeshSpool::add_points(std::span<const Attribute> block, size_t count) {
  if (point_count_ + count > kMostPoints) return unsupported("more points than 32 bits can count");
  block_.resize(count * record_bytes_);
  for (size_t i = 0; i < kept_.size(); ++i) {
    Attribute attribute = block[kept_[i]];
    if (options_.repairs) repair_floats(attribute, losses_);
    if (i == normal_)
      if (Status status = repair_block_normals(attribute, count); !status.ok()) return status;
    if (bits_of(attribute) > 0) trim_noise(attribute);
    if (i == position_)
      if (Status status = measure_positions(attribute); !status.ok()) return status;
    put_column(i, attribute, block_);
  }
  point_count_ += count;
  return points_.append(block_);
}

void MeshSpool::put_column(size_t attribute, const Attribute& column, std::span<uint8_t> records) const {
  const size_t width = column.stride();
  for (size_t k = 0; k < records.size() / record_bytes_; ++k)
    std::memcpy(records.data() + k * record_bytes_ + offsets_[attribute], column.values.data() + k * width,
                width);
}

// The records of points of the view.
void MeshSpool::gather(uint64_t first, size_t count, std::span<uint8_t> records) const {
  for (size_t i = 0; i < attributes_.size(); ++i) {
    const ValuesView& values = view_->attributes[i].values;
    Attribute column = attributes_[i];
    const size_t width = column.stride(), begin = static_cast<size_t>(first);
    column.values.resize(count * width);
    for (size_t k = 0; k < count; ++k)
      std::memcpy(column.values.data() + k * width, values.at(begin + k), width);
    const std::byte* const from = values.at(begin);
    release_mapped({reinterpret_cast<const uint8_t*>(from), (count - 1) * values.step() + width});
    if (bits_of(column) > 0) trim_noise(column);
    put_column(i, column, records);
  }
}

Status MeshSpool::measure_view(const std::string& positions) {
  Status status = for_each_point([&](uint64_t first, std::span<const uint8_t> records) -> Status {
    for (size_t i = 0; i < records.size() / record_bytes_; ++i) {
      const Position position = position_of(records.data() + i * record_bytes_);
      // In memory, positions that are not finite are stored exactly. They belong to no cell.
      if (!is_finite(position))
        return invalid_input(positions + ": the position of point " + std::to_string(first + i) +
                             " is not finite");
      include(position);
    }
    return {};
  });
  uint64_t first = 0;
  const auto look = [&](std::span<const Face> faces) -> Status {
    if (options_.samples_edges)
      if (Status sampled = sample_edges(first, faces); !sampled.ok()) return sampled;
    first += faces.size();
    return has_proper_face_ ? Status() : look_for_proper_face(faces);
  };
  return status.ok() ? for_each_face(look) : std::move(status);
}

Expected<std::unique_ptr<MeshSpool>> MeshSpool::view(MeshView mesh, SpoolOptions options, Losses& losses,
                                                     const std::string& positions) {
  options.repairs = false;
  options.skip.clear();
  std::vector<Attribute> layout;
  for (const auto& [semantic, values] : mesh.attributes) {
    const bool is_float = values.component_type == ComponentType::kFloat32 && values.component_count == 3;
    if (values.component_type == ComponentType::kUint32)
      return unsupported(semantic + " holds 32-bit integers");
    if (semantic == "POSITION" && !is_float)
      return unsupported("positions that are not floats do not fit into --memory");
    layout.push_back({semantic, values.component_type, values.component_count, values.normalized, {}});
  }
  if (mesh.point_count > kMostPoints) return unsupported("more points than 32 bits can count");
  std::unique_ptr<MeshSpool> spool(new MeshSpool(std::move(options), losses));
  Status status = spool->begin(layout, 0);
  spool->point_count_ = mesh.point_count;
  spool->face_count_ = mesh.indices.count / 3;
  spool->view_ = std::move(mesh);
  if (status.ok()) status = spool->finish();
  if (status.ok()) status = spool->measure_view(positions);
  if (!status.ok()) return status;
  return spool;
}

Status MeshSpool::add_faces(std::span<const Face> faces) {
  if (options_.samples_edges)
    if (Status status = sample_edges(face_count_, faces); !status.ok()) return status;
  if (!has_proper_face_)
    if (Status status = look_for_proper_face(faces); !status.ok()) return status;
  face_count_ += faces.size();
  if (!zeros_.empty()) {
    sums_.resize(zeros_.size());
    for (const Face& face : faces)
      if (Status status = add_to_zero_normals(face); !status.ok()) return status;
  }
  return faces_.append(bytes_of(faces));
}

Expected<std::array<Position, 3>> MeshSpool::corners_of(const Face& face) {
  std::array<Position, 3> corners;
  for (size_t i = 0; i < 3; ++i) {
    const Expected<Position> corner = position(face[i]);
    if (!corner) return corner.status();
    corners[i] = *corner;
  }
  return corners;
}

// Looks at no more faces once it has found one.
Status MeshSpool::look_for_proper_face(std::span<const Face> faces) {
  std::array<std::vector<uint8_t>, 3> records;
  for (std::vector<uint8_t>& record : records) record.resize(record_bytes_);
  for (const Face& face : faces) {
    if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) continue;
    if (options_.keep_duplicates && !has_numbered_points_) {
      has_proper_face_ = true;
      return {};
    }
    for (size_t i = 0; i < 3; ++i)
      if (Status status = read_record(face[i], 0, records[i]); !status.ok()) return status;
    has_proper_face_ = records[0] != records[1] && records[1] != records[2] && records[2] != records[0];
    if (has_proper_face_) return {};
  }
  return {};
}

Status MeshSpool::sample_edges(uint64_t first, std::span<const Face> faces) {
  for (size_t i = 0; i < faces.size(); ++i) {
    if (!edges_.wants(first + i)) continue;
    const Expected<std::array<Position, 3>> corners = corners_of(faces[i]);
    if (!corners) return corners.status();
    edges_.add(first + i, *corners);
  }
  return {};
}

Status MeshSpool::add_to_zero_normals(const Face& face) {
  std::array<size_t, 3> slots;
  for (size_t i = 0; i < 3; ++i) {
    const auto found = std::ranges::lower_bound(zeros_, face[i]);
    slots[i] = found != zeros_.end() && *found == face[i] ? static_cast<size_t>(found - zeros_.begin()) : kNone;
  }
  if (slots[0] == kNone && slots[1] == kNone && slots[2] == kNone) return {};
  const Expected<std::array<Position, 3>> corners = corners_of(face);
  if (!corners) return corners.status();
  const Sum normal = area_vector(*corners);
  for (const size_t slot : slots)
    if (slot != kNone)
      for (size_t axis = 0; axis < 3; ++axis) sums_[slot][axis] += normal[axis];
  return {};
}

Expected<Position> MeshSpool::position(uint32_t point) {
  Position position;
  Status status =
      read_record(point, offsets_[position_], {reinterpret_cast<uint8_t*>(position.data()), sizeof(position)});
  if (!status.ok()) return status;
  return position;
}

Status MeshSpool::read_record(uint32_t point, size_t offset, std::span<uint8_t> to) {
  if (view_) {
    std::vector<uint8_t> record(record_bytes_);
    gather(point, 1, record);
    std::copy_n(record.begin() + static_cast<std::ptrdiff_t>(offset), to.size(), to.begin());
    return {};
  }
  if (Status status = points_.flush(); !status.ok()) return status;
  return pages_.read(points_.file(), point_count_ * record_bytes_, uint64_t{point} * record_bytes_ + offset,
                     to);
}

Status MeshSpool::add(const Facet& facet) {
  if (attributes_.empty()) {
    is_soup_ = true;
    const Attribute layout[] = {{"POSITION", ComponentType::kFloat32, 3, false, {}},
                                {"NORMAL", ComponentType::kFloat32, 3, false, {}}};
    if (Status status = begin(layout, 0); !status.ok()) return status;
  }
  if (point_count_ + 3 > kMostPoints) return unsupported("more corners than 32 bits can count");
  if (!has_direction(facet.normal)) {
    if (zero_count_ < point_count_)
      if (Status status = add_zero_facet(facet); !status.ok()) return status;
    zero_count_ += 3;
  } else if (zero_count_ == point_count_ && point_count_ > 0) {
    if (Status status = add_earlier_zero_facets(); !status.ok()) return status;
  }
  std::array<std::array<float, 3>, 6> records;
  for (size_t i = 0; i < 3; ++i) {
    records[2 * i] = facet.corners[i];
    records[2 * i + 1] = facet.normal;
    include(facet.corners[i]);
  }
  if (options_.samples_edges) edges_.add(face_count_, facet.corners);
  const auto& [p, q, r] = facet.corners;
  has_proper_face_ = has_proper_face_ || (p != q && q != r && r != p);
  point_count_ += 3;
  ++face_count_;
  return points_.append(bytes_of(records));
}

// repair_values sums over the faces of a point that stands for all equal corners.
Status MeshSpool::add_zero_facet(const Facet& facet) {
  const Sum normal = area_vector(facet.corners);
  for (const Position& corner : facet.corners) {
    Sum& sum = soup_sums_.try_emplace({corner, facet.normal}, Sum{}).first->second;
    for (size_t axis = 0; axis < 3; ++axis) sum[axis] += normal[axis];
  }
  return soup_sums_.size() > options_.most_zero_normals ? too_many_zero_normals() : Status();
}

// The first facet with a normal came: now the sums of the facets before it are needed.
Status MeshSpool::add_earlier_zero_facets() {
  if (Status status = points_.flush(); !status.ok()) return status;
  std::vector<uint8_t> facet_bytes(3 * record_bytes_);
  for (uint64_t i = 0; i < face_count_; ++i) {
    if (Status status = pages_.read(points_.file(), points_.size(), i * facet_bytes.size(), facet_bytes);
        !status.ok())
      return status;
    Facet facet;
    std::memcpy(facet.normal.data(), facet_bytes.data() + offsets_[1], sizeof(facet.normal));
    for (size_t k = 0; k < 3; ++k)
      std::memcpy(facet.corners[k].data(), facet_bytes.data() + k * record_bytes_, sizeof(Position));
    if (Status status = add_zero_facet(facet); !status.ok()) return status;
  }
  return {};
}

void MeshSpool::end_solid(const std::string& name, uint64_t) {
  ++solids_;
  name_ = solids_ == 1 ? name : "";
  if (solids_ == 2) losses_.say("solids share a mesh");
}

Status MeshSpool::finish() {
  for (AppendFile* file : {&points_, &faces_})
    if (Status status = view_ ? Status() : file->flush(); !status.ok()) return status;
  if (face_count_ == 0) return unsupported("a point cloud: only triangles can be split");
  sums_.resize(zeros_.size());
  read_attributes_ = attributes_;
  read_bytes_ = record_bytes_;
  if (has_numbered_points_) read_attributes_.pop_back();
  if (has_no_normals()) {
    if (!skips_normals_of_soup()) say_no_normals(losses_);
    read_attributes_.erase(read_attributes_.begin() + static_cast<std::ptrdiff_t>(normal_));
    read_bytes_ -= attributes_[normal_].stride();
  } else if (normal_ != kNone && !is_soup_) {
    say_normals(changed_normals_, zeros_.size(), losses_);
  }
  block_ = {};
  return {};
}

Status MeshSpool::for_each_point(const VisitPoints& visit) const {
  const uint64_t at_once = kBlockBytes / (3 * record_bytes_) * 3;
  std::vector<uint8_t> records;
  size_t next_zero = 0;
  for (uint64_t first = 0; first < point_count_; first += at_once) {
    const auto count = static_cast<size_t>(std::min(at_once, point_count_ - first));
    records.resize(count * record_bytes_);
    if (view_)
      gather(first, count, records);
    else if (Status status = points_.read_flushed(first * record_bytes_, records); !status.ok())
      return status;
    for (; next_zero < zeros_.size() && zeros_[next_zero] < first + count; ++next_zero) {
      const std::array<float, 3> normal = normal_of_faces(sums_[next_zero]);
      std::memcpy(records.data() + (zeros_[next_zero] - first) * record_bytes_ + offsets_[normal_],
                  normal.data(), sizeof(normal));
    }
    if (read_bytes_ != record_bytes_) {  // without the normals
      const size_t head = offsets_[normal_], width = attributes_[normal_].stride();
      for (size_t i = 0; i < count; ++i) {
        uint8_t* const to = records.data() + i * read_bytes_;
        const uint8_t* const from = records.data() + i * record_bytes_;
        std::memmove(to, from, head);
        std::memmove(to + head, from + head + width, read_bytes_ - head);
      }
      records.resize(count * read_bytes_);
    }
    if (Status status = visit(first, records); !status.ok()) return status;
  }
  return {};
}

Position MeshSpool::position_of(const uint8_t* record) const {
  // Only NORMAL may be missing from the records. If it comes before POSITION, its bytes are missing there too.
  const bool shifts = read_bytes_ != record_bytes_ && normal_ < position_;
  Position position;
  std::memcpy(position.data(), record + offsets_[position_] - (shifts ? attributes_[normal_].stride() : 0),
              sizeof(position));
  return position;
}

Status MeshSpool::for_each_position(const std::function<void(std::span<const Position>)>& visit) const {
  std::vector<Position> positions;
  return for_each_point([&](uint64_t, std::span<const uint8_t> records) -> Status {
    positions.resize(records.size() / read_bytes_);
    for (size_t i = 0; i < positions.size(); ++i) positions[i] = position_of(records.data() + i * read_bytes_);
    visit(positions);
    return {};
  });
}

Status MeshSpool::read_faces(uint64_t first, std::span<Face> faces) const {
  uint8_t* const to = reinterpret_cast<uint8_t*>(faces.data());
  if (!view_) return faces_.read_flushed(first * sizeof(Face), {to, faces.size_bytes()});
  const size_t begin = static_cast<size_t>(3 * first), count = 3 * faces.size();
  const ValuesView& indices = view_->indices;
  Status status = read_indices(indices, begin, view_->point_count, {faces.front().data(), count});
  if (!indices.bytes.empty())
    release_mapped({reinterpret_cast<const uint8_t*>(indices.at(begin)), count * indices.value_bytes()});
  return status;
}

Status MeshSpool::for_each_face(const std::function<Status(std::span<const Face>)>& visit) const {
  constexpr uint64_t kAtOnce = kBlockBytes / sizeof(Face);
  std::vector<Face> faces;
  for (uint64_t first = 0; first < face_count_; first += kAtOnce) {
    faces.resize(static_cast<size_t>(std::min(kAtOnce, face_count_ - first)));
    if (Status status = read_faces(first, faces); !status.ok()) return status;
    if (Status status = visit(faces); !status.ok()) return status;
  }
  return {};
}

uint64_t MeshSpool::repair_soup(std::span<uint8_t> records, const std::vector<uint8_t>& counts) const {
  if (!is_soup_ || read_bytes_ != record_bytes_) return 0;
  uint64_t changed = 0;
  Attribute normal{"NORMAL", ComponentType::kFloat32, 3, false, {}};
  normal.values.resize(sizeof(Position));
  std::vector<uint32_t> zeros;
  for (size_t i = 0; i < counts.size(); ++i) {
    uint8_t* const at = records.data() + i * record_bytes_ + offsets_[normal_];
    std::memcpy(normal.values.data(), at, sizeof(Position));
    zeros.clear();
    const uint64_t changes = normalize(normal, 0, zeros);
    if (counts[i] != 0) changed += changes;
    std::memcpy(at, normal.values.data(), sizeof(Position));
    if (zeros.empty()) continue;
    std::array<float, 3> value;
    std::memcpy(value.data(), at, sizeof(value));
    const auto found = soup_sums_.find({position_of(at - offsets_[normal_]), value});
    value = normal_of_faces(found == soup_sums_.end() ? Sum{} : found->second);
    std::memcpy(at, value.data(), sizeof(value));
  }
  return changed;
}

void MeshSpool::close_files() {
  points_.close();
  faces_.close();
}

}  // namespace psplit
