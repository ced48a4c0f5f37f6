#include "encoder/coding/grid_loss.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>

#include "encoder/coding/precision_guard.h"
#include "encoder/coding/quantization.h"
#include "src/core/platform.h"
#include "src/mesh/number_of.h"

namespace psplit {
namespace {

// Differences of coordinates below this share of the largest of them are the noise of floats.
const double kNoise = std::ldexp(1.0, -22);
constexpr uint32_t kNoPoint = UINT32_MAX;

using GridPlace = std::array<int32_t, 3>;
using Values = std::array<float, 3>;

constexpr size_t kPointsAtOnce = 1 << 14;

// An attribute of at most three components, and its places on a grid.
class Placed {
 public:
  Placed(const Attribute& attribute, const AttributeCoding& grid, Span<const uint8_t> stored,
         const ThreadPool& pool)
      : attribute_(attribute), stored_(stored), places_(attribute.values.size() / attribute.stride()) {
    const float scale = grid.range > 0 ? steps_of(grid) / grid.range : 0;
    Values origin{};
    std::ranges::copy(grid.origin, origin.begin());
    std::atomic<size_t> stored_count = 0;
    pool.for_ranges(places_.size(), kPointsAtOnce, [&](size_t begin, size_t end) {
      size_t of_range = 0;
      for (size_t i = begin; i < end; ++i) {
        const auto point = static_cast<uint32_t>(i);
        if (!is_stored(point)) continue;
        ++of_range;
        const Values value = value_of(point);
        // Missing components are at 0, because their values and origins are.
        for (size_t c = 0; c < value.size(); ++c)
          places_[i][c] = rounded_down((value[c] - origin[c]) * scale + 0.5f);
      }
      stored_count += of_range;
    });
    stored_count_ = stored_count;
  }

  static float steps_of(const AttributeCoding& grid) { return static_cast<float>((1u << grid.bits) - 1); }
  uint32_t size() const { return static_cast<uint32_t>(places_.size()); }
  size_t stored_count() const { return stored_count_; }
  bool is_stored(uint32_t point) const { return stored_.empty() || stored_[point] != 0; }
  // Skips indices that are out of range, which check_mesh reports later.
  bool are_stored(const std::array<uint32_t, 3>& face) const {
    if (std::max({face[0], face[1], face[2]}) >= size()) return false;
    return stored_.empty() || (stored_[face[0]] & stored_[face[1]] & stored_[face[2]]) != 0;
  }
  const GridPlace& operator[](uint32_t point) const { return places_[point]; }
  // Missing components are 0, and so are both zeros.
  Values value_of(uint32_t point) const {
    Values value{};
    std::memcpy(value.data(), attribute_.values.data() + point * attribute_.stride(), attribute_.stride());
    for (float& component : value) component += 0.0f;
    return value;
  }
  // Whether the values of two points differ by more than noise.
  bool differ(uint32_t a, uint32_t b) const {
    const Values va = value_of(a), vb = value_of(b);
    double difference = 0, largest = 0;
    for (size_t c = 0; c < va.size(); ++c) {
      difference = std::max(difference, std::fabs(double{va[c]} - double{vb[c]}));
      largest = std::max({largest, std::fabs(double{va[c]}), std::fabs(double{vb[c]})});
    }
    return difference > kNoise * largest;
  }

 private:
  const Attribute& attribute_;
  // As std::floor, which is a call where processors may lack SSE4.
  static int32_t rounded_down(float value) {
    const auto cut = static_cast<int32_t>(value);
    return cut - (static_cast<float>(cut) > value ? 1 : 0);
  }

