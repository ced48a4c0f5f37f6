// The weights of the sources that predict the deltas of a vertex. Deltas of morph targets vary with the place
// on a surface, so the weights come from a plane through the places of the sources, fitted by least squares:
// deltas that are affine in space are predicted exactly. Specification: "deltas"
// (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include "src/core/components.h"
#include "src/core/condensed/models.h"

#if defined(PSPLIT_HAS_VECTORS) && defined(__SSE2__) && !defined(__CUDACC__)
#define PSPLIT_HAS_SSE2_DELTAS 1
#include <emmintrin.h>
#endif

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

// A place on a grid, as seen from another one. The fourth number means nothing.
struct alignas(16) DeltaOffset {
  int32_t of[4];
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

// The offsets of up to eight sources, shifted right alike until all are from -128 to 127, and what follows from
// them: how much each source counts, q, and the normal equations of the plane, without the diagonal's constant.
struct DeltaFit {
  int32_t q[kMostDeltaSources], mean = 0;
  int32_t m[6] = {}, b[3] = {};
  int16_t places[3][kMostDeltaSources];  // by component
};
PSPLIT_HD inline uint32_t delta_shift(uint32_t largest) {
  constexpr uint32_t kMostPlace = 127;
  return largest > kMostPlace ? floor_log2(largest) - 6 : 0;
}
PSPLIT_HD inline void fit_plainly(const DeltaOffset* offsets, uint32_t count, DeltaFit& fit) {
  uint32_t largest = 0;
  for (uint32_t n = 0; n < count; ++n)
    for (uint32_t k = 0; k < 3; ++k) {
      const int32_t at = offsets[n].of[k];
      largest |= static_cast<uint32_t>(at < 0 ? ~at : at);
    }
  const uint32_t shift = delta_shift(largest);
  int32_t squares[kMostDeltaSources];
  for (uint32_t n = 0; n < count; ++n) {
    squares[n] = 0;
    for (uint32_t k = 0; k < 3; ++k) {
      const int32_t place = offsets[n].of[k] >> shift;
      fit.places[k][n] = static_cast<int16_t>(place);
      squares[n] += place * place;
    }
    fit.mean += squares[n];
  }
  fit.mean = fit.mean / static_cast<int32_t>(count) + 1;
  for (uint32_t n = 0; n < count; ++n) {
    const int32_t x = fit.places[0][n], y = fit.places[1][n], z = fit.places[2][n];
    const int32_t q = fit.q[n] = 256 * fit.mean / (20 * squares[n] + fit.mean) + 1;
    fit.m[0] += q * x * x, fit.m[1] += q * x * y, fit.m[2] += q * x * z;
    fit.m[3] += q * y * y, fit.m[4] += q * y * z, fit.m[5] += q * z * z;
    fit.b[0] += q * x, fit.b[1] += q * y, fit.b[2] += q * z;
  }
}

#if defined(PSPLIT_HAS_SSE2_DELTAS)
// The sums of four vectors.
PSPLIT_INLINE __m128i sums_of(__m128i a, __m128i b, __m128i c, __m128i d) {
  const __m128i ab = _mm_add_epi32(_mm_unpacklo_epi32(a, b), _mm_unpackhi_epi32(a, b)),
                cd = _mm_add_epi32(_mm_unpacklo_epi32(c, d), _mm_unpackhi_epi32(c, d));
  return _mm_add_epi32(_mm_unpacklo_epi64(ab, cd), _mm_unpackhi_epi64(ab, cd));
}
// All sources at once. Offsets beyond the last source are 0.
inline void fit_at_once(const DeltaOffset* offsets, uint32_t count, DeltaFit& fit) {
  __m128i at[kMostDeltaSources], largest = _mm_setzero_si128();
  PSPLIT_UNROLL
  for (uint32_t n = 0; n < kMostDeltaSources; ++n) {
    at[n] = _mm_load_si128(reinterpret_cast<const __m128i*>(&offsets[n]));
    largest = _mm_or_si128(largest, _mm_xor_si128(at[n], _mm_srai_epi32(at[n], 31)));
  }
  largest = _mm_or_si128(largest, _mm_or_si128(_mm_shuffle_epi32(largest, 1), _mm_shuffle_epi32(largest, 2)));
  const __m128i shift =
      _mm_cvtsi32_si128(static_cast<int>(delta_shift(static_cast<uint32_t>(_mm_cvtsi128_si32(largest)))));
  __m128i pairs[kMostDeltaSources / 2];
  PSPLIT_UNROLL
  for (uint32_t n = 0; n < kMostDeltaSources; n += 2)
    pairs[n / 2] = _mm_packs_epi32(_mm_sra_epi32(at[n], shift), _mm_sra_epi32(at[n + 1], shift));
  // Transposes rows of sources to rows of components.
  const __m128i even = _mm_unpacklo_epi16(pairs[0], pairs[1]), odd = _mm_unpackhi_epi16(pairs[0], pairs[1]),
                late_even = _mm_unpacklo_epi16(pairs[2], pairs[3]),
                late_odd = _mm_unpackhi_epi16(pairs[2], pairs[3]), xy = _mm_unpacklo_epi16(even, odd),
                late_xy = _mm_unpacklo_epi16(late_even, late_odd), x = _mm_unpacklo_epi64(xy, late_xy),
                y = _mm_unpackhi_epi64(xy, late_xy),
                z = _mm_unpacklo_epi64(_mm_unpackhi_epi16(even, odd), _mm_unpackhi_epi16(late_even, late_odd));
  const __m128i none = _mm_setzero_si128();
  const auto squares_of = [](__m128i xy_of, __m128i z_of) {
    return _mm_add_epi32(_mm_madd_epi16(xy_of, xy_of), _mm_madd_epi16(z_of, z_of));
  };
  const __m128i squares = squares_of(_mm_unpacklo_epi16(x, y), _mm_unpacklo_epi16(z, none)),
                late_squares = squares_of(_mm_unpackhi_epi16(x, y), _mm_unpackhi_epi16(z, none));
  const __m128i sum = _mm_add_epi32(squares, late_squares);
  fit.mean = _mm_cvtsi128_si32(sums_of(sum, sum, sum, sum)) / static_cast<int32_t>(count) + 1;
  // Both numbers of the quotient are below 2^24, so no float of a quotient reaches the next integer.
  const __m128 mean = _mm_set1_ps(static_cast<float>(fit.mean)), above = _mm_mul_ps(mean, _mm_set1_ps(256));
  const auto quotients = [&](__m128i of) {
    const __m128 below = _mm_add_ps(_mm_mul_ps(_mm_cvtepi32_ps(of), _mm_set1_ps(20)), mean);
    return _mm_add_epi32(_mm_cvttps_epi32(_mm_div_ps(above, below)), _mm_set1_epi32(1));
  };
  const __m128i q = quotients(squares), late_q = quotients(late_squares);
  // A q is at most 257, and its product with a place less than 2^13.
  const __m128i narrow_q = _mm_packs_epi32(q, late_q), qx = _mm_mullo_epi16(narrow_q, x),
                qy = _mm_mullo_epi16(narrow_q, y), qz = _mm_mullo_epi16(narrow_q, z), one = _mm_set1_epi16(1);
  const auto store = [](void* to, __m128i from) { _mm_storeu_si128(static_cast<__m128i*>(to), from); };
  store(&fit.m[0],
        sums_of(_mm_madd_epi16(qx, x), _mm_madd_epi16(qx, y), _mm_madd_epi16(qx, z), _mm_madd_epi16(qy, y)));
  int32_t rest[4];
  store(rest, sums_of(_mm_madd_epi16(qy, z), _mm_madd_epi16(qz, z), _mm_madd_epi16(qx, one),
                      _mm_madd_epi16(qy, one)));
  fit.m[4] = rest[0], fit.m[5] = rest[1], fit.b[0] = rest[2], fit.b[1] = rest[3];
  const __m128i last = _mm_madd_epi16(qz, one);
  fit.b[2] = _mm_cvtsi128_si32(sums_of(last, last, last, last));
  store(&fit.q[0], q), store(&fit.q[4], late_q);
  store(fit.places[0], x), store(fit.places[1], y), store(fit.places[2], z);
}
#endif

// The slopes of 1 - the plane that is 1 at the vertex, along the three axes.
struct DeltaPlane {
  int64_t of[3] = {};
};
PSPLIT_HD inline DeltaPlane delta_plane(const DeltaFit& fit) {
  int32_t m[6];
  copy_bytes(m, fit.m, sizeof m);
  // A small multiple of the identity keeps sources on a line or a plane from having no solution.
  const int32_t small = 3 * fit.mean / 8 + 1;
  m[0] += small, m[3] += small, m[5] += small;
  const int32_t* const b = fit.b;
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
  DeltaPlane plane;
  if (determinant > 0) {
    const int64_t sums[3] = {c[0] * b[0] + c[1] * b[1] + c[2] * b[2], c[1] * b[0] + c[3] * b[1] + c[4] * b[2],
                             c[2] * b[0] + c[4] * b[1] + c[5] * b[2]};
    constexpr int64_t kMostSlope = int64_t{1} << 24;
    for (uint32_t k = 0; k < 3; ++k) {
      const int64_t slope = sums[k] / determinant;
      plane.of[k] = slope < -kMostSlope ? -kMostSlope : slope > kMostSlope ? kMostSlope : slope;
    }
  }
  return plane;
}
inline constexpr int32_t kMostShare = 1 << 24;
PSPLIT_HD inline DeltaWeights delta_weights(const DeltaFit& fit, const DeltaPlane& plane, uint32_t count) {
  int32_t shares[kMostDeltaSources];
  for (uint32_t n = 0; n < count; ++n) {
    const int64_t along =
        plane.of[0] * fit.places[0][n] + plane.of[1] * fit.places[1][n] + plane.of[2] * fit.places[2][n];
    const int64_t share = (fit.q[n] * (65536 - along)) >> 6;
    shares[n] = static_cast<int32_t>(share < -kMostShare  ? -kMostShare
                                     : share > kMostShare ? kMostShare
                                                          : share);
  }
  return delta_weights(shares, count);
}
#if defined(PSPLIT_HAS_SSE2_DELTAS)
// All sources at once, with doubles. These are exact below 2^53; a quotient is rounded, but never to the next
// integer, because it is less than 128 where it matters, and the divisor less than 2^28.
inline DeltaWeights delta_weights_at_once(const DeltaFit& fit, const DeltaPlane& plane, uint32_t count) {
  const auto load = [](const void* from) { return _mm_loadu_si128(static_cast<const __m128i*>(from)); };
  const auto limited = [](__m128d x, double most) {
    return _mm_max_pd(_mm_min_pd(x, _mm_set1_pd(most)), _mm_set1_pd(-most));
  };
  // Integers below `most`, rounded down.
  const auto floors = [](__m128d low, __m128d high, int32_t most) {
    const __m128d above = _mm_set1_pd(most);
    return _mm_sub_epi32(
        _mm_unpacklo_epi64(_mm_cvttpd_epi32(_mm_add_pd(low, above)), _mm_cvttpd_epi32(_mm_add_pd(high, above))),
        _mm_set1_epi32(most));
  };
  __m128d slopes[3];
  for (uint32_t k = 0; k < 3; ++k) slopes[k] = _mm_set1_pd(static_cast<double>(plane.of[k]));
  __m128i places[3][2];
  for (uint32_t k = 0; k < 3; ++k) {
    const __m128i narrow = load(fit.places[k]);
    places[k][0] = _mm_srai_epi32(_mm_unpacklo_epi16(narrow, narrow), 16);
    places[k][1] = _mm_srai_epi32(_mm_unpackhi_epi16(narrow, narrow), 16);
  }
  const __m128i sources = _mm_set1_epi32(static_cast<int>(count));
  __m128i shares[2];
  PSPLIT_UNROLL
  for (uint32_t half = 0; half < 2; ++half) {
    const auto share_of = [&](__m128i x, __m128i y, __m128i z, __m128i q) {
      const __m128d along = _mm_add_pd(
          _mm_add_pd(_mm_mul_pd(_mm_cvtepi32_pd(x), slopes[0]), _mm_mul_pd(_mm_cvtepi32_pd(y), slopes[1])),
          _mm_mul_pd(_mm_cvtepi32_pd(z), slopes[2]));
      return limited(_mm_mul_pd(_mm_mul_pd(_mm_cvtepi32_pd(q), _mm_sub_pd(_mm_set1_pd(65536), along)),
                                _mm_set1_pd(1.0 / 64)),
                     kMostShare);
    };
    const auto second = [](__m128i four) { return _mm_unpackhi_epi64(four, four); };
    const __m128i x = places[0][half], y = places[1][half], z = places[2][half], q = load(&fit.q[4 * half]);
    const __m128i number =
        _mm_add_epi32(_mm_set1_epi32(static_cast<int>(4 * half)), _mm_setr_epi32(0, 1, 2, 3));
    shares[half] = _mm_and_si128(
        floors(share_of(x, y, z, q), share_of(second(x), second(y), second(z), second(q)), 2 * kMostShare),
        _mm_cmplt_epi32(number, sources));
  }
  const __m128i sum = _mm_add_epi32(shares[0], shares[1]);
  const int32_t total = _mm_cvtsi128_si32(sums_of(sum, sum, sum, sum));
  if (PSPLIT_UNLIKELY(total <= 0)) return even_delta_weights(count);
  const __m128d of = _mm_set1_pd(total), half_of = _mm_set1_pd(total / 2);
  __m128i weights[2];
  PSPLIT_UNROLL
  for (uint32_t half = 0; half < 2; ++half) {
    const auto weight_of = [&](__m128i share) {
      const __m128d scaled = _mm_add_pd(_mm_mul_pd(_mm_cvtepi32_pd(share), _mm_set1_pd(kDeltaOne)), half_of);
      return limited(_mm_div_pd(scaled, of), kMostDeltaWeight + 1);
    };
    weights[half] = floors(weight_of(shares[half]), weight_of(_mm_unpackhi_epi64(shares[half], shares[half])),
                           2 * (kMostDeltaWeight + 1));
  }
  const __m128i narrow =
      _mm_max_epi16(_mm_min_epi16(_mm_packs_epi32(weights[0], weights[1]), _mm_set1_epi16(kMostDeltaWeight)),
                    _mm_set1_epi16(-kMostDeltaWeight));
  __m128i largest = _mm_max_epi16(narrow, _mm_unpackhi_epi64(narrow, narrow));
  largest = _mm_max_epi16(largest, _mm_shufflelo_epi16(largest, 0x4e));
  largest = _mm_max_epi16(largest, _mm_shufflelo_epi16(largest, 0xb1));
  largest = _mm_unpacklo_epi64(_mm_shufflelo_epi16(largest, 0), _mm_shufflelo_epi16(largest, 0));
  const auto is_largest = static_cast<uint32_t>(_mm_movemask_epi8(_mm_cmpeq_epi16(narrow, largest)));
  const __m128i pairs = _mm_madd_epi16(narrow, _mm_set1_epi16(1));
  DeltaWeights out;
  _mm_store_si128(reinterpret_cast<__m128i*>(&out), narrow);
  int16_t& first = out.of[trailing_zeros(is_largest) / 2];
  first = static_cast<int16_t>(first + kDeltaOne - _mm_cvtsi128_si32(sums_of(pairs, pairs, pairs, pairs)));
  return out;
}
#endif

// The weights of sources with these offsets from the vertex come from the fit. There are places for eight
// offsets; those beyond the last source are 0.
PSPLIT_HD inline void fit_offsets(const DeltaOffset* offsets, uint32_t count, DeltaFit& fit) {
#if defined(PSPLIT_HAS_SSE2_DELTAS)
  fit_at_once(offsets, count, fit);
#else
  fit_plainly(offsets, count, fit);
#endif
}
PSPLIT_HD inline DeltaWeights weights_of_fit(const DeltaFit& fit, uint32_t count) {
#if defined(PSPLIT_HAS_SSE2_DELTAS)
  return delta_weights_at_once(fit, delta_plane(fit), count);
#else
  return delta_weights(fit, delta_plane(fit), count);
#endif
}
PSPLIT_HD inline DeltaWeights affine_delta_weights(const DeltaOffset* offsets, uint32_t count) {
  if (count < 2) return even_delta_weights(count);
  DeltaFit fit;
  fit_offsets(offsets, count, fit);
  return weights_of_fit(fit, count);
}

}  // namespace psplit::core
