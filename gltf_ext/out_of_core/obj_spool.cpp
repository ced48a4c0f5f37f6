#include "gltf_ext/out_of_core/obj_spool.h"

#include <cstring>
#include <optional>

namespace psplit {
namespace {

constexpr uint32_t kNoIndex = UINT32_MAX;

}  // namespace

Expected<ObjSpool> ObjSpool::create(const std::filesystem::path& folder) {
  ObjSpool spool;
  for (Column& column : spool.columns_) {
    Expected<AppendFile> file = AppendFile::create(folder);
    if (!file) return file.status();
    column.file = std::move(*file);
  }
  spool.column(ObjValues::kTexcoord).components = 2;
  spool.column(ObjValues::kPosition).component_bytes = sizeof(double);
  Expected<AppendFile> faces = AppendFile::create(folder);
  if (!faces) return faces.status();
  spool.faces_ = std::move(*faces);
  return spool;
}

Status ObjSpool::add_position(const PrecisePosition& position) {
  ++column(ObjValues::kPosition).count;
  return column(ObjValues::kPosition).file.append(bytes_of(position));
}

Status ObjSpool::add_value(ObjValues kind, std::span<const float> value) {
  ++column(kind).count;
  return column(kind).file.append(bytes_of(value));
}

Status ObjSpool::add_face(std::span<const ObjCorner> corners) {
  const std::array<uint32_t, 1> count = {static_cast<uint32_t>(corners.size())};
  ++face_count_;
  if (corners.size() > 2) triangle_count_ += corners.size() - 2;
  Status status = faces_.append(bytes_of(count));
  return status.ok() ? faces_.append(bytes_of(corners)) : std::move(status);
}

bool ObjSpool::has_colors() const {
  return column(ObjValues::kColor).count > 0 &&
         column(ObjValues::kColor).count == column(ObjValues::kPosition).count;
}

ExpectedSizes ObjSpool::sizes() const {
  ExpectedSizes sizes;
  sizes.faces = triangle_count_;
  for (const ObjValues kind :
       {ObjValues::kPosition, ObjValues::kColor, ObjValues::kTexcoord, ObjValues::kNormal}) {
    const Column& values = column(kind);
    sizes.points = std::max(sizes.points, values.count);
    if (values.count > 0) sizes.record_bytes += values.components * sizeof(float);
  }
  return sizes;
}

// Makes points of corners, block by block.
class ObjSpool::Writer {
 public:
  Writer(ObjSpool& spool, MeshSpool& mesh, Losses& losses, bool keeps_duplicates)
      : spool_(spool),
        mesh_(mesh),
        losses_(losses),
        keeps_duplicates_(keeps_duplicates),
        polygons_(losses),
        recent_(kRecent) {}

  Status write() {
    for (Column& column : spool_.columns_)
      if (Status status = column.file.flush(); !status.ok()) return status;
    if (Status status = spool_.faces_.flush(); !status.ok()) return status;
    uint64_t at = 0;
    for (uint64_t face = 0; face < spool_.face_count_; ++face) {
      std::array<uint32_t, 1> count;
      if (Status status = read_faces(count, at); !status.ok()) return status;
      corners_.resize(count[0]);
      if (Status status = read_faces(corners_, at); !status.ok()) return status;
      if (Status status = add(); !status.ok()) return status;
    }
    polygons_.finish();
    say_missing(losses_, missing_texcoords_, missing_normals_);
    return flush();
  }

 private:
  static constexpr size_t kRecent = size_t{1} << 18, kBlock = 8192;
  struct Known {
    ObjCorner corner;
    uint32_t point = kNoIndex;
  };

  Status read_faces(auto& to, uint64_t& at) {
    const std::span<uint8_t> bytes(reinterpret_cast<uint8_t*>(to.data()), to.size() * sizeof(to[0]));
    Status status = face_pages_.read(spool_.faces_.file(), spool_.faces_.size(), at, bytes);
    at += bytes.size();
    return status;
  }

  // The attributes come in the order that they have in memory.
  Status begin(bool has_normals, bool has_texcoords) {
    const auto has = [&](ObjValues kind) {
      return kind == ObjValues::kPosition || (kind == ObjValues::kColor && spool_.has_colors()) ||
             (kind == ObjValues::kNormal && has_normals) || (kind == ObjValues::kTexcoord && has_texcoords);
    };
    const std::pair<ObjValues, const char*> kNames[] = {{ObjValues::kPosition, "POSITION"},
                                                        {ObjValues::kColor, "COLOR_0"},
                                                        {ObjValues::kNormal, "NORMAL"},
                                                        {ObjValues::kTexcoord, "TEXCOORD_0"}};
    for (const auto& [kind, name] : kNames) {
      if (!has(kind)) continue;
      kinds_.push_back(kind);
      const auto components = static_cast<uint8_t>(spool_.column(kind).components);
      block_.push_back({name, ComponentType::kFloat32, components, false, {}});
    }
    if (keeps_duplicates_) block_.push_back({MeshSpool::kPointNumber, ComponentType::kUint32, 3, false, {}});
    return mesh_.begin(block_, 0, true);
  }

