// Texture coordinates that are predicted from positions: a triangle of the texture is predicted to have the
// shape of the triangle in space. Draco bitstream specification 2.2, "texture coordinates prediction".
#pragma once

#include "src/core/predicted_values.h"
#include "src/core/prediction_data.h"

namespace psplit::core {

template <typename Index>
class TexCoordsPredictor {
 public:
  PSPLIT_HD TexCoordsPredictor(const WrappedValues<Index, 2>& on, const Positions<Index>& positions,
                               View<const uint8_t> orientations)
      : on_(on), positions_(positions), orientations_(orientations) {}

  PSPLIT_HD Fault predict() {
    for (uint32_t i = 0; i < on_.sequence.count; ++i) {
      const Index tip = on_.sequence.corner[i];
      const bool has_next = on_.rank_at(next(tip)) < i, has_previous = on_.rank_at(previous(tip)) < i;
      const int32_t* predicted = has_next ? on_.at(next(tip)) : on_.before(i);
      int32_t placed[2];
      if (has_next && has_previous) {
        bool is_placed = false;
        if (const Fault fault = place_tip(tip, placed, is_placed); fault != Fault::kNone) return fault;
        if (is_placed) predicted = placed;
      }
      on_.correct(i, predicted);
    }
    return Fault::kNone;
  }

 private:
  // Scales and turns the triangle in space so that its edge fits the edge from n to p, whose texture
  // coordinates are known. All numbers are integers: coordinates in the texture are scaled by |pn|^2 until the
  // last step.
  //
  //        tip
  //        /| `.        The foot is found along the edge. The tip is above or below it: the
  //       / |   `.      orientation says which.
  //      n--+-----p
  //       foot
  //
  // An edge without length in the texture or in space places nothing. Products of coordinates of many bits may
  // overflow. libdraco refuses some of these triangles, more of them in newer versions, and wraps around for
  // the others. So does this, as its oldest version. Edges of 2^31 steps are refused.
  PSPLIT_HD Fault place_tip(Index tip, int32_t* out, bool& is_placed) {
    constexpr uint64_t kMost = ~uint64_t{0} >> 1;
    const int32_t *n = on_.at(next(tip)), *p = on_.at(previous(tip));
    const int64_t edge_s = int64_t{p[0]} - n[0], edge_t = int64_t{p[1]} - n[1];
    if (edge_s == 0 && edge_t == 0) return Fault::kNone;
    const Vec3 n_at = positions_.at(next(tip)), pn = minus(positions_.at(previous(tip)), n_at);
    const uint64_t pn_square = dot(pn, pn);
    if (pn_square == 0) return Fault::kNone;
    const Vec3 tip_at = positions_.at(tip), cn = minus(tip_at, n_at);
    const auto along = static_cast<int64_t>(dot(pn, cn)), scale = static_cast<int64_t>(pn_square);
    const uint64_t n_most = larger(magnitude(int64_t{n[0]}), magnitude(int64_t{n[1]}));
    const uint64_t pn_most = larger(larger(magnitude(pn.x), magnitude(pn.y)), magnitude(pn.z));
    if (n_most > kMost / pn_square || along > static_cast<int64_t>(kMost / pn_most) || scale <= 0 ||
        orientations_left_ == 0)
      return Fault::kPrediction;
    const uint64_t foot_s = product(n[0], scale) + product(along, edge_s);
    const uint64_t foot_t = product(n[1], scale) + product(along, edge_t);
    const Vec3 foot{quotient(product(along, pn.x), scale), quotient(product(along, pn.y), scale),
                    quotient(product(along, pn.z), scale)};  // from n on
    const Vec3 height = minus(tip_at, plus(n_at, foot));
    const auto length = static_cast<int64_t>(integer_sqrt(dot(height, height) * pn_square));
    const bool up = orientations_[--orientations_left_] != 0;
    const uint64_t up_s = product(edge_t, length), up_t = product(-edge_s, length);
    out[0] = static_cast<int32_t>(quotient(up ? foot_s + up_s : foot_s - up_s, scale));
    out[1] = static_cast<int32_t>(quotient(up ? foot_t + up_t : foot_t - up_t, scale));
    is_placed = true;
    return Fault::kNone;
  }

  PSPLIT_HD static uint64_t larger(uint64_t a, uint64_t b) { return a > b ? a : b; }
  PSPLIT_HD static int64_t quotient(uint64_t a, int64_t b) { return static_cast<int64_t>(a) / b; }

  const WrappedValues<Index, 2>& on_;
  const Positions<Index>& positions_;
  View<const uint8_t> orientations_;
  size_t orientations_left_ = orientations_.size();
};

}  // namespace psplit::core
