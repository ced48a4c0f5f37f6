#include "encoder/coding/position_bits.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "encoder/coding/quantization.h"

namespace psplit {
namespace {

// See step_for_edges.
constexpr double kStepsOfEdge = 20;
constexpr double kShareOfShorterEdges = 0.05;

double largest_coordinate(const AttributeCoding& grid) {
  double largest = 0;
  for (const float origin : grid.origin)
    largest = std::max({largest, std::fabs(double{origin}), std::fabs(double{origin} + double{grid.range})});
  return largest;
}

float distance(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  double square = 0;
  for (size_t c = 0; c < 3; ++c) square += (double{a[c]} - double{b[c]}) * (double{a[c]} - double{b[c]});
  return static_cast<float>(std::sqrt(square));
}

AttributeCoding with_bits(AttributeCoding grid, int bits) {
  grid.bits = bits;
  return grid;
}

}  // namespace

std::string rounded_text(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 3);
  return {text.data(), end.ptr};
}

// A bijection on 64 bits, so that the sample has no pattern.
uint64_t EdgeSample::hash_of(uint64_t face) {
  face = (face ^ (face >> 33)) * 0xff51afd7ed558ccdu;
  face = (face ^ (face >> 33)) * 0xc4ceb9fe1a85ec53u;
  return face ^ (face >> 33);
}

void EdgeSample::add(uint64_t face, const std::array<std::array<float, 3>, 3>& corners) {
  if (!wants(face)) return;
  faces_.push_back(
      {hash_of(face),
       {distance(corners[0], corners[1]), distance(corners[1], corners[2]), distance(corners[2], corners[0])}});
  while (faces_.size() > most_faces_) {
    mask_ = mask_ << 1 | 1;
    std::erase_if(faces_, [this](const Face& kept) { return (kept.hash & mask_) != 0; });
  }
}

void EdgeSample::add(const Mesh& mesh) {
  const Attribute* position = mesh.find("POSITION");
  if (position == nullptr || position->component_type != ComponentType::kFloat32 ||
      position->component_count != 3)
    return;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    if (!wants(f)) continue;
    std::array<std::array<float, 3>, 3> corners;
    for (size_t i = 0; i < 3; ++i)
      std::memcpy(corners[i].data(), position->values.data() + mesh.faces[f][i] * sizeof corners[i],
                  sizeof corners[i]);
    add(f, corners);
  }
}

std::vector<float> EdgeSample::lengths() const {
  std::vector<float> lengths;
  for (const Face& face : faces_)
    std::copy_if(face.lengths.begin(), face.lengths.end(), std::back_inserter(lengths),
                 [](float length) { return length > 0 && std::isfinite(length); });
  return lengths;
}

double step_for_edges(std::vector<float> lengths) {
  if (lengths.empty()) return 0;
  const auto place = static_cast<size_t>(kShareOfShorterEdges * static_cast<double>(lengths.size()));
  const auto at = lengths.begin() + static_cast<std::ptrdiff_t>(place);
  std::nth_element(lengths.begin(), at, lengths.end());
  return double{*at} / kStepsOfEdge;
}

int position_bits_for_step(const AttributeCoding& grid, double step) {
  const double finest = largest_coordinate(grid) * std::ldexp(1.0, -24);
  int bits = kLeastBitsForEdges;
  if (step > 0)
    while (bits < kMostGridBits && grid_step(with_bits(grid, bits)) > std::max(step, finest)) ++bits;
  return bits;
}

Expected<int> position_bits_for_error(const AttributeCoding& grid, double max_error) {
  for (int bits = 1; bits <= kMostGridBits; ++bits)
    if (distance_bound(with_bits(grid, bits)) <= max_error) return bits;
  return Status(StatusCode::kUsage,
                "an error of at most " + rounded_text(max_error) +
                    " cannot be guaranteed: floats of these coordinates allow no less than " +
                    rounded_text(distance_bound(with_bits(grid, kMostGridBits))) +
                    "; --lossless keeps every float");
}

double distance_bound(const AttributeCoding& grid) {
  double square = 0;
  for (const float origin : grid.origin) {
    const double bound = grid_bound(grid.bits, origin, grid.range);
    square += bound * bound;
  }
  return std::sqrt(square);
}

}  // namespace psplit
