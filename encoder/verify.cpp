#include "encoder/verify.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "encoder/coding/quantization.h"
#include "psplit/decode.h"
#include "src/container/patch_container.h"
#include "src/mesh/number_of.h"

namespace psplit {
namespace {

constexpr size_t kGrain = 1 << 14;
size_t range_count(size_t count) { return (count + kGrain - 1) / kGrain; }

Status differs(const std::string& what) { return runtime_failure("verification: " + what); }

std::array<uint32_t, 3> lowest_first(const std::array<uint32_t, 3>& face) {
  // No processor predicts where the lowest is, so there are no branches.
  const auto& [a, b, c] = face;
  const uint32_t lowest = std::min(std::min(a, b), c);
  const bool is_first = a == lowest, is_second = b == lowest;
  const uint32_t second = is_first ? b : is_second ? c : a;
  const uint32_t third = is_first ? c : is_second ? a : b;
  // If an index occurs twice, two rotations may begin with the lowest. Take one of them always.
  if (third == lowest) return {lowest, lowest, second};
  return {lowest, second, third};
}

// Whether three floats are near three others. If not, they may agree all the same: see agree().
bool are_near(const std::byte* wanted, const std::byte* got, const double* bounds) {
  std::array<float, 3> a, b;
  std::memcpy(a.data(), wanted, sizeof a);
  std::memcpy(b.data(), got, sizeof b);
  bool is_near = true;  // distances that are not numbers are not near
  for (size_t c = 0; c < a.size(); ++c) is_near &= std::fabs(double{a[c]} - double{b[c]}) <= bounds[c];
  return is_near;
}

// Whether a decoded value is what quantization may make of the wanted one.
bool agree(const Attribute& wanted, const Attribute& got, size_t wanted_point, size_t got_point,
           const AttributeCoding& coding, std::span<const double> bounds) {
  if (coding.bits == 0)
    return std::memcmp(wanted.values.data() + wanted_point * wanted.stride(),
                       got.values.data() + got_point * got.stride(), wanted.stride()) == 0;
  const auto wanted_at = [&](size_t c) {
    return double{float_at(wanted, wanted_point * wanted.component_count + c)};
  };
  const auto got_at = [&](size_t c) { return double{float_at(got, got_point * got.component_count + c)}; };
  if (coding.octahedral)
    return direction_distance({wanted_at(0), wanted_at(1), wanted_at(2)}, {got_at(0), got_at(1), got_at(2)}) <=
           bounds[0];
  for (size_t c = 0; c < wanted.component_count; ++c)
    if (component_distance(wanted_at(c), got_at(c)) > bounds[c]) return false;
  return true;
}

// A sum over faces, in any order. Sums of different faces are equal by chance only: one in 2^64. To sort the
// faces and compare them would take a tenth of all encoding.
template <typename FaceAt>
uint64_t sum_of_faces(size_t count, FaceAt face_at, const ThreadPool& pool) {
  const auto mix = [](uint64_t value) {
    value = (value ^ value >> 32) * 0xd6e8feb86659fd93u;
    value = (value ^ value >> 32) * 0xd6e8feb86659fd93u;
    return value ^ value >> 32;
  };
  std::atomic<uint64_t> sum = 0;
  pool.for_ranges(count, kGrain, [&](size_t begin, size_t end) {
    uint64_t of_range = 0;
    for (size_t i = begin; i < end; ++i) {
      const auto [a, b, c] = face_at(i);
      of_range += mix(mix(uint64_t{a} << 32 | b) + c);
    }
    sum += of_range;
  });
  return sum;
}

// The first of the wanted faces, in ascending order, that is not among the others. The faces must differ.
template <typename Wanted, typename Got>
std::string first_missing(size_t count, Wanted wanted_face, Got got_face) {
  std::vector<std::array<uint32_t, 3>> wanted, got;
  for (size_t i = 0; i < count; ++i) {
    wanted.push_back(wanted_face(i));
    got.push_back(got_face(i));
  }
  std::sort(wanted.begin(), wanted.end());
  std::sort(got.begin(), got.end());
  const auto& [a, b, c] = *std::mismatch(wanted.begin(), wanted.end(), got.begin()).first;
  return std::to_string(a) + ", " + std::to_string(b) + ", " + std::to_string(c);
}

// The largest distance between two positions; 0 if they are not three floats.
double largest_distance(const Mesh& mesh, const Mesh& decoded, std::span<const uint32_t> source_point,
                        const ThreadPool& pool) {
  const Attribute& wanted = *mesh.find("POSITION");
  const Attribute& got = *decoded.find("POSITION");
  if (wanted.component_type != ComponentType::kFloat32 || wanted.component_count != 3) return 0;
  std::vector<double> largest(range_count(decoded.point_count), 0.0);
  pool.for_ranges(decoded.point_count, kGrain, [&](size_t begin, size_t end) {
    double of_range = 0;
    for (size_t point = begin; point < end; ++point) {
      double square = 0;
      for (size_t c = 0; c < 3; ++c) {
        const double difference = double{float_at(wanted, source_point[point] * size_t{3} + c)} -
                                  double{float_at(got, point * size_t{3} + c)};
        square += difference * difference;
      }
      of_range = std::max(of_range, square);
    }
    largest[begin / kGrain] = of_range;
  });
  return largest.empty() ? 0 : std::sqrt(std::ranges::max(largest));
}

}  // namespace

Status verify_mesh(const Mesh& mesh, std::span<const AttributeCoding> codings, const Mesh& decoded,
                   std::span<const uint32_t> source_point, uint32_t foreign_count, bool has_copies,
                   const ThreadPool& pool, std::optional<double>& position_error) {
  const uint64_t point_count = uint64_t{decoded.point_count} + foreign_count;
  if (source_point.size() != point_count ||
      (has_copies ? point_count < mesh.point_count : point_count != mesh.point_count))
    return differs("points: " + std::to_string(point_count) + ", not " + std::to_string(mesh.point_count));
  if (decoded.faces.size() != mesh.faces.size())
    return differs("faces: " + std::to_string(decoded.faces.size()) + ", not " +
                   std::to_string(mesh.faces.size()));

  std::vector<uint8_t> seen(mesh.point_count, 0);
  size_t seen_count = 0;
  for (uint32_t source : source_point) {
    if (source >= mesh.point_count) return differs("a point came back that is not there");
    if (std::exchange(seen[source], uint8_t{1}) == 0)
      ++seen_count;
    else if (!has_copies)
      return differs("a point came back twice");
  }
  if (seen_count != mesh.point_count) return differs("a point did not come back");

  const auto wanted_face = [&](size_t i) { return lowest_first(mesh.faces[i]); };
  const auto got_face = [&](size_t i) {
    const auto& [a, b, c] = decoded.faces[i];
    return lowest_first({source_point[a], source_point[b], source_point[c]});
  };
  if (sum_of_faces(mesh.faces.size(), wanted_face, pool) != sum_of_faces(mesh.faces.size(), got_face, pool))
    return differs("the face of points " + first_missing(mesh.faces.size(), wanted_face, got_face) +
                   " did not come back");

  for (size_t i = 0; i < mesh.attributes.size(); ++i) {
    const Attribute& a = mesh.attributes[i];
    const Attribute& b = decoded.attributes[i];
    if (a.stride() != b.stride() || a.component_type != b.component_type)
      return differs(a.semantic + " changed type");
    const std::vector<double> bounds = error_bounds(codings[i]);
    const bool are_three = bounds.size() == 3 && a.stride() == 3 * sizeof(float);
    constexpr uint32_t kNoPoint = 0xffffffffu;
    std::vector<uint32_t> first_wrong(range_count(decoded.point_count), kNoPoint);
    pool.for_ranges(decoded.point_count, kGrain, [&](size_t begin, size_t end) {
      const auto agrees = [&](size_t point) {
        const size_t source = source_point[point];
        return (are_three && are_near(a.values.data() + source * a.stride(),
                                      b.values.data() + point * a.stride(), bounds.data())) ||
               agree(a, b, source, point, codings[i], bounds);
      };
      size_t point = begin;
      while (point < end && agrees(point)) ++point;
      if (point < end) first_wrong[begin / kGrain] = source_point[point];
    });
    for (const uint32_t source : first_wrong)
      if (source != kNoPoint)
        return differs(a.semantic + " of point " + std::to_string(source) + " came back with another value");
  }
  position_error = std::max(position_error.value_or(0), largest_distance(mesh, decoded, source_point, pool));
  return {};
}

Status verify_condensed(std::span<const uint8_t> container, std::span<const AttributeRequest> requests,
                        const Mesh& decoded, const ThreadPool& pool) {
  const Expected<PatchContainer> opened = open_container(container);
  if (!opened) return differs(opened.status().to_string());
  const Expected<Mesh> condensed = cpu_backend().decode(*opened, requests, pool);
  if (!condensed) return differs(condensed.status().to_string());
  const auto is_as_before = [&](const Attribute& attribute) {
    const Attribute* const before = decoded.find(attribute.semantic);
    return before != nullptr && before->values == attribute.values;
  };
  if (condensed->faces != decoded.faces || !std::ranges::all_of(condensed->attributes, is_as_before))
    return differs("condensed patches decode to another mesh");
  return {};
}

}  // namespace psplit
