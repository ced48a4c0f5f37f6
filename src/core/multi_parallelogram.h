// Prediction by several parallelograms: the mean of those around a value's vertex.
//
// D. Cohen-Or, R. Cohen, R. Irony: Multi-way Geometry Encoding, 2002. Draco bitstream specification 2.2,
// "multi-parallelogram prediction" and "constrained multi-parallelogram prediction".
#pragma once

#include "src/core/in_step.h"
#include "src/core/parallelogram.h"
#include "src/core/prediction_data.h"

namespace psplit::core {

// Finds, for each value of a sequence, the parallelograms that predict it, at most kMaxParallelograms. They are
// in their order around the value's vertex: to the left from the corner at which the traversal met the vertex,
// then to the right from there. The search depends on the order of values only, not on the values, so several
// searches run in step.
template <typename Index>
class ParallelogramFinder {
 public:
  PSPLIT_HD Fault find(const CornerTable<Index>& table, const Sequence<Index>& sequence, Arena& arena) {
    const auto face_count = static_cast<uint32_t>(table.opposite.size() / 4);
    if (!arena.take(found_, sequence.count) ||
        !arena.take(across_, uint64_t{kMaxParallelograms} * sequence.count))
      return Fault::kWorkspace;
    fill(across_, Index{0});
    const size_t mark = arena.mark();
    FaceValues<Index, Index> complete_at;  // the rank of the last of a face's values
    if (!complete_at.take(face_count, arena)) return Fault::kWorkspace;
    complete_at.of_none() = kNone<Index>;  // a face that does not exist is never complete
    const auto rank_at = [&](uint32_t corner) -> uint32_t { return sequence.rank[table.vertex[corner]]; };
    for (uint32_t corner = 0; corner < 4 * face_count; corner += 4) {
      const uint32_t a = rank_at(corner), b = rank_at(corner + 1), c = rank_at(corner + 2);
      const uint32_t ab = select(mask(a > b), a, b);
      complete_at.of_face(corner) = static_cast<Index>(select(mask(ab > c), ab, c));
    }
    search({table, sequence.corner, complete_at, found_, across_}, sequence.count);
    arena.release(mark);
    return Fault::kNone;
  }
  // The memory that `find` takes.
  PSPLIT_HD static constexpr size_t bytes(uint32_t face_count, uint64_t value_count) {
    return Arena::bytes<uint8_t>(value_count) + Arena::bytes<Index>(kMaxParallelograms * value_count) +
           FaceValues<Index, Index>::bytes(face_count);
  }

  PSPLIT_HD uint32_t count(uint32_t i) const { return found_[i]; }
  // The far corner of value i's j-th parallelogram; any corner if j is not below count(i).
  PSPLIT_HD Index across(uint32_t i, uint32_t j) const { return across_[size_t{kMaxParallelograms} * i + j]; }

 private:
  // The state of one search, which is for values [i, end).
  struct Search {
    uint32_t i = 0, end = 0, start = 0, corner = 0, found = 0;
  };

  // What all searches share.
  struct Fans {
    CornerTable<Index> table;
    View<const Index> corners;
    FaceValues<Index, Index> complete_at;
    View<uint8_t> found_at;
    View<Index> across_at;

    // Looks at one corner. Where a fan ends is unpredictable, so the only branch is the one at borders. Returns
    // whether the search goes on.
    PSPLIT_HD bool step(Search& at) const {
      look(at, at.corner);
      const uint32_t beyond = table.opposite[next(at.corner)], following = next(beyond);
      uint32_t done = at.found >> 2 | static_cast<uint32_t>(following == at.start);
      if (PSPLIT_UNLIKELY(beyond == kNone<Index>)) {
        for (Index right = static_cast<Index>(at.start); at.found < kMaxParallelograms;) {
          right = table.swing_right(right);
          if (right == kNone<Index>) break;
          look(at, right);
        }
        done = 1;
      }
      found_at[at.i] = static_cast<uint8_t>(at.found);
      at.i += done;
      // A sequence has one corner more than values.
      const uint32_t if_done = 0 - done, fresh = corners[at.i];
      if constexpr (sizeof(Index) == 4) {
        const uint32_t soon = corners[at.i + 16 < corners.size() ? at.i + 16 : at.i];
        PSPLIT_PREFETCH(&table.opposite[soon]);
      }
      at.corner = select(if_done, fresh, following);
      at.start = select(if_done, fresh, at.start);
      at.found &= ~if_done;
      return at.i < at.end;
    }

