#include "gltf_ext/out_of_core/mesh_spool.h"

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <utility>

#include "gltf_ext/primitive/primitive_edit.h"
#include "mesh_files/repair_values.h"

namespace psplit {
namespace {

constexpr uint64_t kMostPoints = UINT32_MAX - 1;
constexpr size_t kFacetsAtOnce = 4096;

// The mesh without its values, so that its JSON comes from the same code as always.
Document document_of_layout(MeshFile file, const std::string& name, std::vector<Attribute> attributes,
                            int64_t material, const PrecisePosition& origin) {
  Mesh mesh;
  mesh.attributes = std::move(attributes);
  if (file.objects.empty()) file.objects.push_back({name, {}});
  file.objects[0].origin = origin;
  file.objects[0].parts.push_back({std::move(mesh), material});
  Document document = document_of_objects(std::move(file));
  document.buffers.clear();
  document.json()["buffers"] = document.json()["bufferViews"] = Json::array();
  return document;
}

// The bytes of the file become a buffer, whose values the accessor describes.
Status place(Document& document, AppendFile& file, Json& accessor, const ValuesView& values, int target) {
  Expected<MappedFile> mapped = file.map();
  if (!mapped) return mapped.status();
  accessor.erase("bufferView");
  accessor["componentType"] = static_cast<int>(values.component_type);
  accessor["count"] = values.count;
  place_values(document, accessor, values, target, append_buffer(document, buffer_of(*mapped)), 0);
  return {};
}

}  // namespace

Status MeshSpool::begin(std::span<const Attribute> layout, size_t, bool are_precise) {
  are_precise_ = are_precise || options_.origin.by == OriginChoice::By::kGiven;
  for (const Attribute& attribute : layout) {
    if (attribute.semantic == "POSITION") position_ = columns_.size();
    if (attribute.semantic == "NORMAL") normal_ = columns_.size();
    Column& column = columns_.emplace_back(Column{attribute});
    column.attribute.values.clear();
    column.stride = (attribute.stride() + 3) / 4 * 4;
    Expected<AppendFile> file = AppendFile::create(options_.folder);
    if (!file) return file.status();
    column.file = std::move(*file);
  }
  Expected<AppendFile> faces = AppendFile::create(options_.folder);
  if (!faces) return faces.status();
  faces_ = std::move(*faces);
  return {};
}

Status MeshSpool::append_precise(const Attribute& floats, std::span<const PrecisePosition> positions) {
  std::vector<PrecisePosition> widened;
  for (size_t i = 0; positions.empty() && i < floats.values.size() / sizeof(Position); ++i)
    widened.push_back(precise(position_at(floats, static_cast<uint32_t>(i))));
  if (positions.empty()) positions = widened;
  for (const PrecisePosition& position : positions) {
    if (!is_finite(position)) return invalid_input("a position is not finite");
    spread_.add(position);
  }
  return columns_[position_].file.append(bytes_of(positions));
}

Status MeshSpool::settle_positions() {
  const std::span<const PositionSpread> spread(&spread_, 1);
  const std::vector<PrecisePosition> origins = choose_origins(spread, options_.origin);
  origin_ = origins[0];
  Expected<AppendFile> file = AppendFile::create(options_.folder);
  if (!file) return file.status();
  Column& column = columns_[position_];
  constexpr uint64_t kAtOnce = 65536;
  std::vector<PrecisePosition> from;
  std::vector<Position> to;
  double left = 0;
  for (uint64_t first = 0; first < point_count_; first += kAtOnce) {
    from.resize(static_cast<size_t>(std::min(kAtOnce, point_count_ - first)));
    to.resize(from.size());
    Status status = column.file.read(first * sizeof(from[0]),
                                     {reinterpret_cast<uint8_t*>(from.data()), from.size() * sizeof(from[0])});
    if (!status.ok()) return status;
    for (size_t i = 0; i < from.size(); ++i) {
      to[i] = relative_to(origin_, from[i]);
      left = std::max(left, lost_by(origin_, from[i]));
    }
    if (status = measure_positions(to); !status.ok()) return status;
    if (status = file->append(bytes_of(to)); !status.ok()) return status;
  }
  if (Status status = file->flush(); !status.ok()) return status;
  column.file = std::move(*file);
  column.pages = PagedFile();
  are_precise_ = false;
  say_origins(spread, origins, left, options_.origin, losses_);
  return {};
}

// What add_faces and add_facet do at once for floats.
Status MeshSpool::add_late_zero_normals() {
  if (normal_ == kNone || zero_count_ == 0 || has_no_normals()) return {};
  if (is_soup_) return add_zero_facets(false);
  sums_.resize(zeros_.size());
  constexpr uint64_t kAtOnce = 65536;
  std::vector<std::array<uint32_t, 3>> faces;
  for (uint64_t first = 0; first < face_count_; first += kAtOnce) {
    faces.resize(static_cast<size_t>(std::min(kAtOnce, face_count_ - first)));
    Status status = faces_.read(first * sizeof(faces[0]),
                                {reinterpret_cast<uint8_t*>(faces.data()), faces.size() * sizeof(faces[0])});
    for (size_t i = 0; status.ok() && i < faces.size(); ++i) status = add_to_zero_normals(faces[i]);
    if (!status.ok()) return status;
  }
  return {};
}

Status MeshSpool::measure_positions(std::span<const Position> positions) {
  for (const Position& position : positions) {
    if (!is_finite(position)) return invalid_input("a position is not finite");
    for (size_t axis = 0; axis < position.size(); ++axis) {
      low_[axis] = std::min<double>(low_[axis], position[axis]);
      high_[axis] = std::max<double>(high_[axis], position[axis]);
    }
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
  if (is_soup_) return {};
  const bool only_zeros_before = zero_count_ == point_count_;
  zero_count_ += zeros.size();
  if (only_zeros_before && zeros.size() == count) return {};  // it is enough to count them
  if (zero_count_ > options_.most_zero_normals) return too_many_zero_normals();
  if (only_zeros_before)
    for (uint32_t point = 0; point < point_count_; ++point) zeros_.push_back(point);
  zeros_.insert(zeros_.end(), zeros.begin(), zeros.end());
  return {};
}

Status MeshSpool::add_points(std::span<const Attribute> block, size_t count,
                             std::span<const PrecisePosition> positions) {
  if (point_count_ + count > kMostPoints) return unsupported("more points than 32 bits can count");
  std::vector<uint8_t> padded;
  for (size_t i = 0; i < columns_.size(); ++i) {
    if (i == position_ && are_precise_) {
      if (Status status = append_precise(block[i], positions); !status.ok()) return status;
      continue;
    }
    Attribute attribute = block[i];
    repair_floats(attribute, losses_);
    if (i == normal_)
      if (Status status = repair_block_normals(attribute, count); !status.ok()) return status;
    if (i == position_)
      if (Status status =
              measure_positions({reinterpret_cast<const Position*>(attribute.values.data()), count});
          !status.ok())
        return status;
    const size_t width = attribute.stride(), stride = columns_[i].stride;
    std::span<const uint8_t> bytes = bytes_of(attribute.values);
    if (width != stride) {
      padded.assign(count * stride, 0);
      for (size_t k = 0; k < count; ++k)
        std::memcpy(padded.data() + k * stride, bytes.data() + k * width, width);
      bytes = padded;
    }
    if (Status status = columns_[i].file.append(bytes); !status.ok()) return status;
  }
  point_count_ += count;
  return {};
}

Status MeshSpool::add_faces(std::span<const std::array<uint32_t, 3>> faces) {
  face_count_ += faces.size();
  if (!zeros_.empty() && !are_precise_) {
    sums_.resize(zeros_.size());
    for (const auto& face : faces)
      if (Status status = add_to_zero_normals(face); !status.ok()) return status;
  }
  return faces_.append(bytes_of(faces));
}

Status MeshSpool::add_to_zero_normals(const std::array<uint32_t, 3>& face) {
  std::array<size_t, 3> slots;
  for (size_t i = 0; i < 3; ++i) {
    const auto found = std::ranges::lower_bound(zeros_, face[i]);
    slots[i] = found != zeros_.end() && *found == face[i] ? static_cast<size_t>(found - zeros_.begin()) : kNone;
  }
  if (slots[0] == kNone && slots[1] == kNone && slots[2] == kNone) return {};
  std::array<Position, 3> corners;
  for (size_t i = 0; i < 3; ++i) {
    const Expected<Position> corner = float_position(face[i]);
    if (!corner) return corner.status();
    corners[i] = *corner;
  }
  const Sum normal = area_vector(corners);
  for (const size_t slot : slots)
    if (slot != kNone)
      for (size_t axis = 0; axis < 3; ++axis) sums_[slot][axis] += normal[axis];
  return {};
}

// A value of a column whose values have no padding.
template <typename T>
Status MeshSpool::read_point(size_t number, uint32_t point, T& value) {
  Column& column = columns_[number];
  if (Status status = column.file.flush(); !status.ok()) return status;
  return column.pages.read(column.file.file(), column.file.size(), uint64_t{point} * sizeof(value),
                           {reinterpret_cast<uint8_t*>(value.data()), sizeof(value)});
}

Expected<Position> MeshSpool::float_position(uint32_t point) {
  Position position;
  if (Status status = read_point(position_, point, position); !status.ok()) return status;
  return position;
}

Expected<PrecisePosition> MeshSpool::position(uint32_t point) {
  if (!are_precise_) {
    const Expected<Position> position = float_position(point);
    return position ? Expected(precise(*position)) : position.status();
  }
  PrecisePosition position;
  if (Status status = read_point(position_, point, position); !status.ok()) return status;
  return position;
}

template <typename AnyFacet>
Status MeshSpool::add_facet(const AnyFacet& facet) {
  constexpr bool kIsPrecise = std::is_same_v<AnyFacet, PreciseFacet>;
  if (!is_soup_) {
    is_soup_ = true;
    facets_ = {{"POSITION", ComponentType::kFloat32, 3, false, {}},
               {"NORMAL", ComponentType::kFloat32, 3, false, {}}};
    // Corners are one point only if their normals are equal before they are repaired.
    if (options_.numbers_points) facets_.push_back({kPointNumber, ComponentType::kUint32, 3, false, {}});
    if (Status status = begin(facets_, 0, kIsPrecise); !status.ok()) return status;
  }
  if (3 * (face_count_ + 1) > kMostPoints) return unsupported("more corners than 32 bits can count");
  const bool is_first_with_normal = has_direction(facet.normal) && zero_count_ == 3 * face_count_;
  if (is_first_with_normal && face_count_ > 0 && !are_precise_) {
    if (Status status = flush_facets(); !status.ok()) return status;
    if (Status status = add_zero_facets(true); !status.ok()) return status;
  }
  if (!has_direction(facet.normal)) {
    if constexpr (!kIsPrecise)
      if (zero_count_ < 3 * face_count_ && !are_precise_)
        if (Status status = add_zero_facet(facet); !status.ok()) return status;
    zero_count_ += 3;
  }
  for (const auto& corner : facet.corners) {
    if constexpr (kIsPrecise) facet_positions_.push_back(corner);
    const Position position = relative_to({}, PrecisePosition{corner[0], corner[1], corner[2]});
    for (Attribute& attribute : facets_) {
      const auto value = std::as_bytes(std::span(attribute.semantic == "POSITION" ? position : facet.normal));
      attribute.values.insert(attribute.values.end(), value.begin(), value.end());
    }
  }
  ++face_count_;
  return face_count_ % kFacetsAtOnce == 0 ? flush_facets() : Status();
}

Status MeshSpool::flush_facets() {
  if (facets_.empty() || facets_[0].values.empty()) return {};
  Status status = add_points(facets_, facets_[0].values.size() / sizeof(Position), facet_positions_);
  facet_positions_.clear();
  for (Attribute& attribute : facets_) attribute.values.clear();
  return status;
}

// repair_values sums over the faces of a point that stands for all equal corners.
Status MeshSpool::add_zero_facet(const Facet& facet) {
  const Sum normal = area_vector(facet.corners);
  for (const Position& corner : facet.corners) {
    Sum& sum = soup_sums_.try_emplace({corner, {}}, Sum{}).first->second;
    for (size_t axis = 0; axis < 3; ++axis) sum[axis] += normal[axis];
  }
  return soup_sums_.size() > options_.most_zero_normals ? too_many_zero_normals() : Status();
}

// Some facets have a normal, so facets without one need the sums, too. The files have zeros as their normals.
Status MeshSpool::add_zero_facets(bool are_all_zero) {
  for (uint32_t point = 0; point < point_count_; point += 3) {
    Facet facet{};
    if (!are_all_zero)
      if (Status status = read_point(normal_, point, facet.normal); !status.ok()) return status;
    if (has_direction(facet.normal)) continue;
    for (uint32_t i = 0; i < 3; ++i)
      if (Status status = read_point(position_, point + i, facet.corners[i]); !status.ok()) return status;
    if (Status status = add_zero_facet(facet); !status.ok()) return status;
  }
  return {};
}

void MeshSpool::end_solid(const std::string& name, uint64_t) {
  ++solids_;
  name_ = solids_ == 1 ? name : "";
  if (solids_ == 2) losses_.say("solids share a mesh");
}

// Those without a direction are zeros in the file.
Status MeshSpool::replace_zero_normals() {
  constexpr uint64_t kAtOnce = 65536;
  AppendFile& file = columns_[normal_].file;
  std::vector<Position> normals, positions;
  const auto bytes = [](std::vector<Position>& values) {
    return std::span(reinterpret_cast<uint8_t*>(values.data()), values.size() * sizeof(Position));
  };
  size_t next_sum = 0;
  for (uint64_t first = 0; first < point_count_; first += kAtOnce) {
    normals.resize(static_cast<size_t>(std::min(kAtOnce, point_count_ - first)));
    positions.resize(normals.size());
    const uint64_t at = first * sizeof(Position);
    Status status = file.read(at, bytes(normals));
    if (status.ok()) status = columns_[position_].file.read(at, bytes(positions));
    if (!status.ok()) return status;
    for (size_t i = 0; i < normals.size(); ++i) {
      if (has_direction(normals[i])) continue;
      normals[i] = normal_of_faces(is_soup_ ? soup_sums_.at({positions[i], {}}) : sums_[next_sum++]);
    }
    if (status = file.rewrite(at, bytes(normals)); !status.ok()) return status;
  }
  return {};
}

Expected<Document> MeshSpool::finish(MeshFile file, int64_t material) {
  if (Status status = flush_facets(); !status.ok()) return status;
  if (face_count_ == 0) return unsupported("has no triangles");
  if (face_count_ > UINT32_MAX / 3) return unsupported("more faces than a glTF accessor can count");
  if (are_precise_) {
    if (Status status = settle_positions(); !status.ok()) return status;
    if (Status status = add_late_zero_normals(); !status.ok()) return status;
  }
  if (has_no_normals()) {
    say_no_normals(losses_);
    columns_.erase(columns_.begin() + static_cast<std::ptrdiff_t>(normal_));
  } else if (normal_ != kNone) {
    say_normals(changed_normals_, is_soup_ ? soup_sums_.size() : zeros_.size(), losses_);
    sums_.resize(zeros_.size());
    if (zero_count_ > 0)
      if (Status status = replace_zero_normals(); !status.ok()) return status;
  }
  SpooledPoints spooled{.are_repeated = is_soup_, .numbers = {}};
  if (columns_.back().attribute.semantic == kPointNumber) {
    Expected<MappedFile> mapped = columns_.back().file.map();
    if (!mapped) return mapped.status();
    spooled.numbers = buffer_of(*mapped);
    columns_.pop_back();
  }
  std::vector<Attribute> layout;
  for (const Column& column : columns_) layout.push_back(column.attribute);
  Document document = document_of_layout(std::move(file), name_, std::move(layout), material, origin_);
  document.spooled = std::move(spooled);
  Json& accessors = document.json()["accessors"];
  for (size_t i = 0; i < columns_.size(); ++i) {
    const Attribute& a = columns_[i].attribute;
    const ValuesView values{
        a.component_type,  a.component_count, a.normalized, static_cast<uint32_t>(point_count_), {},
        columns_[i].stride};
    Status status = place(document, columns_[i].file, accessors[i], values, kArrayBuffer);
    if (!status.ok()) return status;
    if (a.semantic != "POSITION") continue;
    accessors[i]["min"] = bound_json(low_, a.component_type);
    accessors[i]["max"] = bound_json(high_, a.component_type);
  }
  if (is_soup_) {  // its points are in the order of the corners
    accessors.erase(accessors.size() - 1);
    primitive_json(document, {0, 0}).erase("indices");
    return document;
  }
  const ValuesView indices{ComponentType::kUint32, 1, false, static_cast<uint32_t>(3 * face_count_), {}, 0};
  Status status = place(document, faces_, accessors.back(), indices, kElementArrayBuffer);
  if (!status.ok()) return status;
  return document;
}

}  // namespace psplit
