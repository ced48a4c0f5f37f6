// The sources that predict the deltas of a vertex: the deltas of up to eight nearby vertices that come before
// it, each with a weight. Deltas of morph targets vary with the place on a surface, so the weights come from a
// plane through the places of the sources, fitted by least squares: deltas that are affine in space are
// predicted exactly. All delta attributes of a patch share the weights. Specification: "deltas"
// (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include "src/core/attributes.h"
#include "src/core/condensed/models.h"
#include "src/core/integer_vectors.h"

namespace psplit::core {

inline constexpr uint32_t kDeltaComponents = 3, kMostDeltaSources = 8;
inline constexpr uint32_t kDeltaSections = 1 + kDeltaComponents;  // of a stream: flags, and corrections
// Weights are in 1 / 64, and their sum is 64.
inline constexpr int32_t kDeltaBits = 6, kDeltaOne = 1 << kDeltaBits, kMostDeltaWeight = 127;
inline constexpr uint32_t kMostDeltaSize = 255;  // of a correction, as far as levels depend on it

// The weights of the sources of a vertex. Those beyond the last source are 0.
struct alignas(16) DeltaWeights {
  int16_t of[kMostDeltaSources] = {};
};

template <typename Index>
struct DeltaSources {
  Index place[kMostDeltaSources] = {};  // in the order of creation, the last one first
  DeltaWeights weights;
  uint8_t count = 0;
  uint8_t neighbours = 0;  // bit n: source n shares an edge with the vertex
};

// Turns shares, from -2^24 to 2^24, into weights: the first of the largest shares takes the remainder to 64.
PSPLIT_HD inline DeltaWeights delta_weights(const int32_t* shares, uint32_t count) {
  DeltaWeights weights;
  int32_t total = 0;
  for (uint32_t n = 0; n < count; ++n) total += shares[n];
  int32_t sum = 0;
  uint32_t largest = 0;
  for (uint32_t n = 0; n < count; ++n) {
    const int32_t share = total > 0 ? shares[n] : 1, of = total > 0 ? total : static_cast<int32_t>(count);
    const int32_t scaled = kDeltaOne * share + of / 2;
    // Rounded down.
    const int32_t weight = scaled >= 0 ? scaled / of : -((of - 1 - scaled) / of);
    weights.of[n] = static_cast<int16_t>(weight < -kMostDeltaWeight  ? -kMostDeltaWeight
                                         : weight > kMostDeltaWeight ? kMostDeltaWeight
                                                                     : weight);
    sum += weights.of[n];
    if (weights.of[n] > weights.of[largest]) largest = n;
  }
  if (count > 0) weights.of[largest] = static_cast<int16_t>(weights.of[largest] + kDeltaOne - sum);
  return weights;
}
PSPLIT_HD inline DeltaWeights even_delta_weights(uint32_t count) {
  constexpr int32_t kOnes[kMostDeltaSources] = {1, 1, 1, 1, 1, 1, 1, 1};
  return delta_weights(kOnes, count);
}

// The weights of sources that are at `places`, seen from the vertex. Changes the places.
PSPLIT_HD inline DeltaWeights affine_delta_weights(int32_t (*places)[3], uint32_t count) {
  constexpr int32_t kMostPlace = 127;
  if (count < 2) return even_delta_weights(count);
  uint32_t largest = 0;
  for (uint32_t n = 0; n < count; ++n)
    for (uint32_t k = 0; k < 3; ++k) {
      const int32_t at = places[n][k];
      largest |= static_cast<uint32_t>(at < 0 ? ~at : at);
    }
  const uint32_t shift = largest > kMostPlace ? floor_log2(largest) - 6 : 0;
  int32_t squares[kMostDeltaSources], mean = 0;
  for (uint32_t n = 0; n < count; ++n) {
    squares[n] = 0;
    for (uint32_t k = 0; k < 3; ++k) {
      places[n][k] >>= shift;
      squares[n] += places[n][k] * places[n][k];
    }
    mean += squares[n];
  }
  mean = mean / static_cast<int32_t>(count) + 1;
  // The normal equations of the plane, where near sources count more. A small multiple of the identity keeps
  // sources on a line or a plane from having no solution.
  int32_t q[kMostDeltaSources], m[6] = {}, b[3] = {};
  m[0] = m[3] = m[5] = 3 * mean / 8 + 1;
  for (uint32_t n = 0; n < count; ++n) {
    const int32_t x = places[n][0], y = places[n][1], z = places[n][2];
    q[n] = 256 * mean / (20 * squares[n] + mean) + 1;
    m[0] += q[n] * x * x, m[1] += q[n] * x * y, m[2] += q[n] * x * z;
    m[3] += q[n] * y * y, m[4] += q[n] * y * z, m[5] += q[n] * z * z;
    b[0] += q[n] * x, b[1] += q[n] * y, b[2] += q[n] * z;
  }
  constexpr uint32_t kMatrixBits = 18;
  const uint32_t bits = floor_log2(static_cast<uint32_t>(m[0] | m[3] | m[5])) + 1,
                 down = bits > kMatrixBits ? bits - kMatrixBits : 0;
  int64_t a[6];
  for (uint32_t i = 0; i < 6; ++i) a[i] = m[i] >> down;
  ++a[0], ++a[3], ++a[5];
  // The inverse by cofactors.
  const int64_t c[6] = {a[3] * a[5] - a[4] * a[4], a[2] * a[4] - a[1] * a[5], a[1] * a[4] - a[2] * a[3],
                        a[0] * a[5] - a[2] * a[2], a[1] * a[2] - a[0] * a[4], a[0] * a[3] - a[1] * a[1]};
  const int64_t determinant = (a[0] * c[0] + a[1] * c[1] + a[2] * c[2]) >> (16 - down);
  int64_t plane[3] = {};
  if (determinant > 0) {
    const int64_t sums[3] = {c[0] * b[0] + c[1] * b[1] + c[2] * b[2], c[1] * b[0] + c[3] * b[1] + c[4] * b[2],
                             c[2] * b[0] + c[4] * b[1] + c[5] * b[2]};
    constexpr int64_t kMostSlope = int64_t{1} << 24;
    for (uint32_t k = 0; k < 3; ++k) {
      const int64_t slope = sums[k] / determinant;
      plane[k] = slope < -kMostSlope ? -kMostSlope : slope > kMostSlope ? kMostSlope : slope;
    }
  }
  int32_t shares[kMostDeltaSources];
  for (uint32_t n = 0; n < count; ++n) {
    constexpr int64_t kMostShare = int64_t{1} << 24;
    const int64_t along = plane[0] * places[n][0] + plane[1] * places[n][1] + plane[2] * places[n][2];
    const int64_t share = (q[n] * (65536 - along)) >> 6;
    shares[n] = static_cast<int32_t>(share < -kMostShare  ? -kMostShare
                                     : share > kMostShare ? kMostShare
                                                          : share);
  }
  return delta_weights(shares, count);
}

// The places of vertices on a grid: an attribute's values, of which only the first three components count.
struct DeltaPlaces {
  View<const int32_t> values;  // by vertex; if empty, all vertices are at one place
  uint32_t components = 0;