    PSPLIT_HD void look(Search& at, uint32_t corner) const {
      static_assert(kMaxParallelograms == 4);
      const ptrdiff_t across = FaceValues<Index, Index>::as_signed(table.opposite[corner]);
      const bool complete = complete_at.at_signed(across) < at.i;
      // Any corner will do if there is no parallelogram.
      across_at[size_t{4} * at.i + at.found] =
          static_cast<Index>(select(mask(complete), static_cast<uint32_t>(across), at.start));
      at.found += complete;
    }
  };

  // Each search has an equal part of the sequence, and looks at one corner in turn. `fans` is a copy, which the
  // loop may keep in registers.
  PSPLIT_HD static void search(Fans fans, uint32_t value_count) {
    Search searches[kInStep];
    bool all = true;
    for (uint32_t n = 0; n < kInStep; ++n) {
      Search& at = searches[n];
      at.i = static_cast<uint32_t>(uint64_t{value_count} * n / kInStep);
      at.end = static_cast<uint32_t>(uint64_t{value_count} * (n + 1) / kInStep);
      if (at.i < at.end) at.start = at.corner = fans.corners[at.i];
      all &= at.i < at.end;
    }
    while (all) {
      PSPLIT_UNROLL
      for (Search& at : searches) all &= fans.step(at);
    }
    for (Search& at : searches)
      while (at.i < at.end) fans.step(at);
  }

  View<uint8_t> found_;
  View<Index> across_;
};

// A value is the mean of the parallelograms at all corners of its vertex, clockwise. libdraco decodes this
// scheme, but does not write it any more.
template <typename Index, uint32_t kComponents>
PSPLIT_HD void predict_by_multi_parallelogram(WrappedValues<Index, kComponents> on) {
  using Block = typename WrappedValues<Index, kComponents>::Block;
  for (uint32_t i = 0; i < on.sequence.count; ++i) {
    const Index start = on.sequence.corner[i];
    const auto mean = [&](uint32_t k) {
      Block sum(0);
      int32_t count = 0;
      Index corner = start;
      do {
        Parallelogram known;
        if (find_parallelogram(on, i, corner, known)) sum = sum + known.predicted<Block>(k), ++count;
        corner = on.table.swing_right(corner);
      } while (corner != kNone<Index> && corner != start);
      return count == 0 ? Block(on.before(i) + k) : sum / count;
    };
    on.correct(i, on.at(start), mean);
  }
}

// The parallelograms of one value, as ParallelogramFinder finds them. No number is chosen by an index that is
// known only at run time, so a device keeps all in registers.
struct FoundParallelograms {
  uint32_t count = 0;
  uint32_t across[kMaxParallelograms] = {};  // the far corners of the first `count`
};
template <typename Index, uint32_t kComponents>
PSPLIT_HD FoundParallelograms find_parallelograms(const PredictedValues<Index, kComponents>& on, uint32_t i) {
  const CornerTable<Index> table = on.table;
  const View<const Index> rank = on.sequence.rank;
  const Index start = on.sequence.corner[i];
  FoundParallelograms found;
  const auto look = [&](Index corner) {
    const Index far = table.opposite[corner];
    if (far == kNone<Index>) return;
    const FaceRow<Index> face = row_of(table.vertex, far);
    if (rank[face.at[0]] >= i || rank[face.at[1]] >= i || rank[face.at[2]] >= i) return;
    PSPLIT_UNROLL
    for (uint32_t j = 0; j < kMaxParallelograms; ++j)
      if (j == found.count) found.across[j] = far;
    ++found.count;
  };
  Index corner = start;
  do {
    look(corner);
    corner = table.swing_left(corner);
  } while (corner != kNone<Index> && corner != start && found.count < kMaxParallelograms);
  if (corner != kNone<Index>) return found;
  for (corner = start; found.count < kMaxParallelograms;) {
    corner = table.swing_right(corner);
    if (corner == kNone<Index>) break;
    look(corner);
  }
  return found;
}

// The value of a chain (value_chain.h) that is the mean of parallelograms: a sum of values that are known, and
// of earlier values of the chain, each with a weight. A weight is a number from -kMost to 2 * kMost, because a
// value may be at two corners of each parallelogram. It takes four bits.
class WeightedSum {
 public:
  static constexpr uint32_t kMostValues = 16;  // of a chain