  Status add() {
    if (corners_.size() < 3) {
      polygons_.add(std::vector<uint32_t>(corners_.size()), {}, faces_);  // a loss
      return {};
    }
    bool has_normals = true, has_texcoords = true;
    const auto check = [&](uint32_t index, ObjValues kind, uint64_t& missing) {
      const bool exists = index < spool_.column(kind).count;
      missing += index != kNoIndex && !exists ? 1 : 0;
      return exists;
    };
    for (const ObjCorner& corner : corners_) {
      has_texcoords = check(corner.texcoord, ObjValues::kTexcoord, missing_texcoords_) && has_texcoords;
      has_normals = check(corner.normal, ObjValues::kNormal, missing_normals_) && has_normals;
    }
    const std::pair has(has_normals, has_texcoords);
    if (!has_)
      if (Status status = begin(has_normals, has_texcoords); !status.ok()) return status;
    if (has_.value_or(has) != has)
      return unsupported(
          "OBJ: faces with and without texture coordinates or normals are not read part by part");
    has_ = has;
    points_.clear();
    positions_.clear();
    for (ObjCorner corner : corners_) {
      if (!has_normals) corner.normal = kNoIndex;
      if (!has_texcoords) corner.texcoord = kNoIndex;
      if (Status status = add_corner(corner); !status.ok()) return status;
      if (corners_.size() > 3)
        if (Status status = read(ObjValues::kPosition, corner, positions_.emplace_back()); !status.ok())
          return status;
    }
    polygons_.add(points_, positions_, faces_);
    return new_points_ >= kBlock || faces_.size() >= kBlock ? flush() : Status();
  }

  Status add_corner(const ObjCorner& corner) {
    Known& known =
        recent_[(corner.position * 0x9e3779b1u ^ corner.texcoord * 0x85ebca6bu ^ corner.normal * 0xc2b2ae35u) >>
                (32 - 18)];
    if (known.point == kNoIndex || !(known.corner == corner)) {
      if (point_count_ == kNoIndex - 1) return unsupported("more points than 32 bits can count");
      known = {corner, point_count_++};
      ++new_points_;
      if (Status status = read(ObjValues::kPosition, corner, block_positions_.emplace_back()); !status.ok())
        return status;
      for (size_t i = 1; i < kinds_.size(); ++i) {  // the first are positions
        std::array<float, 3> value;
        if (Status status = read(kinds_[i], corner, value); !status.ok()) return status;
        const auto* const bytes = reinterpret_cast<const std::byte*>(value.data());
        for (size_t k = 0; k < block_[i].stride(); ++k) block_[i].values.push_back(bytes[k]);
      }
      if (keeps_duplicates_) {
        const std::array<uint32_t, 3> number = {corner.position, corner.texcoord, corner.normal};
        const auto bytes = std::as_bytes(std::span(number));
        block_.back().values.insert(block_.back().values.end(), bytes.begin(), bytes.end());
      }
    }
    points_.push_back(known.point);
    return {};
  }

  Status read(ObjValues kind, const ObjCorner& corner, auto& value) {
    Column& column = spool_.column(kind);
    const uint64_t index = kind == ObjValues::kNormal     ? corner.normal
                           : kind == ObjValues::kTexcoord ? corner.texcoord
                                                          : corner.position;
    const size_t width = column.value_bytes();
    return column.pages.read(column.file.file(), column.file.size(), index * width,
                             {reinterpret_cast<uint8_t*>(value.data()), width});
  }

  Status flush() {
    if (new_points_ > 0)
      if (Status status = mesh_.add_points(block_, new_points_, block_positions_); !status.ok()) return status;
    block_positions_.clear();
    for (Attribute& attribute : block_) attribute.values.clear();
    new_points_ = 0;
    Status status = faces_.empty() ? Status() : mesh_.add_faces(faces_);
    faces_.clear();
    return status;
  }

  ObjSpool& spool_;
  MeshSpool& mesh_;
  Losses& losses_;
  const bool keeps_duplicates_;
  PolygonReader polygons_;
  PagedFile face_pages_;
  std::vector<Known> recent_;
  std::optional<std::pair<bool, bool>> has_;  // normals and texture coordinates
  std::vector<ObjValues> kinds_;              // of the attributes of block_
  std::vector<Attribute> block_;
  std::vector<PrecisePosition> block_positions_;
  size_t new_points_ = 0;
  uint32_t point_count_ = 0;
  uint64_t missing_texcoords_ = 0, missing_normals_ = 0;
  Array<std::array<uint32_t, 3>> faces_;
  std::vector<ObjCorner> corners_;  // of one face
  std::vector<uint32_t> points_;
  std::vector<PrecisePosition> positions_;
};

Status ObjSpool::write_to(MeshSpool& mesh, Losses& losses, bool keeps_duplicates) {
  Status status = Writer(*this, mesh, losses, keeps_duplicates).write();
  for (Column& column : columns_) column.file.close();
  faces_.close();
  return status;
}

}  // namespace psplit
