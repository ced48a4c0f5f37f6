// same_mesh [--lossless] INPUT DECODED: tells whether two files hold the same meshes, within the grids of
// `gltf-psplit encode` with its default bits and one grid for each mesh. The grids are fitted here, with no
// code of psplit, to the values that faces draw: no value may be farther than half a step from its input. Exit
// codes: 0: they do; 7: they do not, with the reason on stdout; 3: a file cannot be read.
//
// same_mesh --errors INPUT DECODED: prints for each quantized attribute of each primitive its name, the number
// of values, and their worst and mean error in half steps.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <iostream>
#include <map>
#include <numeric>
#include <string_view>
#include <tuple>

#include "encoder/encode_mesh.h"
#include "encoder/libdraco/draco_backend.h"
#include "gltf_ext/primitive/read_primitives.h"
#include "mesh_files/read_asset.h"
#include "psplit/encode.h"
#include "tests/support/compare_meshes.h"
#include "tests/support/procedural_meshes.h"

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
    Attribute& deltas = mesh->attributes.emplace_back(attribute_of(std::move(morph)));
    if (deltas.component_type != ComponentType::kFloat32) continue;
    // Encoding takes -0 for 0.
    std::vector<float> values = values_of<float>(deltas);
    for (float& value : values) value += 0.0f;
    std::memcpy(deltas.values.data(), values.data(), deltas.values.size());
  }
  return mesh;
}

struct Primitive {
  Expected<Mesh> mesh = Mesh();
  size_t mesh_number = 0;  // the lowest of the meshes that share a primitive
};

// Meshes that have a primitive in common have one grid, because it is stored once.
std::vector<size_t> joined_meshes(const Document& document) {
  std::vector<size_t> joined(document.json().value("meshes", Json::array()).size());
  std::iota(joined.begin(), joined.end(), size_t{0});
  std::map<std::string, size_t> mesh_of;
  for (const PrimitiveId id : all_primitives(document)) {
    Json primitive = document.json()["meshes"][id.mesh]["primitives"][id.primitive];
    primitive.erase("material");
    const size_t first = mesh_of.emplace(primitive.dump(), id.mesh).first->second;
    const auto [low, high] = std::minmax({joined[first], joined[id.mesh]});
    std::replace(joined.begin(), joined.end(), size_t{high}, size_t{low});
  }
  return joined;
}

// All primitives of a file, in order. A primitive without triangles is an empty mesh. A primitive in a storage
// that psplit does not change, such as meshoptimizer's compression, is a status.
Expected<std::vector<Primitive>> read_primitives_of(const std::string& path, const ThreadPool& pool) {
  std::vector<Primitive> primitives;
  const Expected<Asset> asset = read_asset(path, describe_draco_stream);
  if (!asset) return asset.status();
  const Document& document = asset->document;
  const std::vector<size_t> joined = joined_meshes(document);
  for (const PrimitiveId id : all_primitives(document)) {
    const PrimitiveRecord& primitive = document.records().primitive(id);
    if (!primitive.status.ok()) return primitive.status;
    Expected<Mesh> mesh = primitive.has_triangles() ? read_with_morphs(document, id, pool) : Mesh{};
    if (!mesh && mesh.status().code() != StatusCode::kUnsupported) return mesh.status();
    primitives.push_back({std::move(mesh), joined[id.mesh]});
  }
  return primitives;
}

// Merges points that are equal in all attributes, as `encode` does, with independent code.
Mesh merge_duplicates(const Mesh& mesh) {
  std::map<std::string, uint32_t> known;
  std::vector<uint32_t> new_point(mesh.point_count), kept;
  for (uint32_t point = 0; point < mesh.point_count; ++point) {
    std::string key;
    for (const Attribute& attribute : mesh.attributes)
      key.append(reinterpret_cast<const char*>(attribute.values.data()) + point * attribute.stride(),
                 attribute.stride());
    const auto [found, is_new] = known.emplace(std::move(key), static_cast<uint32_t>(kept.size()));
    new_point[point] = found->second;
    if (is_new) kept.push_back(point);
  }
  Mesh merged = take_points(mesh, kept);
  for (const auto& [a, b, c] : mesh.faces) merged.faces.push_back({new_point[a], new_point[b], new_point[c]});
  return merged;
}

