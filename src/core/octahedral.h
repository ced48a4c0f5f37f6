// Unit vectors as two integers: the sphere is projected on an octahedron, which is unfolded to a square of
// 2^bits - 1 values a side. The square's inner diamond is the half with x >= 0. Its corners fold back to the
// other half.
//
// Meyer, Suessmuth, Sussner, Stamminger, Greiner: On Floating-Point Normal Vectors, 2010; Draco bitstream
// specification 2.2, "octahedral normals".
#pragma once

#include "src/core/components.h"

namespace psplit::core {

class OctahedralGrid {
 public:
  OctahedralGrid() = default;
  // `bits` from 2 to 30.
  PSPLIT_HD explicit OctahedralGrid(int bits)
      : max_quantized_((1 << bits) - 1), max_((1 << bits) - 2), center_(max_ / 2) {}

  PSPLIT_HD uint32_t max_quantized() const { return static_cast<uint32_t>(max_quantized_); }
  PSPLIT_HD int32_t center() const { return center_; }

  // Applies a correction to a predicted value. Canonicalized coding first turns the predicted value into the
  // bottom left quadrant, so that corrections of all four quadrants have the same statistics. The direction of
  // a normal is unpredictable, so there are no branches.
  PSPLIT_HD Vec2 correct(Vec2 predicted, Vec2 correction, bool canonicalized) const {
    const Vec2 place{wrapping_sub(predicted.s, center_), wrapping_sub(predicted.t, center_)};
    const uint32_t outside = mask(magnitude(place.s) + magnitude(place.t) > static_cast<uint32_t>(center_));
    const Vec2 p = select(outside, mirrored(place), place);
    const uint32_t turns = quarter_turns(p) & mask(canonicalized);
    const Vec2 canonical = turned(p, turns);
    const Vec2 value = turned(
        {folded(wrapping_add(canonical.s, correction.s)), folded(wrapping_add(canonical.t, correction.t))},
        (4 - turns) & 3);
    const Vec2 unfolded = select(outside, mirrored(value), value);
    return {wrapping_add(unfolded.s, center_), wrapping_add(unfolded.t, center_)};
  }

  // The correction that an encoder stores: the inverse of `correct`. Both components are below max_quantized().
  PSPLIT_HD Vec2 correction(Vec2 predicted, Vec2 value, bool canonicalized) const {
    const Vec2 place{wrapping_sub(predicted.s, center_), wrapping_sub(predicted.t, center_)},
        wanted{wrapping_sub(value.s, center_), wrapping_sub(value.t, center_)};
    const uint32_t outside = mask(magnitude(place.s) + magnitude(place.t) > static_cast<uint32_t>(center_));
    const Vec2 p = select(outside, mirrored(place), place);
    const uint32_t turns = quarter_turns(p) & mask(canonicalized);
    const Vec2 from = turned(p, turns), to = turned(select(outside, mirrored(wanted), wanted), turns);
    const auto positive = [this](int32_t x) { return x < 0 ? wrapping_add(x, max_quantized_) : x; };
    return {positive(wrapping_sub(to.s, from.s)), positive(wrapping_sub(to.t, from.t))};
  }

  // Where the ray along v meets the octahedron; with `flip`, the ray along -v.
  PSPLIT_HD Vec2 project(Vec3 v, bool flip) const {
    const auto sum = static_cast<int64_t>(magnitude(v.x) + magnitude(v.y) + magnitude(v.z));
    auto x = static_cast<int32_t>(sum == 0 ? center_ : v.x * center_ / sum);
    auto y = static_cast<int32_t>(sum == 0 ? 0 : v.y * center_ / sum);
    auto z =
        static_cast<int32_t>(center_ - static_cast<int32_t>(magnitude(x)) - static_cast<int32_t>(magnitude(y)));
    if (sum == 0) z = 0;
    if (v.z < 0) z = -z;
    if (flip) x = -x, y = -y, z = -z;
    return place_of(x, y, z);
  }

