#include "tools/gltf_psplit/shapes/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "tools/gltf_psplit/shapes/attributes.h"
#include "tools/gltf_psplit/shapes/charts.h"
#include "tools/gltf_psplit/shapes/fields.h"
#include "tools/gltf_psplit/shapes/sized_surface.h"

namespace psplit {
namespace {

constexpr uint64_t kMinFaces = 8, kMaxFaces = 1'000'000'000;

struct Part {
  FieldKind kind;
  double share;  // share of the faces
  Vec3 offset;
  double scale;
};
constexpr Part kScene[] = {
    {FieldKind::kTerrain, 0.42, {0, 0, 0}, 4},        {FieldKind::kGyroid, 0.26, {-1.8, 1.6, -1.2}, 1},
    {FieldKind::kBlob, 0.16, {1.7, 1.8, 1.4}, 1.2},   {FieldKind::kRing, 0.10, {1.6, 1.2, -1.9}, 0.8},
    {FieldKind::kBlob, 0.045, {-1.9, 1.1, 1.9}, 0.5}, {FieldKind::kPebbles, 0.015, {0, 1.4, 0.2}, 0.4}};

// A closed surface gets six charts, one for each side of a box; a face belongs to the side that its centre is
// nearest to in direction. An open surface gets 3 x 2 tiles.
class Projection : public Atlas {
 public:
  Projection(const Surface& surface, const Field& field)
      : closed_(field.closed), low_(field.high), high_(field.low) {
    for (const auto& [x, y, z] : surface.positions) {
      low_ = {std::min<double>(low_.x, x), std::min<double>(low_.y, y), std::min<double>(low_.z, z)};
      high_ = {std::max<double>(high_.x, x), std::max<double>(high_.y, y), std::max<double>(high_.z, z)};
    }
  }

  uint8_t chart(Vec3 p) const override {
    const Vec3 d = p - (low_ + high_) * 0.5;
    if (!closed_) {
      const double third = (high_.x - low_.x) / 6;
      const uint8_t column = d.x < -third ? 0 : d.x < third ? 1 : 2;
      return static_cast<uint8_t>(column + (d.z < 0 ? 0 : 3));
    }
    const double x = std::fabs(d.x), y = std::fabs(d.y), z = std::fabs(d.z);
    if (x >= y && x >= z) return d.x < 0 ? 0 : 1;
    if (y >= z) return d.y < 0 ? 2 : 3;
    return d.z < 0 ? 4 : 5;
  }

  // Each chart is one side of the box, shrunk a little, in one cell of a 3 x 2 atlas.
  std::array<float, 2> texcoord(uint8_t chart_index, const std::array<float, 3>& p) const override {
    const auto part = [](double value, double from, double to) {
      return 0.02 + 0.96 * (value - from) / (to - from);
    };
    const double x = part(p[0], low_.x, high_.x);
    const double y = part(p[1], low_.y, high_.y);
    const double z = part(p[2], low_.z, high_.z);
    const int side = closed_ ? chart_index / 2 : 1;
    const double u = side == 0 ? z : x;
    const double v = side == 1 ? z : y;
    return {static_cast<float>((chart_index % 3 + u) / 3), static_cast<float>((chart_index / 3 + v) / 2)};
  }

 private:
  bool closed_;
  Vec3 low_, high_;  // bounds of the surface, which may extend a little beyond the field's box
};

std::vector<std::array<float, 3>> normals_of(std::span<const std::array<float, 3>> positions,
                                             const Field& field, double cell, const ThreadPool& pool) {
  constexpr size_t kGrain = 1 << 14;
  std::vector<std::array<float, 3>> normals(positions.size());
  pool.for_ranges(positions.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) normals[v] = normal_at(field, positions[v], 0.5 * cell);
  });
  return normals;
}