  PSPLIT_HD void add(int32_t known, bool is_far) {
    sum_ = is_far ? wrapping_sub(sum_, known) : wrapping_add(sum_, known);
  }
  // The same for the chain's value with this number, which is not known yet.
  PSPLIT_HD void add_later(uint32_t number, bool is_far) {
    const uint64_t one = uint64_t{1} << 4 * number;
    weights_ = is_far ? weights_ - one : weights_ + one;
  }
  // The value with this number is known.
  PSPLIT_HD void know(uint32_t number, int32_t value) {
    const uint32_t weight = static_cast<uint32_t>(weights_ >> 4 * number & 15) - kMost;
    sum_ = static_cast<int32_t>(static_cast<uint32_t>(sum_) + weight * static_cast<uint32_t>(value));
  }
  // The sum divided by a number from 1 to kMaxParallelograms, rounded toward zero.
  PSPLIT_HD int32_t divided_by(uint32_t count) const {
    const uint32_t size = magnitude(sum_);
    const uint32_t third = static_cast<uint32_t>(uint64_t{size} * 0xaaaaaaabu >> 33);
    const uint32_t quotient = count == 3 ? third : size >> (count >> 1);
    return static_cast<int32_t>(sum_ < 0 ? 0 - quotient : quotient);
  }

 private:
  static constexpr uint32_t kMost = kMaxParallelograms;
  static_assert(3 * kMost < 16 && kMost == 4);

