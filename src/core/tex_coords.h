// Texture coordinates that are predicted from positions: a triangle of the texture is predicted to have the
// shape of the triangle in space. Draco bitstream specification 2.2, "texture coordinates prediction".
#pragma once

#include "src/core/predicted_values.h"
#include "src/core/prediction_data.h"

namespace psplit::core {

// The two places in the texture where the tip of a triangle may be, on both sides of the edge from n to p whose
// texture coordinates are known. The triangle in space is scaled and turned so that its edge fits. All numbers
// are integers: coordinates in the texture are scaled by |pn|^2 until the last step.
//
//        tip
//        /| `.        The foot is found along the edge. The tip is above or below it: the
//       / |   `.      orientation says which.
//      n--+-----p
//       foot
//
// An edge without length in the texture or in space places nothing. Products of coordinates of many bits may
// overflow. libdraco refuses some of these triangles, more of them in newer versions, and wraps around for the
// others. So does this, as its oldest version. Edges of 2^31 steps are refused.
class TipPlaces {
 public:
  // Sets is_placed if there are places. n and p are texture coordinates, at(corner) a position.
  template <typename Index, typename At>
  PSPLIT_HD Fault find(Index tip, const int32_t* n, const int32_t* p, At at, bool& is_placed) {
    const int64_t edge_s = int64_t{p[0]} - n[0], edge_t = int64_t{p[1]} - n[1];
    if (edge_s == 0 && edge_t == 0) return Fault::kNone;
    const Vec3 n_at = at(next(tip)), pn = minus(at(previous(tip)), n_at);
    const uint64_t pn_square = dot(pn, pn);
    if (pn_square == 0) return Fault::kNone;
    const Vec3 tip_at = at(tip), cn = minus(tip_at, n_at);
    const auto along = static_cast<int64_t>(dot(pn, cn));
    scale_ = static_cast<int64_t>(pn_square);
    const uint64_t n_most = larger(magnitude(int64_t{n[0]}), magnitude(int64_t{n[1]}));
    const uint64_t pn_most = larger(larger(magnitude(pn.x), magnitude(pn.y)), magnitude(pn.z));
    if (is_too_large(n_most, pn_square) || scale_ <= 0 ||
        (along > 0 && is_too_large(static_cast<uint64_t>(along), pn_most)))
      return Fault::kPrediction;
    foot_s_ = product(n[0], scale_) + product(along, edge_s);
    foot_t_ = product(n[1], scale_) + product(along, edge_t);
    const Vec3 foot{quotient(product(along, pn.x)), quotient(product(along, pn.y)),
                    quotient(product(along, pn.z))};  // from n on
    const Vec3 height = minus(tip_at, plus(n_at, foot));
    const auto length = static_cast<int64_t>(integer_sqrt(dot(height, height) * pn_square));
    up_s_ = product(edge_t, length);
    up_t_ = product(-edge_s, length);
    is_placed = true;
    return Fault::kNone;
  }

  PSPLIT_HD void place(bool up, int64_t& s, int64_t& t) const {
    s = quotient(up ? foot_s_ + up_s_ : foot_s_ - up_s_);
    t = quotient(up ? foot_t_ + up_t_ : foot_t_ - up_t_);
  }

 private:
  PSPLIT_HD static uint64_t larger(uint64_t a, uint64_t b) { return a > b ? a : b; }
  // Whether a product, of which `b` is not 0, has more than 63 bits. Nearly all products are of small numbers,
  // and a division takes long.
  PSPLIT_HD static bool is_too_large(uint64_t a, uint64_t b) {
    return (a | b) >> 31 != 0 && a > (~uint64_t{0} >> 1) / b;
  }
  PSPLIT_HD int64_t quotient(uint64_t a) const { return static_cast<int64_t>(a) / scale_; }

  int64_t scale_ = 1;
  uint64_t foot_s_ = 0, foot_t_ = 0, up_s_ = 0, up_t_ = 0;
};

// Finds the places of texture coordinate i if both other values of its triangle are known. `otherwise` is what
// predicts it if there are no places: the value at the next corner, or the value before.
template <typename Index>
PSPLIT_HD inline Fault find_texture_places(const PredictedValues<Index, 2>& on,
                                           const Positions<Index>& positions, uint32_t i, TipPlaces& places,
                                           bool& is_placed, const int32_t*& otherwise) {
  const Index tip = on.sequence.corner[i];
  const bool has_next = on.rank_at(next(tip)) < i, has_previous = on.rank_at(previous(tip)) < i;
  otherwise = has_next ? on.at(next(tip)) : on.before(i);
  if (!has_next || !has_previous) return Fault::kNone;
  return places.find(
      tip, on.at(next(tip)), on.at(previous(tip)), [&](Index corner) { return positions.at(corner); },
      is_placed);
}

template <typename Index>
class TexCoordsPredictor {
 public:
  PSPLIT_HD TexCoordsPredictor(const WrappedValues<Index, 2>& on, const Positions<Index>& positions,
                               View<const uint8_t> orientations)
      : on_(on), positions_(positions), orientations_(orientations) {}

  PSPLIT_HD Fault predict() {
    for (uint32_t i = 0; i < on_.sequence.count; ++i) {
      TipPlaces places;
      bool is_placed = false;
      const int32_t* predicted = nullptr;
      if (const Fault fault = find_texture_places(on_, positions_, i, places, is_placed, predicted);
          fault != Fault::kNone)
        return fault;
      int32_t placed[2];
      if (is_placed) {
        if (orientations_left_ == 0) return Fault::kPrediction;
        int64_t s = 0, t = 0;
        places.place(orientations_[--orientations_left_] != 0, s, t);
        placed[0] = static_cast<int32_t>(s), placed[1] = static_cast<int32_t>(t);
        predicted = placed;
      }
      on_.correct(i, predicted);
    }
    return Fault::kNone;
  }

 private:
  const WrappedValues<Index, 2>& on_;
  const Positions<Index>& positions_;
  View<const uint8_t> orientations_;
  size_t orientations_left_ = orientations_.size();
};

}  // namespace psplit::core