  const Span<const uint8_t> stored_;
  Array<GridPlace> places_;  // of points that are stored
  size_t stored_count_ = 0;
};

uint64_t hash_of(const GridPlace& place) {
  uint64_t hash = 0;
  for (const int32_t c : place) {
    hash = (hash ^ static_cast<uint32_t>(c)) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 29;
  }
  return hash;
}

// Differences and products are computed as `T`.
template <typename T, typename Component>
std::array<T, 3> cross(const std::array<Component, 3>& a, const std::array<Component, 3>& b,
                       const std::array<Component, 3>& c) {
  std::array<T, 3> u{}, v{};
  for (size_t k = 0; k < 3; ++k) {
    u[k] = T{b[k]} - a[k];
    v[k] = T{c[k]} - a[k];
  }
  return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}

double length_of(const std::array<double, 3>& v) { return std::hypot(v[0], v[1], v[2]); }

// Whether the height of a face above its longest edge is more than noise.
bool has_area(const Placed& placed, const std::array<uint32_t, 3>& face) {
  std::array<std::array<double, 3>, 3> corner{};
  double largest = 0, longest = 0;
  for (size_t i = 0; i < 3; ++i) {
    const Values value = placed.value_of(face[i]);
    for (size_t c = 0; c < 3; ++c) {
      corner[i][c] = double{value[c]};
      largest = std::max(largest, std::fabs(corner[i][c]));
    }
  }
  for (size_t i = 0; i < 3; ++i) {
    std::array<double, 3> edge{};
    for (size_t c = 0; c < 3; ++c) edge[c] = corner[(i + 1) % 3][c] - corner[i][c];
    longest = std::max(longest, length_of(edge));
  }
  return length_of(cross<double>(corner[0], corner[1], corner[2])) > longest * largest * kNoise;
}

// The number of distinct positions, and of those positions that coincide with an earlier one on the grid.
class Coinciding {
 public:
  explicit Coinciding(const Placed& placed)
      : placed_(placed), first_at_(std::bit_ceil(2 * placed.stored_count() + 1), kNoPoint) {}

  LostShare count() {
    for (uint32_t point = 0; point < placed_.size(); ++point) {
      if (!placed_.is_stored(point)) continue;
      // A slot is read when the memory had time to provide it.
      const size_t slot = hash_of(placed_[point]) & (first_at_.size() - 1);
      PSPLIT_PREFETCH(&first_at_[slot]);
      waiting_[waiting_count_++] = {point, slot};
      if (waiting_count_ == waiting_.size()) finish();
    }
    finish();
    std::sort(lost_.begin(), lost_.end());
    share_.lost = static_cast<uint64_t>(std::unique(lost_.begin(), lost_.end()) - lost_.begin());
    share_.all += share_.lost;
    return share_;
  }

 private:
  void finish() {
    for (size_t i = 0; i < waiting_count_; ++i) add(waiting_[i].point, waiting_[i].slot);
    waiting_count_ = 0;
  }
  void add(uint32_t point, size_t slot) {
    const size_t mask = first_at_.size() - 1;
    const auto coincides = [&, &own = placed_[point]](uint32_t other) {
      const GridPlace& place = placed_[other];  // a comparison of arrays would be a call
      return ((place[0] ^ own[0]) | (place[1] ^ own[1]) | (place[2] ^ own[2])) == 0;
    };
    while (first_at_[slot] != kNoPoint && !coincides(first_at_[slot])) slot = (slot + 1) & mask;
    if (first_at_[slot] == kNoPoint) {
      first_at_[slot] = point;
      ++share_.all;
    } else if (placed_.differ(first_at_[slot], point)) {
      lost_.push_back(placed_.value_of(point));
    }
  }

