// The sources that predict the deltas of a vertex: the deltas of up to eight nearby vertices that come before
// it, each with a weight (delta_weights.h). All delta attributes of a patch share the weights. Specification:
// "deltas" (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include "src/core/attributes.h"
#include "src/core/condensed/delta_weights.h"

namespace psplit::core {

template <typename Index>
struct DeltaSources {
  Index place[kMostDeltaSources] = {};  // in the order of creation, the last one first
  DeltaWeights weights;
  uint8_t count = 0;
  uint8_t neighbours = 0;  // bit n: source n shares an edge with the vertex
};

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
  // The place of `vertex` as seen from `other`.
  PSPLIT_HD DeltaOffset offset(uint32_t vertex, uint32_t other) const {
    DeltaOffset out = {};
    if (values.empty()) return out;
    const uint32_t stride = value_stride(components);
    const int32_t *to = values.data() + size_t{vertex} * stride, *from = values.data() + size_t{other} * stride;
    if (stride == 4) {
      (Components<4>(to) - Components<4>(from)).store(out.of);
      out.of[3] = 0;
      return out;
    }
    for (uint32_t k = 0; k < components && k < 3; ++k) out.of[k] = wrapping_sub(to[k], from[k]);
    return out;
  }
};

#if defined(PSPLIT_HAS_SSE2_DELTAS)
// The latest candidates, in registers. Which ones are later is unpredictable, so nothing branches on that.
class LatestPlaces {
 public:
  static constexpr uint32_t kMostPlaces = 0x7ffe;  // in an order

  // Nothing happens without a condition. Nearly no place is added twice.
  PSPLIT_INLINE void add(uint32_t place, uint32_t is_neighbour, bool condition) {
    const auto key = static_cast<int32_t>(2 * place + is_neighbour) + kFirst;
    const __m128i keys = _mm_set1_epi16(static_cast<int16_t>(
                      select(mask(condition), static_cast<uint32_t>(key), static_cast<uint32_t>(kLeast)))),
                  one = _mm_set1_epi16(1),
                  same = _mm_cmpeq_epi16(_mm_or_si128(kept_, one), _mm_or_si128(keys, one));
    if (PSPLIT_UNLIKELY(_mm_movemask_epi8(same) != 0)) {
      kept_ = _mm_or_si128(kept_, _mm_and_si128(same, keys));
      return;
    }
    // Keys that are less move on by one.
    const __m128i before = _mm_insert_epi16(_mm_slli_si128(kept_, 2), INT16_MAX, 0);
    kept_ = _mm_max_epi16(kept_, _mm_min_epi16(before, keys));
  }
  template <typename Sources>
  void store(Sources& out) const {
    const __m128i is_some = _mm_cmpgt_epi16(kept_, _mm_set1_epi16(kNone)),
                  places =
                      _mm_and_si128(_mm_srli_epi16(_mm_sub_epi16(kept_, _mm_set1_epi16(kFirst)), 1), is_some),
                  none = _mm_setzero_si128();
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out.place), places);
    const auto bits_of = [&](__m128i of) {
      return static_cast<uint32_t>(_mm_movemask_epi8(_mm_packs_epi16(of, none)));
    };
    out.count = static_cast<uint8_t>(trailing_zeros(~bits_of(is_some)));
    out.neighbours = static_cast<uint8_t>(bits_of(_mm_and_si128(_mm_slli_epi16(kept_, 15), is_some)));
  }

 private:
  // The key of a candidate has its place, then whether it is a neighbour. No candidate: kNone; a key that
  // changes nothing: kLeast.
  static constexpr int16_t kLeast = INT16_MIN, kNone = kLeast + 2, kFirst = kNone + 2;

  __m128i kept_ = _mm_set1_epi16(kNone);  // descending
};
#endif

// Finds the sources of the vertex at place `i` of the order of creation. Sources are, of all that come before
// it, the latest: its neighbours, and the vertices across the edges of its faces that are opposite to it, where
// both ends of the edge come before it. If there are none, the vertex before it in the order.
template <typename Index>
class DeltaSourceSearch {
 public:
  PSPLIT_HD DeltaSourceSearch(const CornerTable<Index>& table, const Sequence<Index>& order, DeltaPlaces places)
      : table_(table), order_(order), places_(places) {}

