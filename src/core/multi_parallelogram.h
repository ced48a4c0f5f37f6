// Prediction by several parallelograms: the mean of those around a value's vertex.
//
// D. Cohen-Or, R. Cohen, R. Irony: Multi-way Geometry Encoding, 2002. Draco bitstream specification 2.2,
// "multi-parallelogram prediction" and "constrained multi-parallelogram prediction".
#pragma once

#include "src/core/in_step.h"
#include "src/core/parallelogram.h"
#include "src/core/prediction_data.h"

namespace psplit::core {

// The parallelograms that predict a value, at most kMaxParallelograms, in their order around the value's
// vertex: to the left from the corner at which the traversal met the vertex, then to the right from there. No
// number is chosen by an index that is known only at run time, so a device keeps all in registers.
struct FoundParallelograms {
  uint32_t count = 0;
  uint32_t across[kMaxParallelograms] = {};  // the far corners of the first `count`
};
template <typename Index>
PSPLIT_HD FoundParallelograms find_parallelograms(const CornerTable<Index>& table,
                                                  const Sequence<Index>& sequence, uint32_t i) {
  const View<const Index> rank = sequence.rank;
  const Index start = sequence.corner[i];
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

// Finds the parallelograms of all values of a sequence, as find_parallelograms does.
//
// A face predicts the last of its values from the face across, if that one's values come before. So each face
// gives one parallelogram at most, and the values get theirs in any order. Most values have two, of which the
// first is across from the corner where the traversal met the vertex, because it came from there. Only the
// vertices of the few values that get three are walked around.
template <typename Index>
class ParallelogramFinder {
 public:
  // Attributes in the same order have the same parallelograms: does nothing if these were found.
  PSPLIT_HD Fault find(const CornerTable<Index>& table, const Sequence<Index>& sequence, Arena& arena) {
    if (are_of(table, sequence)) return Fault::kNone;
    corners_ = sequence.corner;
    opposite_ = table.opposite;
    if (!arena.take(found_, sequence.count) ||
        !arena.take(across_, uint64_t{kMaxParallelograms} * sequence.count))
      return Fault::kWorkspace;
    give(table, sequence);
    put_in_order(table, sequence);
    return Fault::kNone;
  }
  // The memory that `find` takes.
  PSPLIT_HD static constexpr size_t bytes(uint64_t value_count) {
    return Arena::bytes<uint8_t>(value_count) + Arena::bytes<Index>(kMaxParallelograms * value_count);
  }

  PSPLIT_HD bool are_of(const CornerTable<Index>& table, const Sequence<Index>& sequence) const {
    return opposite_.data() == table.opposite.data() && corners_.data() == sequence.corner.data() &&
           corners_.data() != nullptr;
  }
  PSPLIT_HD uint32_t count(uint32_t i) const { return found_[i]; }
  // The far corner of value i's j-th parallelogram; any corner if j is not below count(i).
  PSPLIT_HD Index across(uint32_t i, uint32_t j) const { return across_[size_t{kMaxParallelograms} * i + j]; }

 private:
  static constexpr uint32_t kMany = 3;  // or more
  static_assert(kMany < kMaxParallelograms);

  // Gives each value up to kMany parallelograms, in the order of faces.
  PSPLIT_HD void give(const CornerTable<Index>& table, const Sequence<Index>& sequence) {
    fill(found_, uint8_t{0});
    fill(across_, Index{0});
    const auto corner_count = static_cast<uint32_t>(table.opposite.size());
    for (uint32_t face = 0; face < corner_count; face += 4) {
      const FaceRow<Index> vertex = row_of(table.vertex, face);
      const uint32_t a = sequence.rank[vertex.at[0]], b = sequence.rank[vertex.at[1]],
                     c = sequence.rank[vertex.at[2]];
      const uint32_t ab = select(mask(a > b), a, b), last = select(mask(ab > c), ab, c);
      const uint32_t is_a = a == last, is_b = b == last, is_c = c == last;
      const uint32_t corner = face + is_b + 2 * is_c;  // any of the row's if a vertex is at two corners
      const Index across = table.opposite[corner];
      const bool exists = across != kNone<Index>;
      const uint32_t far = sequence.rank[table.vertex[exists ? across : face]];
      const uint32_t found = found_[last], is_found = static_cast<uint32_t>(exists) &
                                                      static_cast<uint32_t>(far < last) &
                                                      static_cast<uint32_t>(is_a + is_b + is_c == 1);
      // Any corner will do where there is no parallelogram.
      across_[size_t{kMaxParallelograms} * last + found] = static_cast<Index>(exists ? across : face);
      found_[last] = static_cast<uint8_t>(found + (is_found & static_cast<uint32_t>(found < kMany)));
    }
  }
  PSPLIT_HD void put_in_order(const CornerTable<Index>& table, const Sequence<Index>& sequence) {
    for (uint32_t i = 0; i < sequence.count; ++i) {
      Index* const across = &across_[size_t{kMaxParallelograms} * i];
      const uint32_t found = found_[i];
      const Index first = table.opposite[sequence.corner[i]], a = across[0], b = across[1];
      if (PSPLIT_UNLIKELY(found == kMany || (found == 2 && a != first && b != first))) {
        walk(table, sequence, i);
        continue;
      }
      const uint32_t swap = mask(found == 2 && b == first);
      across[0] = static_cast<Index>(select(swap, b, a));
      across[1] = static_cast<Index>(select(swap, a, b));
    }
  }
  // Finds the parallelograms of one value in their order.
  PSPLIT_HD void walk(const CornerTable<Index>& table, const Sequence<Index>& sequence, uint32_t i) {
    const FoundParallelograms found = find_parallelograms(table, sequence, i);
    found_[i] = static_cast<uint8_t>(found.count);
    for (uint32_t j = 0; j < kMaxParallelograms; ++j)
      across_[size_t{kMaxParallelograms} * i + j] = static_cast<Index>(found.across[j]);
  }

  View<const Index> corners_, opposite_;  // whose parallelograms are found
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

// The value of a chain (value_chain.h) that is the mean of parallelograms: a sum of values that are known, and
// of earlier values of the chain, each with a weight. A weight is a number from -kMost to 2 * kMost, because a
// value may be at two corners of each parallelogram. It takes four bits.
class WeightedSum {
 public:
  static constexpr uint32_t kMostValues = 16;  // of a chain

  PSPLIT_HD void add(int32_t known, bool is_far) {
    sum_ = is_far ? wrapping_sub(sum_, known) : wrapping_add(sum_, known);
  }
  // Likewise adds the chain's value with this number, which is not yet known.
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
      found = find_parallelograms(on.table, on.sequence, chunk + lanes.rank());
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

// A value is the mean of its first parallelograms that no crease flag excludes. `on` and `finder` are copies,
// which the loop may keep in registers.
template <typename Index, uint32_t kComponents>
PSPLIT_HD Fault predict_by_constrained_multi_parallelogram(WrappedValues<Index, kComponents> on,
                                                           ParallelogramFinder<Index> finder,
                                                           const View<uint8_t> (&creases)[kMaxParallelograms]) {
  using Block = typename WrappedValues<Index, kComponents>::Block;
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
      if constexpr (kComponents == 3 || kComponents == 4) {
        // Most values have two parallelograms or less. Which of them count is unpredictable: the others are
        // masked to zero.
        const auto add = [&](uint32_t j) {
          sum = sum + (predicted(j) & Block(-static_cast<int32_t>(kept >> j & 1)));
        };
        add(0), add(1);
        if (PSPLIT_UNLIKELY(found > 2)) add(2), add(3);
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