bool has_unit_length(const float* v) {
  const double square = double{v[0]} * v[0] + double{v[1]} * v[1] + double{v[2]} * v[2];
  return std::fabs(std::sqrt(square) - 1.0) <= 1e-2;
}

// The mesh without points that no face uses.
Mesh drop_unused_points(const Mesh& mesh) {
  std::map<uint32_t, uint32_t> number;
  std::vector<uint32_t> used;
  for (const auto& face : mesh.faces)
    for (const uint32_t point : face)
      if (number.emplace(point, static_cast<uint32_t>(used.size())).second) used.push_back(point);
  Mesh kept = take_points(mesh, used);
  for (const auto& [a, b, c] : mesh.faces) kept.faces.push_back({number[a], number[b], number[c]});
  return kept;
}

// Gives each face points of its own and leaves out faces that repeat a point. So meshes that draw the same are
// equal, no matter which points their faces share.
Mesh drawn_faces(const Mesh& mesh) {
  Faces faces;
  std::vector<uint32_t> source;
  for (const auto& [a, b, c] : mesh.faces) {
    if (a == b || b == c || c == a) continue;
    const auto first = static_cast<uint32_t>(source.size());
    source.insert(source.end(), {a, b, c});
    faces.push_back({first, first + 1, first + 2});
  }
  Mesh soup = take_points(mesh, source);
  soup.faces = std::move(faces);
  return soup;
}

bool all_finite(const std::vector<float>& values) {
  return std::ranges::all_of(values, [](float value) { return std::isfinite(value); });
}

// The values of all primitives of a mesh that share a grid, from the least to the largest of each component.
struct Extent {
  std::vector<float> low, high;

  void add(const std::vector<float>& values, size_t width) {
    if (low.empty())
      low = high = std::vector<float>(values.begin(), values.begin() + static_cast<ptrdiff_t>(width));
    for (size_t i = 0; i < values.size(); ++i) {
      low[i % width] = std::min(low[i % width], values[i]);
      high[i % width] = std::max(high[i % width], values[i]);
    }
  }
  float largest() const {
    float largest = 0;
    for (size_t c = 0; c < low.size(); ++c) largest = std::max(largest, high[c] - low[c]);
    return largest;
  }
};

using GridName = std::tuple<size_t, std::string, size_t>;  // mesh, semantic, components
GridName grid_name(const Primitive& primitive, const Attribute& attribute) {
  return {primitive.mesh_number, attribute.semantic, attribute.component_count};
}

std::map<GridName, Extent> extents_of(const std::vector<Primitive>& primitives) {
  std::map<GridName, Extent> extents;
  for (const Primitive& primitive : primitives) {
    if (!primitive.mesh) continue;
    for (const Attribute& attribute : drawn_faces(merge_duplicates(*primitive.mesh)).attributes) {
      if (attribute.component_type != ComponentType::kFloat32) continue;
      const std::vector<float> values = values_of<float>(attribute);
      if (!values.empty() && all_finite(values))
        extents[grid_name(primitive, attribute)].add(values, attribute.component_count);
    }
  }
  return extents;
}

// glTF limits the values. Weights may be rounded to the step above or below, so that their sum stays one; this
// is up to half a step more than rounding to the nearest.
bool has_limits(const std::string& name) {
  return name.starts_with("WEIGHTS_") || name.starts_with("COLOR_") || name == "TANGENT";
}

