#include "encoder/stream/patch_steps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "encoder/coding/quantization.h"
#include "encoder/stream/attribute_plan.h"

namespace psplit {
namespace {

// The values of one attribute as libdraco's encoder sees them: quantized, or integers as they are.
class Steps {
 public:
  Steps(const Attribute& attribute, const AttributeCoding& coding) : attribute_(attribute), coding_(coding) {}

  // Component `c` at a point of the mesh.
  double at(uint32_t point, size_t c) const {
    const std::byte* value = attribute_.values.data() + point * attribute_.stride();
    switch (attribute_.component_type) {
      case ComponentType::kInt8: return load<int8_t>(value, c);
      case ComponentType::kUint8: return load<uint8_t>(value, c);
      case ComponentType::kInt16: return load<int16_t>(value, c);
      case ComponentType::kUint16: return load<uint16_t>(value, c);
      case ComponentType::kUint32: return load<uint32_t>(value, c);
      case ComponentType::kFloat32: break;
    }
    return double{grid_place(load<float>(value, c), coding_.origin[c], coding_.range, coding_.bits)};
  }

 private:
  template <typename T>
  static T load(const std::byte* value, size_t c) {
    T component;
    std::memcpy(&component, value + c * sizeof(T), sizeof(T));
    return component;
  }

  const Attribute& attribute_;
  const AttributeCoding& coding_;
};

using Vector = std::array<double, 3>;

template <size_t kCount>
Vector vector_at(const Steps& steps, uint32_t point) {
  Vector vector{};
  for (size_t c = 0; c < kCount; ++c) vector[c] = steps.at(point, c);
  return vector;
}
Vector difference(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double largest(const Vector& a) { return std::max({std::fabs(a[0]), std::fabs(a[1]), std::fabs(a[2])}); }

// 2^63, less what doubles round off.
constexpr double kMost = 9223372036854775808.0 * (1 - 1e-12);

// The products at one corner of a triangle. `n` and `p` are the corners after and before it.
bool overflows(const Vector& tip, const Vector& n, const Vector& p, const Vector& n_texture,
               const Vector& p_texture) {
  const Vector pn = difference(p, n);
  const double square = dot(pn, pn), along = std::fabs(dot(pn, difference(tip, n)));
  return square * largest(n_texture) >= kMost || along * largest(pn) >= kMost ||
         along * largest(difference(p_texture, n_texture)) >= kMost;
}

}  // namespace

bool texture_prediction_may_overflow(const WeldedMesh& welded, const PatchMesh& patch,
                                     std::span<const AttributeCoding> codings, size_t texcoords) {
  const Mesh& mesh = *welded.mesh;
  const auto positions = static_cast<size_t>(mesh.find("POSITION") - mesh.attributes.data());
  const auto is_float = [&](size_t i) { return mesh.attributes[i].component_type == ComponentType::kFloat32; };
  const auto bits_of = [&](size_t i) { return is_float(i) ? codings[i].bits : kMostBitsOfIntegers; };
  const int bits = bits_of(positions), texture_bits = bits_of(texcoords);
  if (texture_bits == 0 || mesh.attributes[positions].component_count != 3 ||
      (is_float(positions) && (bits == 0 || !predicts_texture(bits, texture_bits))))
    return false;
  // Products of three steps, and a sum of three of them.
  if (2 * bits + std::max(bits, texture_bits) + 2 <= 63) return false;

  const Steps position(mesh.attributes[positions], codings[positions]),
      texture(mesh.attributes[texcoords], codings[texcoords]);
  const std::vector<uint32_t>& points = patch.points_of_values();
  for (const auto& face : patch.faces) {
    Vector at[3], texture_at[3];
    for (size_t i = 0; i < 3; ++i) {
      at[i] = vector_at<3>(position, points[face[i]]);
      texture_at[i] = vector_at<2>(texture, points[face[i]]);
    }
    for (size_t tip = 0; tip < 3; ++tip) {
      const size_t n = (tip + 1) % 3, p = (tip + 2) % 3;
      if (overflows(at[tip], at[n], at[p], texture_at[n], texture_at[p])) return true;
    }
  }
  return false;
}

}  // namespace psplit