  // The most vertices for which `find` takes each stage together: the steps of one vertex wait for each other.
  static constexpr uint32_t kAtOnce = PSPLIT_MOVES_ROWS ? 1 : 4;

  // Finds the sources of the vertices at places [first, first + count).
  PSPLIT_HD void find(uint32_t first, uint32_t count, DeltaSources<Index>* out) const {
    DeltaFit fits[kAtOnce];
    for (uint32_t n = 0; n < count; ++n) out[n] = list(first + n);
    for (uint32_t n = 0; n < count; ++n) fit(first + n, out[n], fits[n]);
    for (uint32_t n = 0; n < count; ++n)
      out[n].weights =
          out[n].count < 2 ? even_delta_weights(out[n].count) : weights_of_fit(fits[n], out[n].count);
  }
  PSPLIT_HD DeltaSources<Index> find(uint32_t i) const {
    DeltaSources<Index> found;
    find(i, 1, &found);
    return found;
  }

 private:
  PSPLIT_HD DeltaSources<Index> list(uint32_t i) const {
    DeltaSources<Index> found;
#if defined(PSPLIT_HAS_SSE2_DELTAS)
    if constexpr (sizeof(Index) == sizeof(int16_t)) {
      if (PSPLIT_LIKELY(order_.count <= LatestPlaces::kMostPlaces)) {
        LatestPlaces latest;
        find_candidates(i, [&](uint32_t place, uint32_t is_neighbour, bool condition) {
          latest.add(place, is_neighbour, condition);
        });
        latest.store(found);
        if (PSPLIT_UNLIKELY(found.count == 0)) add_previous(i, found);
        return found;
      }
    }
#endif
    find_candidates(i, [&](uint32_t place, uint32_t is_neighbour, bool condition) {
      if (condition) add(place, is_neighbour, found);
    });
    if (found.count == 0) add_previous(i, found);
    return found;
  }
  // Calls add(place, is_neighbour, condition) for places that are candidates if the condition holds.
  template <typename Add>
  PSPLIT_HD PSPLIT_INLINE void find_candidates(uint32_t i, Add add) const {
    // Across the edge from a to b.
    const auto add_far = [&](Index corner, uint32_t a, uint32_t b) {
      const Index across = table_.opposite[corner];
      const bool exists = across != kNone<Index>;
      const uint32_t far = place_of(static_cast<Index>(select(mask(exists), across, corner)));
      add(far, 0, exists & (a < i) & (b < i) & (far < i));
    };
    // Each face around the vertex has an edge with the one before it, so one vertex of it is new.
    const Index start = order_.corner[i];
    uint32_t a = place_of(next(start)), b = place_of(previous(start));
    add(a, 1, a < i);
    add(b, 1, b < i);
    add_far(start, a, b);
    Index corner = start;
    while ((corner = table_.swing_left(corner)) != kNone<Index> && corner != start) {
      const uint32_t shared = b;
      b = place_of(previous(corner));
      add(b, 1, b < i);
      add_far(corner, shared, b);
    }
    if (corner == kNone<Index>)
      for (corner = start; (corner = table_.swing_right(corner)) != kNone<Index>;) {
        const uint32_t shared = a;
        a = place_of(next(corner));
        add(a, 1, a < i);
        add_far(corner, a, shared);
      }
  }
  PSPLIT_HD static void add_previous(uint32_t i, DeltaSources<Index>& found) {
    if (i > 0) found.place[0] = static_cast<Index>(i - 1), found.count = found.neighbours = 1;
  }
  PSPLIT_HD uint32_t place_of(Index corner) const { return order_.rank[table_.vertex[corner]]; }
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
  PSPLIT_HD void fit(uint32_t i, const DeltaSources<Index>& found, DeltaFit& out) const {
    if (found.count < 2) return;
    const uint32_t vertex = table_.vertex[order_.corner[i]];
    DeltaOffset offsets[kMostDeltaSources] = {};
    for (uint32_t n = 0; n < found.count; ++n)
      offsets[n] = places_.offset(table_.vertex[order_.corner[found.place[n]]], vertex);
    fit_offsets(offsets, found.count, out);
  }

  const CornerTable<Index> table_;
  const Sequence<Index> order_;
  const DeltaPlaces places_;
};

}  // namespace psplit::core