  // The place of a point of the octahedron: the magnitudes of its coordinates have the sum center().
  PSPLIT_HD Vec2 place_of(int32_t x, int32_t y, int32_t z) const {
    if (x >= 0) return canonical({y + center_, z + center_});
    const auto abs_y = static_cast<int32_t>(magnitude(y)), abs_z = static_cast<int32_t>(magnitude(z));
    return canonical({y < 0 ? abs_z : max_ - abs_z, z < 0 ? abs_y : max_ - abs_y});
  }

  // Writes the three components of the unit vector at a place. They equal libdraco's to the bit: no
  // multiply-add may be fused, and the root is rounded according to IEEE 754.
  PSPLIT_HD void unit_vector(Vec2 at, float* out) const {
    const float scale = 2.0f / static_cast<float>(max_);
    float y = static_cast<float>(at.s) * scale - 1.0f, z = static_cast<float>(at.t) * scale - 1.0f;
    const float x = 1.0f - (y < 0 ? -y : y) - (z < 0 ? -z : z);
    float fold = -x;
    fold = fold < 0 ? 0 : fold;  // the signs of zeros are libdraco's
    y += y < 0 ? fold : -fold;
    z += z < 0 ? fold : -fold;
    const float square = x * x + y * y + z * z;
    if (static_cast<double>(square) < 1e-6) {
      out[0] = out[1] = out[2] = 0;
      return;
    }
    const float inverse = 1.0f / square_root(square);
    out[0] = x * inverse;
    out[1] = y * inverse;
    out[2] = z * inverse;
  }

#if defined(PSPLIT_HAS_VECTORS)
  // Converts four places, each of two numbers, to unit vectors at once. The fourth numbers of the
  // results have no meaning.
  static constexpr uint32_t kAtOnce = 4;
  using Floats = float __attribute__((vector_size(16)));
  PSPLIT_ONCE_IF_SMALL void unit_vectors(const int32_t* const (&at)[kAtOnce], Floats (&out)[kAtOnce]) const {
    using Ints = int32_t __attribute__((vector_size(16)));
    using Pair = int32_t __attribute__((vector_size(8)));
    const auto choose = [](Ints mask, Floats a, Floats b) {
      return reinterpret_cast<Floats>((reinterpret_cast<Ints>(a) & mask) | (reinterpret_cast<Ints>(b) & ~mask));
    };
    const Floats zero{};
    const float scale = 2.0f / static_cast<float>(max_);
    Pair pairs[kAtOnce];
    for (uint32_t k = 0; k < kAtOnce; ++k) copy_bytes(&pairs[k], at[k], sizeof pairs[k]);
    const Ints first = __builtin_shufflevector(pairs[0], pairs[1], 0, 1, 2, 3),
               second = __builtin_shufflevector(pairs[2], pairs[3], 0, 1, 2, 3);
    Floats y =
        __builtin_convertvector(__builtin_shufflevector(first, second, 0, 2, 4, 6), Floats) * scale - 1.0f;
    Floats z =
        __builtin_convertvector(__builtin_shufflevector(first, second, 1, 3, 5, 7), Floats) * scale - 1.0f;
    const Floats x = 1.0f - choose(y < zero, -y, y) - choose(z < zero, -z, z);
    Floats fold = -x;
    fold = choose(fold < zero, zero, fold);
    y += choose(y < zero, fold, -fold);
    z += choose(z < zero, fold, -fold);
    const Floats square = x * x + y * y + z * z;
#if defined(__wasm_simd128__)
    const Floats root = square_roots(square);
#else
    Floats root{};
    for (uint32_t k = 0; k < kAtOnce; ++k) root[k] = square_root(square[k]);
#endif
    // No float is between this bound and 1e-6, which is what unit_vector compares with.
    const auto is_long = reinterpret_cast<Ints>(square > 1e-6f);
    const auto unit = [=, inverse = 1.0f / root](Floats along) {
      return reinterpret_cast<Floats>(reinterpret_cast<Ints>(along * inverse) & is_long);
    };
    const Floats ux = unit(x), uy = unit(y), uz = unit(z);
    const Floats low = __builtin_shufflevector(ux, uy, 0, 4, 1, 5),
                 high = __builtin_shufflevector(ux, uy, 2, 6, 3, 7);
    out[0] = __builtin_shufflevector(low, uz, 0, 1, 4, 4);
    out[1] = __builtin_shufflevector(low, uz, 2, 3, 5, 5);
    out[2] = __builtin_shufflevector(high, uz, 0, 1, 6, 6);
    out[3] = __builtin_shufflevector(high, uz, 2, 3, 7, 7);
  }
#endif