// The tolerances for the default options of `gltf-psplit encode`.
Tolerance default_tolerance(const Attribute& attribute, const Extent& extent) {
  const std::string& name = attribute.semantic;
  if (attribute.component_type != ComponentType::kFloat32 || target_of(name)) return exact_tolerance();
  const std::vector<float> values = values_of<float>(attribute);
  if (name == "NORMAL" && attribute.component_count == 3) {
    for (size_t at = 0; at < values.size(); at += 3)
      if (!has_unit_length(&values[at])) return exact_tolerance();
    return octahedral_tolerance(10);
  }
  const float range = extent.largest();
  // Values that no grid can hold are kept exactly.
  if (extent.low.empty() || !all_finite(values) || !std::isfinite(range)) return exact_tolerance();
  const int bits = name == "POSITION" ? 14 : name.starts_with("COLOR_") ? 8 : 12;
  if (has_limits(name)) {
    constexpr float kNoise = 1e-5f;
    const float low = name == "TANGENT" ? -1.0f : 0.0f;
    const auto is_within = [&](float value) { return value >= low - kNoise && value <= 1 + kNoise; };
    const bool is_color = name.starts_with("COLOR_");
    if (std::ranges::all_of(extent.low, is_within) && std::ranges::all_of(extent.high, is_within) &&
        (!is_color || range > 0.999f))
      return grid_tolerance(name.starts_with("WEIGHTS_") ? bits - 1 : bits,
                            std::vector<float>(attribute.component_count, low), 1 - low);
  }
  return grid_tolerance(bits, extent.low, range);
}

std::vector<float> sorted_component(const Attribute& attribute, size_t component) {
  const std::vector<float> values = values_of<float>(attribute);
  std::vector<float> sorted;
  for (size_t at = component; at < values.size(); at += attribute.component_count) sorted.push_back(values[at]);
  std::ranges::sort(sorted);
  return sorted;
}

struct Errors {
  size_t count = 0;
  double worst = 0, sum = 0;  // in half steps
  double rounding = 0;        // of floats, in half steps
};

// Rounding to a grid keeps the order of values. So the sorted values of a component belong to each other,
// whatever the order of points is.
Errors errors_of(const Attribute& expected, const Attribute& actual, const Tolerance& grid) {
  Errors errors;
  const double half_step = 0.5 * double{grid.range} / (std::ldexp(1.0, grid.bits) - 1);
  for (size_t c = 0; c < expected.component_count; ++c) {
    // 8 floats of the range and one of the coordinate are rounded on the way.
    const double rounding = std::ldexp(8 * double{grid.range} + std::fabs(double{grid.origin[c]}), -24);
    if (half_step > 0) errors.rounding = std::max(errors.rounding, rounding / half_step);
    const std::vector<float> from = sorted_component(expected, c), to = sorted_component(actual, c);
    for (size_t i = 0; i < from.size(); ++i) {
      const double error = std::fabs(double{from[i]} - double{to[i]});
      const double halves = half_step > 0 ? error / half_step : error > rounding ? INFINITY : 0;
      errors.worst = std::max(errors.worst, halves);
      errors.sum += halves;
      ++errors.count;
    }
  }
  return errors;
}

// Whether a value is farther than half a step from its input. `note` gets the errors of each quantized
// attribute.
using NoteErrors = std::function<void(const Attribute&, const Errors&)>;
std::string coarse_values(const Mesh& expected, const Mesh& decoded, const std::vector<Tolerance>& tolerances,
                          const NoteErrors& note) {
  const bool as_points = expected.point_count == decoded.point_count;
  const Mesh from = as_points ? expected : drawn_faces(expected),
             to = as_points ? decoded : drawn_faces(decoded);
  if (from.point_count != to.point_count) return note ? "" : "the faces have other numbers of corners";
  for (size_t i = 0; i < from.attributes.size(); ++i) {
    const Attribute& attribute = from.attributes[i];
    const auto other = std::ranges::find(to.attributes, attribute.semantic, &Attribute::semantic);
    if (tolerances[i].kind != Tolerance::Kind::kGrid || attribute.semantic.starts_with("WEIGHTS_") ||
        other == to.attributes.end() || other->component_type != attribute.component_type ||
        attribute.values == other->values)
      continue;
    const Errors errors = errors_of(attribute, *other, tolerances[i]);
    if (note) note(attribute, errors);
    // Noise beyond glTF's limits is trimmed.
    const double trimmed = has_limits(attribute.semantic) ? 1e-2 : 0;
    if (!note && errors.worst > 1 + errors.rounding + trimmed)
      return attribute.semantic + " is off by " + std::to_string(errors.worst) +
             " half steps of its own extent";
  }
  return "";
}

