#include "tools/gltf_psplit/shapes/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "tools/gltf_psplit/shapes/fields.h"
#include "tools/gltf_psplit/shapes/isosurface.h"

namespace psplit {
namespace {

constexpr uint64_t kMinFaces = 8, kMaxFaces = 1'000'000'000;
constexpr double kCloseEnough = 0.019;

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

// Keeps the first 14 bits. The last bits of std::pow differ between machines, and the whole mesh depends on the
// cell.
double drop_last_bits(double value) {
  int exponent = 0;
  const double mantissa = std::frexp(value, &exponent);
  return std::ldexp(std::round(mantissa * 16384), exponent - 14);
}

// The number of faces is proportional to the inverse square of the cell. Two coarse attempts determine the cell
// for the requested number. `count_faces` extracts the surface for a cell; the last cell may not be the result.
Expected<double> find_cell(uint64_t faces, const std::function<Expected<uint64_t>(double cell)>& count_faces) {
  constexpr double kCoarseFaces = 5000;
  const auto wanted = static_cast<double>(faces);
  const auto target = [&](int attempt) {
    const double part = attempt == 0 ? wanted / 64 : attempt == 1 ? wanted / 8 : wanted;
    return std::clamp(part, std::min(wanted, kCoarseFaces), wanted);
  };
  double cell = std::sqrt(40 / target(0));
  double best = 0, best_miss = HUGE_VAL;
  for (int attempt = 0; attempt < 16 && best_miss > kCloseEnough; ++attempt) {
    const Expected<uint64_t> count = count_faces(cell);
    if (!count) return count.status();
    if (*count == 0) {
      cell *= 0.7;
      continue;
    }
    const auto found = static_cast<double>(*count);
    const double miss = std::fabs(found - wanted) / wanted;
    if (miss < best_miss) {
      best = cell;
      best_miss = miss;
    }
    // For small meshes the count jumps as the cell shrinks. Shorter steps later on stop it from oscillating.
    cell = drop_last_bits(cell * std::pow(found / target(attempt + 1), attempt < 6 ? 0.5 : 0.3));
  }
  if (best == 0) return runtime_failure("the shape has no faces");
  return best;
}

// ---- Texture coordinates in several charts, with seams between them.

// The vertex of the surface and the texture coordinates of each point. Points 0 ... vertices - 1 are the
// vertices themselves. A vertex on a seam has another point at the end for each further chart.
struct ChartedPoints {
  std::vector<uint32_t> vertex;
  std::vector<std::array<float, 2>> texcoords;
};

constexpr uint8_t kNoChart = 255;

struct Projection {
  bool closed;
  Vec3 low, high;  // bounds of the surface, which may extend a little beyond the field's box

  Projection(const Surface& surface, const Field& field)
      : closed(field.closed), low(field.high), high(field.low) {
    for (const auto& [x, y, z] : surface.positions) {
      low = {std::min<double>(low.x, x), std::min<double>(low.y, y), std::min<double>(low.z, z)};
      high = {std::max<double>(high.x, x), std::max<double>(high.y, y), std::max<double>(high.z, z)};
    }
  }

  uint8_t chart(Vec3 p) const {
    const Vec3 d = p - (low + high) * 0.5;
    if (!closed) {
      const double third = (high.x - low.x) / 6;
      const uint8_t column = d.x < -third ? 0 : d.x < third ? 1 : 2;
      return static_cast<uint8_t>(column + (d.z < 0 ? 0 : 3));
    }
    const double x = std::fabs(d.x), y = std::fabs(d.y), z = std::fabs(d.z);
    if (x >= y && x >= z) return d.x < 0 ? 0 : 1;
    if (y >= z) return d.y < 0 ? 2 : 3;
    return d.z < 0 ? 4 : 5;
  }

