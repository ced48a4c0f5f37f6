// Normals by difference: each place on an octahedral grid (octahedral.h) is predicted to be the same as the one
// before it. The steps of a chain wait for each other, so this computes no more than they need.
#pragma once

#include "src/core/octahedral.h"

namespace psplit::core {

// Computes the same places as OctahedralGrid::correct, for corrections in range: their magnitudes are below
// max_quantized(), as an encoder writes them. Int is int32_t, or a vector of them for several chains at once.
//
// A place is kept as its mirror image inside the diamond, and as whether it is beyond the diamond itself. A
// correction is added inside. Turning commutes with the fold of sums, which treats all four sides alike: so the
// correction is turned back, instead of the place there and back. A sum may be outside the diamond again: then
// its mirror image is inside, and the place is on the other side than the one before.
template <typename Int>
class OctahedralChain {
 public:
  OctahedralChain() = default;
  // Starts at the corner (0, 0) of the square, whose mirror image is the center.
  PSPLIT_HD OctahedralChain(const OctahedralGrid& grid, bool canonicalized)
      : center_(Int{} + static_cast<int32_t>(grid.max_quantized() / 2)),
        beyond_(~Int{}),
        canonicalized_(Int{} - static_cast<int32_t>(canonicalized)) {}

  // Goes on from where a ray meets the octahedron at x and y; is_back says that z is negative, and flip that
  // the ray points the other way. Both are masks.
  PSPLIT_HD void start_at(Int x, Int y, Int is_back, Int flip) {
    const Int z = center_ - negated(sign(x), x) - negated(sign(y), y);
    s_ = negated(flip, y);
    t_ = negated(flip ^ is_back, z);
    beyond_ = sign(negated(flip, x));
  }

  // Takes the next correction, and returns the next place in its stead.
  PSPLIT_HD PSPLIT_INLINE void step(Int& s, Int& t) {
    // The number of quarter turns that would bring the place to the bottom left quadrant, as the masks that
    // turn a correction back.
    const Int left = sign(s_), right = sign(-s_), below = sign(t_), above = sign(-t_);
    const Int is_odd = ((below & ~left) | (above & ~right)) & canonicalized_;
    const Int a = negated(choose(below, ~left, right) & canonicalized_, choose(is_odd, t, s));
    const Int b = negated(choose(right, ~below, above) & canonicalized_, choose(is_odd, s, t));
    const Int at_s = folded(s_ + a), at_t = folded(t_ + b);

    const Int is_left = sign(2 * at_s + sign(at_t)), is_below = sign(2 * at_t + sign(at_s));
    const Int same = ~(is_left ^ is_below);
    const Int mirrored_s = negated(is_left, center_) + negated(same, at_t);
    const Int mirrored_t = negated(is_below, center_) + negated(same, at_s);
    s = choose(beyond_, mirrored_s, at_s) + center_;
    t = choose(beyond_, mirrored_t, at_t) + center_;

    const Int excess = negated(sign(at_s), at_s) + negated(sign(at_t), at_t) - center_;
    const Int is_outside = sign(-excess);
    beyond_ = sign(negated(~beyond_, excess));
    s_ = choose(is_outside, mirrored_s, at_s);
    t_ = choose(is_outside, mirrored_t, at_t);
  }

  // Copies the chain of one lane of a vector.
  void set(uint32_t lane, const OctahedralChain<int32_t>& one) {
    center_[lane] = one.center_, s_[lane] = one.s_, t_[lane] = one.t_;
    beyond_[lane] = one.beyond_, canonicalized_[lane] = one.canonicalized_;
  }
  OctahedralChain<int32_t> get(uint32_t lane) const {
    OctahedralChain<int32_t> one;
    one.center_ = center_[lane], one.s_ = s_[lane], one.t_ = t_[lane];
    one.beyond_ = beyond_[lane], one.canonicalized_ = canonicalized_[lane];
    return one;
  }

 private:
  template <typename Other>
  friend class OctahedralChain;

  // All ones for a negative number, otherwise 0.
  PSPLIT_HD static Int sign(Int x) { return x >> 31; }
  PSPLIT_HD static Int choose(Int mask, Int a, Int b) { return b ^ ((a ^ b) & mask); }
  PSPLIT_HD static Int negated(Int mask, Int x) { return (x ^ mask) - mask; }
  // Brings a sum back into the square, whose opposite sides meet.
  PSPLIT_HD Int folded(Int x) const {
    const Int range = 2 * center_ + 1;
    return x - (range & sign(center_ - x)) + (range & sign(x + center_));
  }

  Int center_{};
  Int s_{}, t_{};        // from the center on, inside the diamond
  Int beyond_{};         // a mask: whether the place is on the other side
  Int canonicalized_{};  // a mask
};

// Whether OctahedralChain may take a correction.
PSPLIT_HD inline bool is_in_range(const OctahedralGrid& grid, int32_t correction) {
  return magnitude(correction) < grid.max_quantized();
}

}  // namespace psplit::core