  struct Waiting {
    uint32_t point;
    size_t slot;
  };
  const Placed& placed_;
  std::vector<uint32_t> first_at_;
  LostShare share_;
  std::vector<Values> lost_;
  std::array<Waiting, 16> waiting_{};
  size_t waiting_count_ = 0;
};

// The number of faces with an area, and how many of these have none on the grid.
LostShare flat_faces(const Placed& placed, Span<const std::array<uint32_t, 3>> faces) {
  LostShare share;
  for (const auto& face : faces) {
    if (!placed.are_stored(face)) continue;
    const auto normal = cross<int64_t>(placed[face[0]], placed[face[1]], placed[face[2]]);
    const bool is_flat = (normal[0] | normal[1] | normal[2]) == 0;
    if (is_flat && !has_area(placed, face)) continue;
    ++share.all;
    share.lost += is_flat ? 1 : 0;
  }
  return share;
}

}  // namespace

void ValueSpread::add(const Attribute& attribute, Span<const uint8_t> stored) {
  constexpr size_t kMostSampled = 1 << 13;
  const size_t count = attribute.values.size() / attribute.stride();
  const size_t step = std::max<size_t>(1, count / kMostSampled);
  components_.resize(attribute.component_count);
  size_t stored_count = 0;
  for (size_t point = 0; point < count; ++point) {
    if (!stored.empty() && stored[point] == 0) continue;
    const bool is_sampled = stored_count++ % step == 0;
    for (size_t c = 0; c < components_.size(); ++c) {
      Component& component = components_[c];
      const float value = float_at(attribute, point * components_.size() + c);
      if (component.sample.empty()) component.low = component.high = value;
      component.low = std::min(component.low, value);
      component.high = std::max(component.high, value);
      if (is_sampled) component.sample.push_back(value);
    }
  }
}

double ValueSpread::above_noise(size_t component, double extent) const {
  const Component& of = components_[component];
  const double largest = std::max(std::fabs(double{of.low}), std::fabs(double{of.high}));
  return extent > kNoise * largest ? extent : 0;
}

double ValueSpread::extent(size_t component) const {
  return above_noise(component, double{components_[component].high} - double{components_[component].low});
}

double ValueSpread::inner_extent(size_t component) const {
  constexpr size_t kTrimmed = 50;  // drops one of 50 values at each end
  std::vector<float> sample = components_[component].sample;
  if (sample.empty()) return 0;
  const auto cut = static_cast<std::ptrdiff_t>(sample.size() / kTrimmed);
  std::nth_element(sample.begin(), sample.begin() + cut, sample.end());
  const float low = sample[static_cast<size_t>(cut)];
  std::nth_element(sample.begin(), sample.end() - 1 - cut, sample.end());
  const double inner = double{*(sample.end() - 1 - cut)} - double{low};
  // The far values say nothing about the noise of the others.
  const double largest = std::max(std::fabs(double{low}), std::fabs(double{low} + inner));
  return inner > kNoise * largest ? inner : 0;
}

void GridLoss::add_positions(const Mesh& mesh, const Attribute& attribute, const AttributeCoding& grid,
                             Span<const uint8_t> stored, const ThreadPool& pool) {
  const Placed placed(attribute, grid, stored, pool);
  // The first task takes longest.
  constexpr size_t kFaces = 1 << 16;
  std::vector<LostShare> shares(1 + (mesh.faces.size() + kFaces - 1) / kFaces);
  pool.for_each(shares.size(), [&](size_t i) {
    if (i == 0) {
      shares[0] = Coinciding(placed).count();
      return;
    }
    const size_t begin = (i - 1) * kFaces;
    const size_t count = std::min(kFaces, mesh.faces.size() - begin);
    shares[i] = flat_faces(placed, Span<const std::array<uint32_t, 3>>(mesh.faces.data() + begin, count));
  });
  points += shares[0];
  for (size_t i = 1; i < shares.size(); ++i) faces += shares[i];
}

void GridLoss::add_texture_coordinates(const Mesh& mesh, const Attribute& attribute,
                                       const AttributeCoding& grid, Span<const uint8_t> stored, double scale,
                                       const ThreadPool& pool) {
  const Placed placed(attribute, grid, stored, pool);
  for (const auto& face : mesh.faces) {
    if (!placed.are_stored(face)) continue;
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t a = face[i], b = face[(i + 1) % 3];
      const bool is_equal = placed[a] == placed[b];
      if (is_equal && (a == b || !placed.differ(a, b))) continue;
      ++edges.all;
      edges.lost += is_equal ? 1 : 0;
    }
  }
  moved.all += placed.stored_count();
  if (std::ranges::all_of(grid.origin, [&](float origin) {
        return grid_bound(grid.bits, origin, grid.range) * scale <= kTextureError;
      }))
    return;
  const float step = grid.range / Placed::steps_of(grid);
  for (uint32_t point = 0; point < placed.size(); ++point) {
    if (!placed.is_stored(point)) continue;
    const Values value = placed.value_of(point);
    double off = 0, largest = 0;
    for (size_t c = 0; c < attribute.component_count; ++c) {
      const float decoded = static_cast<float>(placed[point][c]) * step + grid.origin[c];
      off = std::max(off, std::fabs(double{decoded} - double{value[c]}));
      largest = std::max(largest, std::fabs(double{value[c]}));
    }
    if (off * scale <= kTextureError || off <= kNoise * largest) continue;
    ++moved.lost;
    farthest = std::max(farthest, off * scale);
  }
}

}  // namespace psplit
