#include "mesh_files/repair_values.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace psplit {
namespace {

using Vector = std::array<float, 3>;

template <typename T>
T load(const Attribute& attribute, size_t index) {
  T value;
  std::memcpy(&value, attribute.values.data() + index * sizeof(T), sizeof(T));
  return value;
}

template <typename T>
void store(Attribute& attribute, size_t index, const T& value) {
  std::memcpy(attribute.values.data() + index * sizeof(T), &value, sizeof(T));
}

double squared_length(const std::array<double, 3>& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }

Vector unit(const std::array<double, 3>& v, double square) {
  const double scale = 1 / std::sqrt(square);
  return {static_cast<float>(v[0] * scale), static_cast<float>(v[1] * scale), static_cast<float>(v[2] * scale)};
}

// For each point with a slot > 0, the sum of the area vectors of its faces.
std::vector<std::array<double, 3>> normals_of_faces(const Mesh& mesh, const Attribute& positions,
                                                    const std::vector<uint32_t>& slot_of_point,
                                                    size_t slot_count) {
  std::vector<std::array<double, 3>> sums(slot_count);
  for (const auto& face : mesh.faces) {
    if (std::ranges::all_of(face, [&](uint32_t point) { return slot_of_point[point] == 0; })) continue;
    const std::array<double, 3> normal = area_vector(
        {position_at(positions, face[0]), position_at(positions, face[1]), position_at(positions, face[2])});
    for (const uint32_t point : face)
      if (const uint32_t slot = slot_of_point[point]; slot > 0)
        for (size_t axis = 0; axis < 3; ++axis) sums[slot - 1][axis] += normal[axis];
  }
  return sums;
}

// Returns whether any normal has a direction.
bool repair_normals(Mesh& mesh, Attribute& normals, const Attribute& positions, Losses& losses) {
  std::vector<uint32_t> zeros, slot_of_point;
  const uint64_t changed = normalize(normals, 0, zeros);
  if (zeros.size() == mesh.point_count) return false;
  say_normals(changed, zeros.size(), losses);
  if (zeros.empty()) return true;
  slot_of_point.assign(mesh.point_count, 0);
  for (size_t slot = 0; slot < zeros.size(); ++slot)
    slot_of_point[zeros[slot]] = static_cast<uint32_t>(slot + 1);
  const auto sums = normals_of_faces(mesh, positions, slot_of_point, zeros.size());
  for (size_t slot = 0; slot < zeros.size(); ++slot) store(normals, zeros[slot], normal_of_faces(sums[slot]));
  return true;
}

}  // namespace

void repair_values(MeshFile& file) {
  for (MeshFileObject& object : file.objects)
    for (MeshFilePart& part : object.parts) {
      Mesh& mesh = part.mesh;
      const auto named = [&](const char* semantic) {
        return std::ranges::find(mesh.attributes, semantic, &Attribute::semantic);
      };
      const auto positions = named("POSITION"), normals = named("NORMAL");
      const auto end = mesh.attributes.end();
      for (Attribute& attribute : mesh.attributes) repair_floats(attribute, file.losses);
      if (normals == end || positions == end || repair_normals(mesh, *normals, *positions, file.losses))
        continue;
      mesh.attributes.erase(normals);
      say_no_normals(file.losses);
    }
}

void repair_floats(Attribute& attribute, Losses& losses) {
  if (attribute.component_type != ComponentType::kFloat32 || attribute.semantic == "POSITION" ||
      attribute.semantic == "NORMAL")
    return;
  const bool is_color = attribute.semantic.starts_with("COLOR_");
  const size_t count = attribute.values.size() / sizeof(float);
  uint64_t not_finite = 0, clamped = 0;
  for (size_t i = 0; i < count; ++i) {
    const auto value = load<float>(attribute, i);
    if (!std::isfinite(value)) {
      ++not_finite;
      store(attribute, i, 0.0f);
    } else if (is_color && (value < 0 || value > 1)) {
      ++clamped;
      store(attribute, i, std::clamp(value, 0.0f, 1.0f));
    }
  }
  const std::string of = " of " + attribute.semantic;
  losses.add("number" + of + " was not finite: it is 0 now",
             "numbers" + of + " were not finite: they are 0 now", not_finite);
  losses.add("number" + of + " was not between 0 and 1: clamped",
             "numbers" + of + " were not between 0 and 1: clamped", clamped);
}

uint64_t normalize(Attribute& normals, uint32_t first, std::vector<uint32_t>& zeros) {
  constexpr double kUnit = 2e-3;  // more than the rounding error of numbers with three decimals
  const auto count = static_cast<uint32_t>(normals.values.size() / sizeof(Vector));
  uint64_t changed = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const Vector value = load<Vector>(normals, i);
    if (!has_direction(value)) {
      zeros.push_back(first + i);
      continue;
    }
    const std::array<double, 3> v{value[0], value[1], value[2]};
    const double square = squared_length(v);
    if (std::fabs(square - 1) <= kUnit) continue;
    store(normals, i, unit(v, square));
    ++changed;
  }
  return changed;
}

void say_normals(uint64_t changed, uint64_t zeros, Losses& losses) {
  losses.add("normal was not of unit length: normalized", "normals were not of unit length: normalized",
             changed);
  losses.add("normal had no direction: made from the faces around it",
             "normals had no direction: made from the faces around them", zeros);
}

void say_no_normals(Losses& losses) { losses.say("no normal has a direction: all are left out"); }

bool has_direction(const std::array<float, 3>& normal) {
  const double square = squared_length({normal[0], normal[1], normal[2]});
  return std::isfinite(square) && square != 0;
}

std::array<double, 3> area_vector(const std::array<Position, 3>& p) {
  std::array<double, 3> normal;
  for (size_t axis = 0; axis < 3; ++axis) {
    const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    normal[axis] = (double{p[1][u]} - p[0][u]) * (double{p[2][v]} - p[0][v]) -
                   (double{p[1][v]} - p[0][v]) * (double{p[2][u]} - p[0][u]);
  }
  return normal;
}

std::array<float, 3> normal_of_faces(const std::array<double, 3>& sum) {
  const double square = squared_length(sum);
  return square > 0 ? unit(sum, square) : Vector{0, 0, 1};
}

}  // namespace psplit