// Empty if the primitives are equal. A primitive that psplit cannot read must be unchanged.
std::string difference(const Primitive& input, const Primitive& output, bool lossless,
                       std::map<GridName, Extent>& extents, const NoteErrors& note) {
  const Expected<Mesh>&input_mesh = input.mesh, &decoded = output.mesh;
  if (!input_mesh || !decoded)
    return input_mesh.ok() == decoded.ok() ? "" : input_mesh.status().message() + decoded.status().message();
  const Mesh expected = merge_duplicates(*input_mesh);
  std::vector<Tolerance> tolerances;
  for (const Attribute& attribute : expected.attributes)
    tolerances.push_back(lossless ? exact_tolerance()
                                  : default_tolerance(attribute, extents[grid_name(input, attribute)]));
  if (note) return coarse_values(expected, *decoded, tolerances, note);
  const std::string why = compare_meshes(expected, *decoded, tolerances);
  // By default, faces and points that draw nothing are dropped, and stock Draco adds a point when it splits a
  // vertex.
  if (!why.empty() && !lossless) {
    const std::string drawn = compare_meshes(drawn_faces(expected), drawn_faces(*decoded), tolerances);
    if (drawn.empty()) return coarse_values(expected, *decoded, tolerances, note);
    // A primitive that would grow is unchanged, and its equal points are not merged.
    const std::vector<Tolerance> exact(input_mesh->attributes.size(), exact_tolerance());
    return compare_meshes(drawn_faces(*input_mesh), drawn_faces(*decoded), exact).empty() ? "" : drawn;
  }
  if (why.empty()) return lossless ? "" : coarse_values(expected, *decoded, tolerances, note);
  // Primitives that share attributes divide the points: each gets only the points that it uses.
  if (expected.point_count == decoded->point_count) return why;
  return compare_meshes(drop_unused_points(expected), drop_unused_points(*decoded), tolerances);
}

int run(std::span<const std::string_view> arguments) {
  const bool lossless = !arguments.empty() && arguments.front() == "--lossless";
  NoteErrors note;
  if (!arguments.empty() && arguments.front() == "--errors")
    note = [](const Attribute& attribute, const Errors& errors) {
      std::cout << attribute.semantic << ' ' << errors.count << ' ' << errors.worst << ' '
                << errors.sum / static_cast<double>(std::max<size_t>(1, errors.count)) << '\n';
    };
  if (lossless || note) arguments = arguments.subspan(1);
  if (arguments.size() != 2) {
    std::cout << "usage: same_mesh [--lossless | --errors] INPUT DECODED\n";
    return 1;
  }
  const ThreadPool pool(1);
  std::array<std::vector<Primitive>, 2> files;
  for (size_t i = 0; i < 2; ++i) {
    Expected<std::vector<Primitive>> primitives = read_primitives_of(std::string(arguments[i]), pool);
    if (!primitives) {
      std::cout << arguments[i] << ": " << primitives.status().to_string() << '\n';
      return static_cast<int>(primitives.status().code());
    }
    files[i] = std::move(*primitives);
  }
  if (files[0].size() != files[1].size()) {
    std::cout << files[0].size() << " primitives became " << files[1].size() << '\n';
    return 7;
  }
  std::map<GridName, Extent> extents;
  if (!lossless) extents = extents_of(files[0]);
  for (size_t i = 0; i < files[0].size(); ++i) {
    const std::string why = difference(files[0][i], files[1][i], lossless, extents, note);
    if (why.empty()) continue;
    std::cout << "primitive " << i << " in order: " << why << '\n';
    return 7;
  }
  return 0;
}

}  // namespace
}  // namespace psplit

int main(int argc, char** argv) {
  const std::vector<std::string_view> arguments(argv + 1, argv + argc);
  return psplit::run(arguments);
}