  // Each edge of the square is folded onto itself, and its four corners are one place: returns one name for
  // each place.
  PSPLIT_HD Vec2 canonical(Vec2 at) const {
    const auto [s, t] = at;
    if ((s == 0 && (t == 0 || t == max_)) || (s == max_ && t == 0)) return {max_, max_};
    if (s == 0 && t > center_) return {s, 2 * center_ - t};
    if (s == max_ && t < center_) return {s, 2 * center_ - t};
    if (t == max_ && s < center_) return {2 * center_ - s, t};
    if (t == 0 && s > center_) return {2 * center_ - s, t};
    return at;
  }

 private:
  PSPLIT_HD static int32_t select(uint32_t if_set, int32_t a, int32_t b) {
    return static_cast<int32_t>(core::select(if_set, static_cast<uint32_t>(a), static_cast<uint32_t>(b)));
  }
  PSPLIT_HD static Vec2 select(uint32_t if_set, Vec2 a, Vec2 b) {
    return {select(if_set, a.s, b.s), select(if_set, a.t, b.t)};
  }
  // -x if all bits of `if_set` are set, x if none is.
  PSPLIT_HD static uint32_t negated(uint32_t if_set, uint32_t x) { return (x ^ if_set) - if_set; }

  // Reflects a place, relative to the center, at the nearest edge of the diamond.
  PSPLIT_HD Vec2 mirrored(Vec2 at) const {
    const bool right = at.s > 0 || (at.s == 0 && at.t >= 0), up = at.t > 0 || (at.t == 0 && at.s >= 0);
    const auto center = static_cast<uint32_t>(center_);
    const uint32_t corner_s = negated(mask(!right), center), corner_t = negated(mask(!up), center);
    const uint32_t same = mask(right == up);
    const uint32_t s = negated(same, 2 * static_cast<uint32_t>(at.t) - corner_t) + corner_s,
                   t = negated(same, 2 * static_cast<uint32_t>(at.s) - corner_s) + corner_t;
    return {static_cast<int32_t>(s) / 2, static_cast<int32_t>(t) / 2};
  }

  // The number of quarter turns that bring a place to the bottom left quadrant.
  PSPLIT_HD static uint32_t quarter_turns(Vec2 at) {
    const uint32_t below = static_cast<uint32_t>(at.t < 0), left = static_cast<uint32_t>(at.s < 0);
    return core::select(mask(at.s > 0), 2 - below, core::select(mask(at.t > 0), 3, below & (left ^ 1)));
  }
  // Turns a place by 0, 1, 2 or 3 quarters: (s, t), (t, -s), (-s, -t), (-t, s).
  PSPLIT_HD static Vec2 turned(Vec2 at, uint32_t turns) {
    const auto s = static_cast<uint32_t>(at.s), t = static_cast<uint32_t>(at.t);
    const uint32_t is_odd = 0 - (turns & 1);
    return {static_cast<int32_t>(negated(0 - (turns >> 1), core::select(is_odd, t, s))),
            static_cast<int32_t>(negated(0 - ((turns + 1) >> 1 & 1), core::select(is_odd, s, t)))};
  }
  // Brings a sum back into the square, whose opposite sides meet.
  PSPLIT_HD int32_t folded(int32_t x) const {
    const auto range = static_cast<uint32_t>(max_quantized_);
    return static_cast<int32_t>(static_cast<uint32_t>(x) - (range & mask(x > center_)) +
                                (range & mask(x < -center_)));
  }

  int32_t max_quantized_ = 0, max_ = 0, center_ = 0;
};

}  // namespace psplit::core