  // Each chart is one side of the box, shrunk a little, in one cell of a 3 x 2 atlas.
  std::array<float, 2> texcoord(uint8_t chart_index, const std::array<float, 3>& p) const {
    const auto part = [](double value, double from, double to) {
      return 0.02 + 0.96 * (value - from) / (to - from);
    };
    const double x = part(p[0], low.x, high.x);
    const double y = part(p[1], low.y, high.y);
    const double z = part(p[2], low.z, high.z);
    const int side = closed ? chart_index / 2 : 1;
    const double u = side == 0 ? z : x;
    const double v = side == 1 ? z : y;
    return {static_cast<float>((chart_index % 3 + u) / 3), static_cast<float>((chart_index / 3 + v) / 2)};
  }
};

// A closed surface gets six charts, one for each side of a box; a face belongs to the side that its centre is
// nearest to in direction. An open surface gets 3 x 2 tiles. Rewrites the surface's faces from vertices to
// points.
ChartedPoints unfold(Surface& surface, const Field& field) {
  const Projection projection(surface, field);
  const auto vertex_count = static_cast<uint32_t>(surface.positions.size());
  std::vector<uint8_t> first_chart(vertex_count, kNoChart);
  std::unordered_map<uint64_t, uint32_t> seam_points;
  ChartedPoints points;
  points.vertex.resize(vertex_count);
  points.texcoords.resize(vertex_count);
  for (std::array<uint32_t, 3>& face : surface.faces) {
    Vec3 sum;
    for (const uint32_t vertex : face) {
      const std::array<float, 3>& p = surface.positions[vertex];
      sum = sum + Vec3{p[0], p[1], p[2]};
    }
    const uint8_t chart = projection.chart(sum * (1.0 / 3));
    for (uint32_t& corner : face) {
      const uint32_t vertex = corner;
      if (first_chart[vertex] == chart) continue;
      const std::array<float, 2> texcoord = projection.texcoord(chart, surface.positions[vertex]);
      if (first_chart[vertex] == kNoChart) {
        first_chart[vertex] = chart;
        points.vertex[vertex] = vertex;
        points.texcoords[vertex] = texcoord;
        continue;
      }
      const auto next = static_cast<uint32_t>(points.vertex.size());
      const auto [entry, is_new] = seam_points.try_emplace(uint64_t{vertex} * 8 + chart, next);
      if (is_new) {
        points.vertex.push_back(vertex);
        points.texcoords.push_back(texcoord);
      }
      corner = entry->second;
    }
  }
  return points;
}

// ---- Surfaces of a wanted size, and their meshes.

struct SizedSurface {
  double cell = 0;
  Surface surface;
};

Expected<SizedSurface> extract_about(const Field& field, uint64_t faces, uint64_t seed,
                                     const ThreadPool& pool) {
  SizedSurface result;
  const auto extract = [&](double cell) -> Expected<uint64_t> {
    result = {cell, {}};
    Surface& surface = result.surface;
    const auto append = [&](Surface&& slab) -> Status {
      surface.positions.insert(surface.positions.end(), slab.positions.begin(), slab.positions.end());
      surface.faces.insert(surface.faces.end(), slab.faces.begin(), slab.faces.end());
      return {};
    };
    if (Status status = stream_surface(field, cell, seed, pool, append); !status.ok()) return status;
    return surface.faces.size();
  };
  const Expected<double> cell = find_cell(faces, extract);
  if (!cell) return cell.status();
  if (result.cell != *cell)
    if (const Expected<uint64_t> again = extract(*cell); !again) return again.status();
  return result;
}

Attribute make_attribute(const char* semantic, uint8_t component_count, size_t point_count) {
  Attribute attribute;
  attribute.semantic = semantic;
  attribute.component_count = component_count;
  attribute.values.resize(point_count * attribute.stride());
  return attribute;
}

template <size_t kCount>
void store(Attribute& attribute, size_t point, const std::array<float, kCount>& value) {
  std::memcpy(attribute.values.data() + point * sizeof(value), value.data(), sizeof(value));
}

// The direction in which the field grows, from central differences over `step` on each side.
std::array<float, 3> normal_at(const Field& field, const std::array<float, 3>& position, double step) {
  const Vec3 p = {position[0], position[1], position[2]};
  constexpr double kEverywhere = 1e9;
  const auto along = [&](Vec3 axis) {
    return field.at(p + axis, kEverywhere) - field.at(p - axis, kEverywhere);
  };
  const Vec3 gradient = {along({step, 0, 0}), along({0, step, 0}), along({0, 0, step})};
  const double size = length(gradient);
  if (!(size > 0)) return {0, 1, 0};
  return {static_cast<float>(gradient.x / size), static_cast<float>(gradient.y / size),
          static_cast<float>(gradient.z / size)};
}

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
  if (options.texcoords) points = unfold(surface, *field);

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

Status check_face_count(uint64_t faces) {
  if (faces >= kMinFaces && faces <= kMaxFaces) return {};
  return wrong_usage("the number of faces must be from 8 to 1,000,000,000");
}

// Not for kScene.
FieldKind field_kind(Shape shape) {
  return shape == Shape::kTerrain ? FieldKind::kTerrain
         : shape == Shape::kBlob  ? FieldKind::kBlob
                                  : FieldKind::kGyroid;
}

}  // namespace

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