  int32_t sum_ = 0;
  uint64_t weights_ = kMost * (~uint64_t{0} / 15);  // each is stored with kMost more
};

// Computes all values, as predict_by_constrained_multi_parallelogram below does, by lanes. The corrections are
// still symbols. Returns false if flags are missing. Collective.
template <Lanes L, typename Index, uint32_t kComponents>
PSPLIT_HD bool predict_by_constrained_multi_parallelogram(L lanes,
                                                          const PredictedValues<Index, kComponents>& on,
                                                          const WrapRange& range,
                                                          const View<uint8_t> (&creases)[kMaxParallelograms]) {
  constexpr uint32_t kValues = ValueLane<kComponents, L>::kValues, kChains = L::size() / kValues;
  static_assert(kValues <= WeightedSum::kMostValues);
  const ValueLane<kComponents, L> lane(lanes);
  const Wrap<1> wrap(range);
  const View<Index> vertex = on.table.vertex, rank = on.sequence.rank;
  const uint32_t count = on.sequence.count;
  size_t used[kMaxParallelograms] = {};  // of the flags
  // A lane finds the parallelograms of a value. Then come the values themselves, a chain after the other.
  for (uint32_t chunk = 0; chunk < count; chunk += kChains * kValues) {
    FoundParallelograms found;
    if (lanes.rank() < kChains * kValues && chunk + lanes.rank() < count)
      found = find_parallelograms(on, chunk + lanes.rank());
    uint32_t kept = 0;  // a bit for each parallelogram
    bool is_short = false;
    for (uint32_t n = 1; n <= kMaxParallelograms; ++n) {
      const uint32_t alike = lanes.ballot(found.count == n);
      if (found.count == n) {
        const View<uint8_t> flags = creases[n - 1];
        const size_t flag = used[n - 1] + n * bit_count(alike & ((1u << lanes.rank()) - 1));
        is_short = flag + n > flags.size();
        for (uint32_t j = 0; j < n && !is_short; ++j) kept |= (flags[flag + j] ^ 1u) << j;
      }
      used[n - 1] += n * bit_count(alike);
    }
    if (any(lanes, is_short)) return false;
    for (uint32_t chain = 0, first = chunk; chain < kChains && first < count; ++chain, first += kValues) {
      const uint32_t i = first + lane.value, finder = chain * kValues + lane.value;
      const bool is_busy = lane.is_busy() && i < count;
      const uint32_t mine = lanes.shuffle(kept, finder & (L::size() - 1));
      WeightedSum sum;
      const auto add = [&](uint32_t v, uint32_t place, bool is_far) {
        if (place >= first)
          sum.add_later(place - first, is_far);
        else
          sum.add(on.of_vertex(v)[lane.component], is_far);
      };
      for (uint32_t j = 0; j < kMaxParallelograms; ++j) {
        const uint32_t far = lanes.shuffle(found.across[j], finder & (L::size() - 1));
        if (!is_busy || (mine >> j & 1) == 0) continue;
        const FaceRow<Index> face = row_of(vertex, far);
        for (uint32_t k = 0; k < 3; ++k) add(face.at[k], rank[face.at[k]], k == (far & 3));
      }
      int32_t correction = 0;
      int32_t* out = nullptr;
      if (is_busy) {
        out = on.at(on.sequence.corner[i]) + lane.component;
        correction =
            static_cast<int32_t>(signed_of_symbol(static_cast<uint32_t>(on.correction(i)[lane.component])));
        if (mine == 0 && i > 0) add(vertex[on.sequence.corner[i - 1]], i - 1, false);
      }
      const uint32_t divisor = mine == 0 ? 1 : bit_count(mine), last = count - first;
      const auto value_of = [&] {
        return wrap(Components<1>(sum.divided_by(divisor)), Components<1>(correction))[0];
      };
      for (uint32_t number = 0; number + 1 < (last < kValues ? last : kValues); ++number) {
        const uint32_t source = number * kComponents + lane.component;
        sum.know(number, static_cast<int32_t>(lanes.shuffle(static_cast<uint32_t>(value_of()), source)));
      }
      if (is_busy) *out = value_of();
      lanes.sync();
    }
  }
  return true;
}

// A value is the mean of its first parallelograms (ParallelogramFinder), without those that a crease flag
// excludes. The arena is not released. `on` is a copy, which the loop may keep in registers.
template <typename Index, uint32_t kComponents>
PSPLIT_HD Fault predict_by_constrained_multi_parallelogram(WrappedValues<Index, kComponents> on,
                                                           const View<uint8_t> (&creases)[kMaxParallelograms],
                                                           Arena& arena) {
  using Block = typename WrappedValues<Index, kComponents>::Block;
  ParallelogramFinder<Index> finder;
  if (const Fault fault = finder.find(on.table, on.sequence, arena); fault != Fault::kNone) return fault;
  size_t used[kMaxParallelograms] = {};  // of the flags
  for (uint32_t i = 0; i < on.sequence.count; ++i) {
    if constexpr (sizeof(Index) == 4) {
      const uint32_t soon = i + 8 < on.sequence.count ? i + 8 : i;
      for (uint32_t j = 0; j < kMaxParallelograms; ++j)
        PSPLIT_PREFETCH(&on.table.vertex[finder.across(soon, j)]);
    }
    const uint32_t found = finder.count(i);
    if (found == 0) {
      on.correct(i, on.before(i));
      continue;
    }
    const View<uint8_t> flags = creases[found - 1];
    size_t& flag = used[found - 1];
    if (flag + found > flags.size()) return Fault::kPrediction;
    uint32_t kept = 0;  // a bit for each parallelogram
    for (uint32_t j = 0; j < found; ++j) kept |= (flags[flag + j] ^ 1u) << j;
    flag += found;
    if (PSPLIT_UNLIKELY(kept == 0)) {
      on.correct(i, on.before(i));
      continue;
    }
    constexpr uint8_t kBits[16] = {0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};
    const auto mean = [&](uint32_t k) {
      const auto predicted = [&](uint32_t j) {
        return parallelogram_at(on, finder.across(i, j)).template predicted<Block>(k);
      };
      Block sum(0);
#if defined(PSPLIT_HAS_VECTORS)
      if constexpr (kComponents == 3) {
        // The number of parallelograms is unpredictable: always add four, some of them masked to zero.
        for (uint32_t j = 0; j < kMaxParallelograms; ++j)
          sum = sum + (predicted(j) & Block(-static_cast<int32_t>(kept >> j & 1)));
        return sum.mean_of(kBits[kept]);
      }
#endif
      for (uint32_t j = 0; j < found; ++j)
        if ((kept >> j & 1) != 0) sum = sum + predicted(j);
      return sum / kBits[kept];
    };
    on.correct(i, on.at(on.sequence.corner[i]), mean);
  }
  return Fault::kNone;
}

}  // namespace psplit::core
