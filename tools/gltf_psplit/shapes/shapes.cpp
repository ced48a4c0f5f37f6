#include "tools/gltf_psplit/shapes/shapes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <span>
#include <utility>

#include "tools/gltf_psplit/shapes/charts.h"
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
// for the requested number.
Surface extract_about(const Field& field, uint64_t faces, uint64_t seed, const ThreadPool& pool) {
  constexpr double kCoarseFaces = 5000;
  const auto wanted = static_cast<double>(faces);
  const auto target = [&](int attempt) {
    const double part = attempt == 0 ? wanted / 64 : attempt == 1 ? wanted / 8 : wanted;
    return std::clamp(part, std::min(wanted, kCoarseFaces), wanted);
  };
  double cell = std::sqrt(40 / target(0));
  Surface best;
  double best_miss = HUGE_VAL;
  for (int attempt = 0; attempt < 16 && best_miss > kCloseEnough; ++attempt) {
    Surface surface = extract_surface(field, cell, seed, pool);
    if (surface.faces.empty()) {
      cell *= 0.7;
      continue;
    }
    const auto found = static_cast<double>(surface.faces.size());
    const double miss = std::fabs(found - wanted) / wanted;
    if (miss < best_miss) {
      best = std::move(surface);
      best_miss = miss;
    }
    // For small meshes the count jumps as the cell shrinks. Shorter steps later on stop it from oscillating.
    cell = drop_last_bits(cell * std::pow(found / target(attempt + 1), attempt < 6 ? 0.5 : 0.3));
  }
  return best;
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

Mesh make_mesh(const Part& part, uint64_t seed, uint64_t faces, const ShapeOptions& options,
               const ThreadPool& pool) {
  constexpr size_t kGrain = 1 << 14;
  const std::unique_ptr<Field> field = make_field(part.kind, seed);
  Surface surface = extract_about(*field, faces, seed, pool);
  ChartedPoints points;
  if (options.texcoords) points = unfold(surface, *field);

  Mesh mesh;
  const size_t vertex_count = surface.positions.size();
  const size_t point_count = options.texcoords ? points.vertex.size() : vertex_count;
  mesh.point_count = static_cast<uint32_t>(point_count);
  mesh.faces = std::move(surface.faces);
  const auto vertex_of = [&](size_t point) { return options.texcoords ? points.vertex[point] : point; };

  if (options.normals) {
    std::vector<std::array<float, 3>> normals(vertex_count);
    const double step = 0.5 * surface.cell;
    pool.for_ranges(vertex_count, kGrain, [&](size_t begin, size_t end) {
      for (size_t v = begin; v < end; ++v) normals[v] = normal_at(*field, surface.positions[v], step);
    });
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

}  // namespace

Expected<std::vector<Mesh>> generate_shape(const ShapeOptions& options, const ThreadPool& pool) {
  if (options.faces < kMinFaces || options.faces > kMaxFaces)
    return Status(StatusCode::kUsage, "the number of faces must be from 8 to 1,000,000,000");
  const Part single = {options.shape == Shape::kTerrain ? FieldKind::kTerrain
                       : options.shape == Shape::kBlob  ? FieldKind::kBlob
                                                        : FieldKind::kGyroid,
                       1,
                       {},
                       1};
  const std::span<const Part> parts =
      options.shape == Shape::kScene ? std::span<const Part>(kScene) : std::span(&single, 1);
  std::vector<Mesh> meshes;
  for (const Part& part : parts) {
    const double faces = std::max(8.0, static_cast<double>(options.faces) * part.share);
    meshes.push_back(
        make_mesh(part, options.seed + meshes.size(), static_cast<uint64_t>(faces), options, pool));
  }
  return meshes;
}

}  // namespace psplit