Expected<Mesh> make_mesh(const Part& part, uint64_t seed, uint64_t faces, const ShapeOptions& options,
                         const ThreadPool& pool) {
  const std::unique_ptr<Field> field = make_field(part.kind, seed);
  Expected<SizedSurface> extracted = extract_about(*field, faces, seed, pool);
  if (!extracted) return extracted.status();
  Surface& surface = extracted->surface;
  ChartedPoints points;
  if (options.texcoords) points = unfold(surface, Projection(surface, *field));

  Mesh mesh;
  const size_t vertex_count = surface.positions.size();
  const size_t point_count = options.texcoords ? points.vertex.size() : vertex_count;
  mesh.point_count = static_cast<uint32_t>(point_count);
  mesh.faces = std::move(surface.faces);
  const auto vertex_of = [&](size_t point) { return options.texcoords ? points.vertex[point] : point; };

  if (options.normals) {
    const auto normals = normals_of(surface.positions, *field, extracted->cell, pool);
    Attribute normal = make_attribute("NORMAL", 3, point_count);
    for (size_t p = 0; p < point_count; ++p) store(normal, p, normals[vertex_of(p)]);
    mesh.attributes.push_back(std::move(normal));
  }
  Attribute position = make_attribute("POSITION", 3, point_count);
  for (size_t p = 0; p < point_count; ++p) {
    const std::array<float, 3>& local = surface.positions[vertex_of(p)];
    const Vec3 world = Vec3{local[0], local[1], local[2]} * part.scale + part.offset;
    store(position, p,
          std::array{static_cast<float>(world.x), static_cast<float>(world.y), static_cast<float>(world.z)});
  }
  mesh.attributes.insert(mesh.attributes.begin(), std::move(position));
  if (options.texcoords) {
    Attribute texcoord = make_attribute("TEXCOORD_0", 2, point_count);
    for (size_t p = 0; p < point_count; ++p) store(texcoord, p, points.texcoords[p]);
    mesh.attributes.push_back(std::move(texcoord));
  }
  return mesh;
}

// Not for kScene.
FieldKind field_kind(Shape shape) {
  return shape == Shape::kTerrain ? FieldKind::kTerrain
         : shape == Shape::kBlob  ? FieldKind::kBlob
                                  : FieldKind::kGyroid;
}

}  // namespace

Status check_face_count(uint64_t faces) {
  if (faces >= kMinFaces && faces <= kMaxFaces) return {};
  return wrong_usage("the number of faces must be from 8 to 1,000,000,000");
}

Expected<std::vector<Mesh>> generate_shape(const ShapeOptions& options, const ThreadPool& pool) {
  if (Status status = check_face_count(options.faces); !status.ok()) return status;
  const Part single = {field_kind(options.shape), 1, {}, 1};
  const std::span<const Part> parts =
      options.shape == Shape::kScene ? std::span<const Part>(kScene) : std::span(&single, 1);
  std::vector<Mesh> meshes;
  for (const Part& part : parts) {
    const auto faces = static_cast<uint64_t>(std::max(8.0, static_cast<double>(options.faces) * part.share));
    Expected<Mesh> mesh = make_mesh(part, options.seed + meshes.size(), faces, options, pool);
    if (!mesh) return mesh.status();
    meshes.push_back(std::move(*mesh));
  }
  return meshes;
}

ShapeStream::ShapeStream(ShapeStream&&) noexcept = default;
ShapeStream::~ShapeStream() = default;

Expected<ShapeStream> ShapeStream::open(const ShapeOptions& options, const ThreadPool& pool) {
  if (Status status = check_face_count(options.faces); !status.ok()) return status;
  if (options.shape == Shape::kScene) return wrong_usage("a scene has several meshes");
  if (options.texcoords) return wrong_usage("charts of texture coordinates need the whole mesh in memory");
  ShapeStream stream;
  stream.options_ = options;
  stream.field_ = make_field(field_kind(options.shape), options.seed);
  uint64_t counted_points = 0, counted_faces = 0;
  const auto count = [&](double cell) -> Expected<uint64_t> {
    counted_points = counted_faces = 0;
    const auto add = [&](Surface&& slab) -> Status {
      counted_points += slab.positions.size();
      counted_faces += slab.faces.size();
      return {};
    };
    if (Status status = stream_surface(*stream.field_, cell, options.seed, pool, add); !status.ok())
      return status;
    stream.cell_ = cell;
    return counted_faces;
  };
  const Expected<double> cell = find_cell(options.faces, count);
  if (!cell) return cell.status();
  if (stream.cell_ != *cell)
    if (const Expected<uint64_t> again = count(*cell); !again) return again.status();
  stream.point_count_ = counted_points;
  stream.face_count_ = counted_faces;
  return stream;
}

Status ShapeStream::read(const ThreadPool& pool, const std::function<Status(ShapePiece&&)>& take) const {
  return stream_surface(*field_, cell_, options_.seed, pool, [&](Surface&& slab) {
    ShapePiece piece{std::move(slab.positions), {}, std::move(slab.faces)};
    if (options_.normals) piece.normals = normals_of(piece.positions, *field_, cell_, pool);
    return take(std::move(piece));
  });
}

}  // namespace psplit
