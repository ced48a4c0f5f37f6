// same_mesh [--lossless] INPUT DECODED: tells whether two files hold the same meshes, within the grids of
// `gltf-psplit encode` with its default bits. Exit codes: 0: they do; 7: they do not, with the reason on
// stdout; 3: a file cannot be read.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iostream>
#include <limits>
#include <map>
#include <string_view>

#include "encoder/coding/quantization.h"
#include "encoder/draco/draco_backend.h"
#include "encoder/encode_mesh.h"
#include "gltf_ext/mesh_files/read_asset.h"
#include "gltf_ext/primitive/read_primitives.h"
#include "tests/support/compare_meshes.h"

namespace psplit {
namespace {

// A primitive with its morph targets as further attributes, because they belong to the same points.
Expected<Mesh> read_with_morphs(const Document& document, PrimitiveId id, const ThreadPool& pool) {
  Expected<Mesh> mesh = read_primitive(document, id, draco_backend(), pool);
  if (!mesh) return mesh;
  Expected<std::vector<MorphAttribute>> morphs = read_morph_targets(document, id);
  if (!morphs) return morphs.status();
  for (MorphAttribute& morph : *morphs) {
    if (morph.data.count != mesh->point_count) return invalid_input("a morph target of another point count");
    mesh->attributes.push_back({"target " + std::to_string(morph.target) + " " + morph.semantic,
                                morph.data.component_type, morph.data.component_count, morph.data.normalized,
                                std::move(morph.data.values)});
  }
  return mesh;
}

// All primitives of a file, in order. A primitive without triangles is an empty mesh. A primitive in a storage
// that psplit does not change, such as meshoptimizer's compression, is a status.
Expected<std::vector<Expected<Mesh>>> read_meshes(const std::string& path, const ThreadPool& pool) {
  std::vector<Expected<Mesh>> meshes;
  const Expected<Asset> asset = read_asset(path, describe_draco_stream);
  if (!asset) return asset.status();
  const Document& document = asset->document;
  for (const PrimitiveId id : all_primitives(document)) {
    const Expected<PrimitiveKind> kind = primitive_kind(document, id);
    if (!kind) return kind.status();
    Expected<Mesh> mesh = kind->triangles ? read_with_morphs(document, id, pool) : Mesh{};
    if (!mesh && mesh.status().code() != StatusCode::kUnsupported) return mesh.status();
    meshes.push_back(std::move(mesh));
  }
  return meshes;
}

// Merges points that are equal in all attributes, as `encode` does, with independent code.
Mesh merge_duplicates(const Mesh& mesh) {
  Mesh merged;
  for (const Attribute& attribute : mesh.attributes) {
    merged.attributes.push_back(attribute);
    merged.attributes.back().values.clear();
  }
  std::map<std::string, uint32_t> known;
  std::vector<uint32_t> new_point(mesh.point_count);
  for (uint32_t point = 0; point < mesh.point_count; ++point) {
    std::string key;
    for (const Attribute& attribute : mesh.attributes)
      key.append(reinterpret_cast<const char*>(attribute.values.data()) + point * attribute.stride(),
                 attribute.stride());
    const auto [found, is_new] = known.emplace(std::move(key), merged.point_count);
    new_point[point] = found->second;
    if (!is_new) continue;
    ++merged.point_count;
    for (size_t i = 0; i < mesh.attributes.size(); ++i) {
      const Attribute& from = mesh.attributes[i];
      const auto begin = from.values.begin() + static_cast<ptrdiff_t>(point * from.stride());
      merged.attributes[i].values.insert(merged.attributes[i].values.end(), begin,
                                         begin + static_cast<ptrdiff_t>(from.stride()));
    }
  }
  for (const auto& [a, b, c] : mesh.faces) merged.faces.push_back({new_point[a], new_point[b], new_point[c]});
  return merged;
}

std::vector<float> floats_of(const Attribute& attribute) {
  std::vector<float> values(attribute.values.size() / sizeof(float));
  std::memcpy(values.data(), attribute.values.data(), values.size() * sizeof(float));
  return values;
}

bool has_unit_length(const float* v) {
  const double square = double{v[0]} * v[0] + double{v[1]} * v[1] + double{v[2]} * v[2];
  return std::fabs(std::sqrt(square) - 1.0) <= 1e-2;
}

// The grid must fit the values: a much wider grid would accept any difference.
bool fits_tightly(const AttributeCoding& grid, const Attribute& attribute) {
  const std::vector<float> values = floats_of(attribute);
  const size_t width = attribute.component_count;
  double extent = 0;
  for (size_t c = 0; c < width; ++c) {
    double low = std::numeric_limits<double>::max(), high = -low;
    for (size_t at = c; at < values.size(); at += width) {
      low = std::min(low, double{values[at]});
      high = std::max(high, double{values[at]});
    }
    extent = std::max(extent, high - low);
  }
  return extent == 0 || double{grid.range} <= extent * 1.001;
}

// The tolerances for the default options of `gltf-psplit encode`, with a grid for each primitive.
Expected<Tolerance> default_tolerance(const Attribute& attribute) {
  const std::string& name = attribute.semantic;
  if (attribute.component_type != ComponentType::kFloat32 || name.starts_with("target "))
    return exact_tolerance();
  if (name == "NORMAL" && attribute.component_count == 3) {
    const std::vector<float> values = floats_of(attribute);
    for (size_t at = 0; at < values.size(); at += 3)
      if (!has_unit_length(&values[at])) return exact_tolerance();
    return octahedral_tolerance(10);
  }
  const int bits = name == "POSITION" ? 14 : name.starts_with("COLOR_") ? 8 : 12;
  const std::vector<float> values = floats_of(attribute);
  // Values that no grid can hold are kept exactly.
  if (!std::ranges::all_of(values, [](float value) { return std::isfinite(value); })) return exact_tolerance();
  Expected<AttributeCoding> grid = fit_grid(attribute, bits);
  if (!grid) return exact_tolerance();
  // If glTF limits the values, the grid covers the whole allowed range. Weights may be rounded to the step
  // above or below, so that their sum stays one; this is up to half a step more than rounding to the nearest.
  const bool is_weights = name.starts_with("WEIGHTS_");
  if (is_weights || name.starts_with("COLOR_") || name == "TANGENT") {
    constexpr float kNoise = 1e-5f;
    const float low = name == "TANGENT" ? -1.0f : 0.0f;
    if (std::ranges::all_of(values, [&](float value) { return value >= low - kNoise && value <= 1 + kNoise; }))
      return grid_tolerance(is_weights ? bits - 1 : bits, std::vector<float>(attribute.component_count, low),
                            1 - low);
  }
  if (!fits_tightly(*grid, attribute)) return runtime_failure("the grid of " + name + " is too wide");
  return grid_tolerance(bits, grid->origin, grid->range);
}

// The mesh without points that no face uses.
Mesh drop_unused_points(const Mesh& mesh) {
  constexpr uint32_t kUnused = 0xffffffffu;
  std::vector<uint32_t> number(mesh.point_count, kUnused);
  Mesh kept;
  for (const auto& face : mesh.faces)
    for (const uint32_t point : face)
      if (number[point] == kUnused) number[point] = kept.point_count++;
  for (const Attribute& attribute : mesh.attributes) {
    kept.attributes.push_back(attribute);
    Array<std::byte>& values = kept.attributes.back().values;
    values.resize(kept.point_count * attribute.stride());
    for (uint32_t point = 0; point < mesh.point_count; ++point)
      if (number[point] != kUnused)
        std::memcpy(values.data() + number[point] * attribute.stride(),
                    attribute.values.data() + point * attribute.stride(), attribute.stride());
  }
  for (const auto& [a, b, c] : mesh.faces) kept.faces.push_back({number[a], number[b], number[c]});
  return kept;
}

// Gives each face points of its own and leaves out faces that repeat a point. So meshes that draw the same are
// equal, no matter which points their faces share.
Mesh drawn_faces(const Mesh& mesh) {
  Mesh soup;
  std::vector<uint32_t> source;
  for (const auto& [a, b, c] : mesh.faces) {
    if (a == b || b == c || c == a) continue;
    const auto first = static_cast<uint32_t>(source.size());
    source.insert(source.end(), {a, b, c});
    soup.faces.push_back({first, first + 1, first + 2});
  }
  soup.point_count = static_cast<uint32_t>(source.size());
  for (const Attribute& attribute : mesh.attributes) {
    soup.attributes.push_back(attribute);
    const size_t stride = attribute.stride();
    Array<std::byte>& values = soup.attributes.back().values;
    values.resize(source.size() * stride);
    for (size_t i = 0; i < source.size(); ++i)
      std::memcpy(values.data() + i * stride, attribute.values.data() + source[i] * stride, stride);
  }
  return soup;
}

// Empty if the primitives are equal. A primitive that psplit cannot read must be unchanged.
std::string difference(const Expected<Mesh>& input, const Expected<Mesh>& decoded, bool lossless) {
  if (!input || !decoded)
    return input.ok() == decoded.ok() ? "" : input.status().message() + decoded.status().message();
  const Mesh expected = merge_duplicates(*input);
  std::vector<Tolerance> tolerances;
  for (const Attribute& attribute : expected.attributes) {
    Expected<Tolerance> tolerance = lossless ? exact_tolerance() : default_tolerance(attribute);
    if (!tolerance) return tolerance.status().message();
    tolerances.push_back(std::move(*tolerance));
  }
  const std::string why = compare_meshes(expected, *decoded, tolerances);
  // By default, faces and points that draw nothing are dropped, and stock Draco adds a point when it splits a
  // vertex.
  if (!why.empty() && !lossless) {
    const std::string drawn = compare_meshes(drawn_faces(expected), drawn_faces(*decoded), tolerances);
    if (drawn.empty()) return drawn;
    // A primitive that would grow is unchanged, and its equal points are not merged.
    const std::vector<Tolerance> exact(input->attributes.size(), exact_tolerance());
    return compare_meshes(drawn_faces(*input), drawn_faces(*decoded), exact).empty() ? "" : drawn;
  }
  // Primitives that share attributes divide the points: each gets only the points that it uses.
  if (why.empty() || expected.point_count == decoded->point_count) return why;
  return compare_meshes(drop_unused_points(expected), drop_unused_points(*decoded), tolerances);
}

int run(std::span<const std::string_view> arguments) {
  const bool lossless = !arguments.empty() && arguments.front() == "--lossless";
  if (lossless) arguments = arguments.subspan(1);
  if (arguments.size() != 2) {
    std::cout << "usage: same_mesh [--lossless] INPUT DECODED\n";
    return static_cast<int>(StatusCode::kUsage);
  }
  const ThreadPool pool(1);
  std::array<std::vector<Expected<Mesh>>, 2> files;
  for (size_t i = 0; i < 2; ++i) {
    Expected<std::vector<Expected<Mesh>>> meshes = read_meshes(std::string(arguments[i]), pool);
    if (!meshes) {
      std::cout << arguments[i] << ": " << meshes.status().to_string() << '\n';
      return static_cast<int>(meshes.status().code());
    }
    files[i] = std::move(*meshes);
  }
  if (files[0].size() != files[1].size()) {
    std::cout << files[0].size() << " primitives became " << files[1].size() << '\n';
    return static_cast<int>(StatusCode::kDiffers);
  }
  for (size_t i = 0; i < files[0].size(); ++i) {
    const std::string why = difference(files[0][i], files[1][i], lossless);
    if (why.empty()) continue;
    std::cout << "primitive " << i << " in order: " << why << '\n';
    return static_cast<int>(StatusCode::kDiffers);
  }
  return 0;
}

}  // namespace
}  // namespace psplit

int main(int argc, char** argv) {
  const std::vector<std::string_view> arguments(argv + 1, argv + argc);
  return psplit::run(arguments);
}
