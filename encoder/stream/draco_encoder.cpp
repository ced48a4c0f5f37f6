#include "encoder/stream/draco_encoder.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <string>
#include <utility>

#include "encoder/coding/quantization.h"
#include "encoder/stream/cloud_stream.h"
#include "encoder/stream/patch_mesh.h"
#include "encoder/stream/sequential_stream.h"
#include "encoder/welding/weld.h"
#include "src/mesh/number_of.h"

namespace psplit {
namespace {

constexpr int kFewestOctahedralBits = 2;

bool is_float(const DracoLabel& label) { return label.type == DataType::kFloat32; }
bool is_position(const DracoLabel& label) { return label.semantic == DracoSemantic::kPosition; }
bool is_normal(const DracoLabel& label) { return label.semantic == DracoSemantic::kNormal; }

// The grid of all values. The least value is the first of equal ones: zeros have signs.
Status find_grid(const Attribute& attribute, AttributeCoding& coding) {
  const size_t components = attribute.component_count, count = attribute.values.size() / attribute.stride();
  std::vector<float> low(components), high(components), value(components);
  bool is_finite = true;
  for (size_t i = 0; i < count; ++i) {
    std::memcpy(value.data(), attribute.values.data() + i * attribute.stride(), attribute.stride());
    if (i == 0) low = high = value;
    for (size_t c = 0; c < components; ++c) {
      is_finite = is_finite && std::isfinite(value[c]);
      if (value[c] < low[c]) low[c] = value[c];
      if (value[c] > high[c]) high[c] = value[c];
    }
  }
  float range = 0;
  for (size_t c = 0; c < components; ++c) range = std::max(range, high[c] - low[c]);
  if (!is_finite || !std::isfinite(range)) return invalid_input(attribute.semantic + ": a value is not finite");
  coding.origin = std::move(low);
  coding.range = range == 0 ? 1.0f : range;
  return {};
}

// Any value may be far from a caller's grid.
Status check_places(const Attribute& attribute, const AttributeCoding& coding) {
  constexpr float kMost = 2147483648.0f;
  bool fit = true;
  const size_t components = attribute.component_count, count = attribute.values.size() / sizeof(float);
  for (size_t i = 0; i < count; ++i) {
    const float value = float_at(attribute, i);
    fit = fit && std::fabs(grid_place(value, coding.origin[i % components], coding.range, coding.bits)) < kMost;
  }
  return fit ? Status() : unsupported(attribute.semantic + ": a value is too far beyond its grid");
}

Status check_integers(const Attribute& attribute) {
  bool fits = true;
  for (size_t at = 0; at < attribute.values.size(); at += sizeof(int32_t)) {
    int32_t value;
    std::memcpy(&value, attribute.values.data() + at, sizeof value);
    fits = fits && value >= 0;
  }
  return fits ? Status() : invalid_input(attribute.semantic + ": an integer above 2^31 - 1");
}

// `is_tree`: directions are on a grid of their components.
Status complete_coding(const Attribute& attribute, const DracoLabel& label, bool is_tree,
                       AttributeCoding& coding) {
  if (label.type == DataType::kUint32 && !is_tree) return check_integers(attribute);
  if (!is_float(label) || coding.bits <= 0) return {};
  static_assert(kMostGridBits == 30);  // a literal keeps the module for the web small
  if (coding.bits > kMostGridBits) return invalid_input(attribute.semantic + ": more than 30 bits");
  coding.octahedral = is_normal(label) && !is_tree;
  if (!coding.octahedral)
    return coding.origin.empty() ? find_grid(attribute, coding) : check_places(attribute, coding);
  return attribute.component_count == 3 && coding.bits >= kFewestOctahedralBits
             ? Status()
             : invalid_input(attribute.semantic + ": normals on a grid have 3 components and 2 bits");
}

Status check_faces(const Mesh& mesh) {
  for (const auto& face : mesh.faces)
    for (const uint32_t point : face)
      if (point >= mesh.point_count) return invalid_input("a face has a point that does not exist");
  return {};
}

std::vector<uint32_t> own_values(uint32_t point_count) {
  std::vector<uint32_t> values(point_count);
  std::iota(values.begin(), values.end(), 0u);
  return values;
}

// Equal values matter only at seams, where several points have the same position.
WeldedMesh share_values(const DracoMesh& draco, bool has_one_table) {
  const Mesh& mesh = draco.mesh;
  const auto values_of = [&](size_t i) {
    const Attribute& attribute = mesh.attributes[i];
    return draco.share_values[i] != 0
               ? lowest_equal_rows(mesh.point_count, attribute.values, attribute.stride(), {}, ThreadPool(1))
               : own_values(mesh.point_count);
  };
  WeldedMesh welded{&mesh, std::vector<std::vector<uint32_t>>(mesh.attributes.size())};
  bool may_have_seams = !has_one_table;
  if (may_have_seams) {
    const auto position =
        static_cast<size_t>(std::ranges::find_if(draco.labels, is_position) - draco.labels.begin());
    welded.value_of_point[position] = values_of(position);
    may_have_seams = welded.value_of_point[position] != own_values(mesh.point_count);
  }
  for (size_t i = 0; i < mesh.attributes.size(); ++i)
    if (std::vector<uint32_t>& values = welded.value_of_point[i]; values.empty())
      values = may_have_seams ? values_of(i) : own_values(mesh.point_count);
  return welded;
}

}  // namespace

Status deduplicate(DracoMesh& draco) {
  Mesh& mesh = draco.mesh;
  if (Status status = check_faces(mesh); !status.ok()) return status;
  std::ranges::fill(draco.share_values, uint8_t{1});
  std::vector<uint32_t> number = find_duplicates(mesh, {}, 0, ThreadPool(1));
  uint32_t count = 0;
  for (uint32_t point = 0; point < mesh.point_count; ++point) {
    if (number[point] != point) {
      number[point] = number[number[point]];
      continue;
    }
    // Compacts the values in place.
    for (Attribute& attribute : mesh.attributes) {
      std::byte* const values = attribute.values.data();
      std::memmove(values + count * attribute.stride(), values + point * attribute.stride(),
                   attribute.stride());
    }
    number[point] = count++;
  }
  if (count == mesh.point_count) return {};
  for (auto& face : mesh.faces)
    for (uint32_t& point : face) point = number[point];
  for (Attribute& attribute : mesh.attributes) attribute.values.resize(count * attribute.stride());
  mesh.point_count = count;
  return {};
}

Expected<LabelledStream> encode_as_draco(const DracoMesh& draco, std::vector<AttributeCoding> codings,
                                         bool is_sequential, int speed) {
  const Mesh& mesh = draco.mesh;
  if (Status status = check_faces(mesh); !status.ok()) return status;
  const auto positions = std::count_if(draco.labels.begin(), draco.labels.end(), is_position);
  if (positions > 1) return unsupported("a mesh with several attributes of the type POSITION");
  if (positions == 0 && !is_sequential)
    return unsupported("Edgebreaker without an attribute of the type POSITION");
  for (size_t i = 0; i < codings.size(); ++i)
    if (Status status = complete_coding(mesh.attributes[i], draco.labels[i], false, codings[i]); !status.ok())
      return status;
  const WeldedMesh welded = share_values(draco, is_sequential || speed >= kSpeedOfOneTable);
  const PatchMesh whole = whole_mesh(mesh);
  if (!is_sequential) return encode_labelled(welded, whole, codings, draco.labels, speed);
  Expected<std::vector<uint8_t>> bytes =
      write_sequential_stream({welded, codings, whole.points}, whole.faces, speed, draco.labels);
  if (!bytes) return bytes.status();
  return LabelledStream{std::move(*bytes), mesh.point_count, static_cast<uint32_t>(mesh.faces.size())};
}

Expected<LabelledStream> encode_cloud_as_draco(const DracoMesh& draco, std::vector<AttributeCoding> codings,
                                               std::optional<CloudMethod> method, int speed) {
  const Mesh& cloud = draco.mesh;
  const bool is_tree = method ? *method == CloudMethod::kTree : becomes_tree(cloud, codings, speed);
  for (size_t i = 0; i < codings.size(); ++i)
    if (Status status = complete_coding(cloud.attributes[i], draco.labels[i], is_tree, codings[i]);
        !status.ok())
      return status;
  Expected<EncodedCloud> encoded = encode_cloud(cloud, codings, is_tree, speed, draco.labels);
  if (!encoded) return encoded.status();
  return LabelledStream{std::move(encoded->bytes), cloud.point_count, 0};
}

}  // namespace psplit