  // Only values in order of creation are places, so that deltas need none of Draco's predictions.
  template <typename Index>
  PSPLIT_HD static DeltaPlaces of(const Attribute<Index>& first, bool by_creation) {
    if (!by_creation) return {};
    return {first.values, first.value_components()};
  }
  PSPLIT_HD int32_t at(uint32_t vertex, uint32_t component) const {
    if (values.empty() || component >= components) return 0;
    return values[size_t{vertex} * value_stride(components) + component];
  }
};

// Finds the sources of the vertex at place `i` of the order of creation. Sources are, of all that come before
// it, the latest: its neighbours, and the vertices across the edges of its faces that are opposite to it, where
// both ends of the edge come before it. If there are none, the vertex before it in the order.
template <typename Index>
class DeltaSourceSearch {
 public:
  PSPLIT_HD DeltaSourceSearch(const CornerTable<Index>& table, const Sequence<Index>& order, DeltaPlaces places)
      : table_(table), order_(order), places_(places) {}

  PSPLIT_HD DeltaSources<Index> find(uint32_t i) const {
    DeltaSources<Index> found;
    const Index start = order_.corner[i];
    Index corner = start;
    do {
      add_face(corner, i, found);
      corner = table_.swing_left(corner);
    } while (corner != kNone<Index> && corner != start);
    if (corner == kNone<Index>)
      while ((corner = table_.swing_right(corner == kNone<Index> ? start : corner)) != kNone<Index>)
        add_face(corner, i, found);
    if (found.count == 0 && i > 0)
      found.place[0] = static_cast<Index>(i - 1), found.count = found.neighbours = 1;
    find_weights(i, found);
    return found;
  }

 private:
  PSPLIT_HD void add_face(Index corner, uint32_t i, DeltaSources<Index>& found) const {
    const uint32_t a = order_.rank[table_.vertex[next(corner)]],
                   b = order_.rank[table_.vertex[previous(corner)]];
    if (a < i) add(a, 1, found);
    if (b < i) add(b, 1, found);
    const Index across = table_.opposite[corner];
    if (a >= i || b >= i || across == kNone<Index>) return;
    const uint32_t far = order_.rank[table_.vertex[across]];
    if (far < i) add(far, 0, found);
  }
  // Keeps the latest ones, in descending order.
  PSPLIT_HD static void add(uint32_t place, uint32_t is_neighbour, DeltaSources<Index>& found) {
    uint32_t n = found.count;
    while (n > 0 && found.place[n - 1] < place) --n;
    if (n > 0 && found.place[n - 1] == place) {
      found.neighbours = static_cast<uint8_t>(found.neighbours | is_neighbour << (n - 1));
      return;
    }
    if (n == kMostDeltaSources) return;
    if (found.count < kMostDeltaSources) ++found.count;
    for (uint32_t k = found.count - 1; k > n; --k) found.place[k] = found.place[k - 1];
    found.place[n] = static_cast<Index>(place);
    const uint32_t before = found.neighbours & ((1u << n) - 1), behind = found.neighbours & ~((1u << n) - 1);
    found.neighbours = static_cast<uint8_t>(before | is_neighbour << n | behind << 1);
  }
  PSPLIT_HD void find_weights(uint32_t i, DeltaSources<Index>& found) const {
    const uint32_t vertex = table_.vertex[order_.corner[i]];
    int32_t places[kMostDeltaSources][3];
    for (uint32_t n = 0; n < found.count; ++n) {
      const uint32_t source = table_.vertex[order_.corner[found.place[n]]];
      for (uint32_t k = 0; k < 3; ++k)
        places[n][k] = wrapping_sub(places_.at(source, k), places_.at(vertex, k));
    }
    found.weights = affine_delta_weights(places, found.count);
  }

  const CornerTable<Index> table_;
  const Sequence<Index> order_;
  const DeltaPlaces places_;
};

}  // namespace psplit::core
