// Prediction: every value is stored as what corrects a guess from values before it. Draco bitstream
// specification 2.2, "prediction schemes" and "prediction transforms".
//
// Values are integers of some components; they lie by vertex of the attribute's corner table, corrections in
// the order of the sequence.
#pragma once

#include "src/core/octahedral.h"
#include "src/core/traversal.h"

namespace psplit::core {

enum class Scheme : int8_t {
  kNone = -2,
  kDifference = 0,
  kParallelogram = 1,
  kMultiParallelogram = 2,
  kConstrainedMultiParallelogram = 4,
  kTexCoords = 5,
  kGeometricNormal = 6,
};

enum class Transform : int8_t {
  kWrap = 1,
  kOctahedron = 2,
  kOctahedronCanonicalized = 3,
};

inline constexpr uint32_t kMaxParallelograms = 4;

// From one value to the next. Three components stand as four, so that a vector may be loaded and stored: a load
// that spans two stores would wait for both.
PSPLIT_HD constexpr uint32_t value_stride(uint32_t components) { return components == 3 ? 4 : components; }

// What is stored with the corrections.
struct PredictionData {
  Scheme scheme = Scheme::kNone;
  Transform transform = Transform::kWrap;
  // kWrap: values lie in [low, high], and are corrected modulo the number of values there.
  int32_t low = 0, high = 0, modulus = 0;
  // Octahedral transforms.
  OctahedralGrid grid;
  // By number of parallelograms - 1: whether each of them is left out (constrained multi-parallelogram). A
  // value's flags follow each other.
  View<uint8_t> creases[kMaxParallelograms];
  // Orientations of texture triangles, in the order of storage; they are used from the last to the first.
  View<uint8_t> orientations;
  // Whether a normal points the other way.
  RansBits flips;
};

PSPLIT_HD inline Fault read_wrap(ByteReader& reader, PredictionData& data) {
  data.low = static_cast<int32_t>(reader.u32());
  data.high = static_cast<int32_t>(reader.u32());
  if (reader.truncated()) return Fault::kTruncated;
  const int64_t difference = int64_t{data.high} - data.low;
  if (difference < 0 || difference >= 0x7fffffff) return Fault::kPrediction;
  data.modulus = static_cast<int32_t>(difference + 1);
  return Fault::kNone;
}

PSPLIT_HD inline Fault read_octahedron(ByteReader& reader, PredictionData& data) {
  const uint32_t max_quantized = reader.u32();
  if (data.transform == Transform::kOctahedronCanonicalized) reader.u32();  // the center, which follows from it
  if (reader.truncated()) return Fault::kTruncated;
  int bits = 0;
  while (bits < 31 && (1u << bits) - 1 < max_quantized) ++bits;
  if (bits < 2 || bits > 30 || (max_quantized & 1) == 0) return Fault::kPrediction;
  data.grid = OctahedralGrid(bits);
  return Fault::kNone;
}

// Reads what a scheme stores behind its corrections. `corner_limit`: no scheme has more flags than corners.
PSPLIT_HD inline Fault read_prediction_data(ByteReader& reader, uint32_t corner_limit, Arena& arena,
                                            PredictionData& data) {
  const auto read_transform = [&] {
    return data.transform == Transform::kWrap ? read_wrap(reader, data) : read_octahedron(reader, data);
  };
  if (data.scheme == Scheme::kNone) return Fault::kNone;
  if (data.scheme == Scheme::kConstrainedMultiParallelogram) {
    BitSteps flags[kMaxParallelograms];
    BitSteps* runs[kMaxParallelograms];
    for (uint32_t i = 0; i < kMaxParallelograms; ++i) {
      runs[i] = &flags[i];
      const uint32_t count = reader.varint();
      if (count > corner_limit) return Fault::kPrediction;
      if (!arena.take(data.creases[i], count)) return Fault::kWorkspace;
      if (count == 0) continue;
      RansBits bits;
      if (const Fault fault = bits.start(reader); fault != Fault::kNone) return fault;
      flags[i] = BitSteps(bits, data.creases[i]);
    }
    step_all<kInStep, BitSteps>(runs, kMaxParallelograms);
  }
  if (data.scheme == Scheme::kTexCoords) {
    const uint32_t count = reader.u32();
    if (count > corner_limit) return Fault::kPrediction;
    if (!arena.take(data.orientations, count)) return Fault::kWorkspace;
    RansBits same;
    if (const Fault fault = same.start(reader); fault != Fault::kNone) return fault;
    uint8_t orientation = 1;
    for (uint32_t i = 0; i < count; ++i) {
      if (!same.next()) orientation ^= 1;
      data.orientations[i] = orientation;
    }
  }
  if (const Fault fault = read_transform(); fault != Fault::kNone) return fault;
  if (data.scheme == Scheme::kGeometricNormal) return data.flips.start(reader);
  return Fault::kNone;
}

// Undoes the wrap transform for one component.
struct Wrap {
  int32_t low = 0, high = 0, modulus = 0;
  PSPLIT_HD int32_t operator()(int32_t predicted, int32_t correction) const {
    const int32_t clamped = predicted > high ? high : predicted < low ? low : predicted;
    const int32_t value = wrapping_add(clamped, correction);
    return value > high ? wrapping_sub(value, modulus) : value < low ? wrapping_add(value, modulus) : value;
  }
};

// Three components at once, where the compiler knows vectors. All have a fourth number, which says nothing.
#if defined(__GNUC__) && !defined(__CUDA_ARCH__)
#define PSPLIT_HAS_VECTORS 1
class Triple {
  using Lanes = uint32_t __attribute__((vector_size(16)));
  using Signed = int32_t __attribute__((vector_size(16)));
  using Half = int32_t __attribute__((vector_size(8)));
  using Doubles = double __attribute__((vector_size(16)));

 public:
  Triple() = default;
  explicit Triple(int32_t all) : lanes_(spread(static_cast<uint32_t>(all))) {}
  explicit Triple(const int32_t* from) { __builtin_memcpy(&lanes_, from, sizeof lanes_); }
  void store(int32_t* to) const { __builtin_memcpy(to, &lanes_, sizeof lanes_); }

  // Sums wrap around.
  friend Triple operator+(Triple a, Triple b) { return Triple(a.lanes_ + b.lanes_); }
  friend Triple operator-(Triple a, Triple b) { return Triple(a.lanes_ - b.lanes_); }
  friend Triple operator&(Triple a, Triple b) { return Triple(a.lanes_ & b.lanes_); }
  // All ones where a > b.
  friend Triple above(Triple a, Triple b) {
    return Triple(
        reinterpret_cast<Lanes>(reinterpret_cast<Signed>(a.lanes_) > reinterpret_cast<Signed>(b.lanes_)));
  }
  friend Triple choose(Triple mask, Triple a, Triple b) {
    return Triple((a.lanes_ & mask.lanes_) | (b.lanes_ & ~mask.lanes_));
  }
  // Of sums of one to four values their mean, rounded to zero: a half more never reaches the next integer, and
  // is far more than what a double rounds.
  Triple mean_of(uint32_t count) const {
    constexpr double kReciprocal[] = {0, 1, 1.0 / 2, 1.0 / 3, 1.0 / 4};
    return times(kReciprocal[count]);
  }

 private:
  Triple times(double reciprocal) const {
    const auto value = reinterpret_cast<Signed>(lanes_);
    const Half low = rounded(__builtin_shufflevector(value, value, 0, 1), reciprocal),
               high = rounded(__builtin_shufflevector(value, value, 2, 3), reciprocal);
    return Triple(reinterpret_cast<Lanes>(__builtin_shufflevector(low, high, 0, 1, 2, 3)));
  }

  explicit Triple(Lanes lanes) : lanes_(lanes) {}
  static Lanes spread(uint32_t x) { return Lanes{x, x, x, x}; }
  static Half rounded(Half sum, double reciprocal) {
    const auto value = __builtin_convertvector(sum, Doubles);
    const Doubles half{__builtin_copysign(0.5, value[0]), __builtin_copysign(0.5, value[1])};
    return __builtin_convertvector((value + half) * reciprocal, Half);
  }
  Lanes lanes_{};
};
#endif

// Undoes it for kComponents.
template <uint32_t kComponents>
class WrapOf {
 public:
  WrapOf() = default;
  PSPLIT_HD explicit WrapOf(const Wrap& wrap) : wrap_(wrap) {}
  PSPLIT_HD void correct_parallelogram(const int32_t* a, const int32_t* b, const int32_t* far,
                                       const int32_t* by, int32_t* out) const {
    for (uint32_t k = 0; k < kComponents; ++k)
      out[k] = wrap_(wrapping_sub(wrapping_add(a[k], b[k]), far[k]), by[k]);
  }

 private:
  Wrap wrap_;
};

#if defined(PSPLIT_HAS_VECTORS)
template <>
class WrapOf<3> {
 public:
  WrapOf() = default;
  explicit WrapOf(const Wrap& wrap) : low_(wrap.low), high_(wrap.high), modulus_(wrap.modulus) {}
  Triple operator()(Triple predicted, Triple correction) const {
    predicted = choose(above(predicted, high_), high_, predicted);
    predicted = choose(above(low_, predicted), low_, predicted);
    const Triple value = predicted + correction;
    return value - (modulus_ & above(value, high_)) + (modulus_ & above(low_, value));
  }
  void correct_parallelogram(const int32_t* a, const int32_t* b, const int32_t* far, const int32_t* by,
                             int32_t* out) const {
    (*this)(Triple(a) + Triple(b) - Triple(far), Triple(by)).store(out);
  }

 private:
  Triple low_, high_, modulus_;
};
#endif

// What a prediction computes with, and where.
template <typename Index>
struct PredictedValues {
  CornerTable<Index> table;
  Sequence<Index> sequence;
  View<const int32_t> corrections;
  View<int32_t> values;
  const int32_t* zeros = nullptr;  // four
};

// Parallelogram prediction, a value a step: from the triangle across the edge, its far corner mirrored at the
// middle of the edge; from the last value where that triangle is not known.
template <typename Index, uint32_t kComponents>
class ParallelogramSteps {
 public:
  ParallelogramSteps() = default;
  PSPLIT_HD ParallelogramSteps(const PredictedValues<Index>& on, const Wrap& wrap)
      : on_(on), wrap_(wrap), last_(on.zeros) {}

  PSPLIT_HD bool running() const { return i_ < on_.sequence.count; }
  PSPLIT_HD void step() {
    const CornerTable<Index>& table = on_.table;
    const View<Index> rank = on_.sequence.rank;
    const Index corner = on_.sequence.corner[i_], across = table.opposite[corner];
    const int32_t *at_a = last_, *at_b = on_.zeros, *far = on_.zeros;
    if (PSPLIT_LIKELY(across != kNone<Index>)) {
      const uint32_t v = table.vertex[across], a = table.vertex[next(across)],
                     b = table.vertex[previous(across)];
      if (PSPLIT_LIKELY(rank[v] < i_ && rank[a] < i_ && rank[b] < i_))
        far = value(v), at_a = value(a), at_b = value(b);
    }
    int32_t* const out = value(table.vertex[corner]);
    wrap_.correct_parallelogram(at_a, at_b, far, &on_.corrections[size_t{kComponents} * i_], out);
    last_ = out;
    ++i_;
  }

 private:
  PSPLIT_HD int32_t* value(uint32_t vertex) const {
    return &on_.values[size_t{vertex} * value_stride(kComponents)];
  }

  PredictedValues<Index> on_;
  WrapOf<kComponents> wrap_;
  const int32_t* last_ = nullptr;
  uint32_t i_ = 0;
};

// Normals from the last one, a value a step.
template <typename Index>
class NormalSteps {
 public:
  NormalSteps() = default;
  PSPLIT_HD NormalSteps(const PredictedValues<Index>& on, const OctahedralGrid& grid, bool canonicalized)
      : on_(on), grid_(grid), canonicalized_(canonicalized) {}

  PSPLIT_HD bool running() const { return i_ < on_.sequence.count; }
  PSPLIT_HD void step() {
    const int32_t* by = &on_.corrections[size_t{2} * i_];
    last_ = grid_.correct(last_, {by[0], by[1]}, canonicalized_);
    int32_t* const out = &on_.values[size_t{2} * on_.table.vertex[on_.sequence.corner[i_]]];
    out[0] = last_.s, out[1] = last_.t;
    ++i_;
  }

 private:
  PredictedValues<Index> on_;
  OctahedralGrid grid_;
  Vec2 last_;
  uint32_t i_ = 0;
  bool canonicalized_ = false;
};

// Finds for each value of a sequence the faces that are complete before it and lie across an edge from it, up
// to kMaxParallelograms, in the order in which they stand around its vertex: to the left from where the walk
// met it, then to the right. That depends on the order of values only, not on what they are, so that several
// are searched in step.
template <typename Index>
class ParallelogramFinder {
 public:
  PSPLIT_HD Fault find(const CornerTable<Index>& table, const Sequence<Index>& sequence, Arena& arena) {
    const auto face_count = static_cast<uint32_t>(table.opposite.size() / 4);
    // The face that kNone names is never complete; it has an entry of its own where that is not too far off.
    const uint32_t no_face = kNoFaceIsSmall ? kNone<Index> >> 2 : face_count;
    if (!arena.take(found_, sequence.count) ||
        !arena.take(across_, size_t{kMaxParallelograms} * sequence.count))
      return Fault::kWorkspace;
    fill(across_, Index{0});
    const size_t mark = arena.mark();
    View<Index> complete_at;
    if (!arena.take(complete_at, size_t{no_face} + 1)) return Fault::kWorkspace;
    complete_at[no_face] = kNone<Index>;
    const auto rank_at = [&](uint32_t corner) -> uint32_t { return sequence.rank[table.vertex[corner]]; };
    for (uint32_t face = 0; face < face_count; ++face) {
      const uint32_t a = rank_at(4 * face), b = rank_at(4 * face + 1), c = rank_at(4 * face + 2);
      const uint32_t ab = select(mask(a > b), a, b);
      complete_at[face] = static_cast<Index>(select(mask(ab > c), ab, c));
    }
    // Equal parts of the sequence, a corner of each in turn.
    Fan fans[kInStep];
    const Fans common{table, sequence.corner, complete_at, found_, across_};
    bool all = true;
    for (uint32_t n = 0; n < kInStep; ++n) {
      fans[n].i = static_cast<uint32_t>(uint64_t{sequence.count} * n / kInStep);
      fans[n].end = static_cast<uint32_t>(uint64_t{sequence.count} * (n + 1) / kInStep);
      if (fans[n].i < fans[n].end) fans[n].start = fans[n].corner = sequence.corner[fans[n].i];
      all &= fans[n].i < fans[n].end;
    }
    while (all) {
      PSPLIT_UNROLL
      for (Fan& fan : fans) all &= common.step(fan);
    }
    for (Fan& fan : fans)
      while (fan.i < fan.end) common.step(fan);
    arena.release(mark);
    return Fault::kNone;
  }

  PSPLIT_HD uint32_t count(uint32_t i) const { return found_[i]; }
  // The far corner of the j-th; of those past count(i) any corner.
  PSPLIT_HD Index across(uint32_t i, uint32_t j) const { return across_[size_t{kMaxParallelograms} * i + j]; }

 private:
  static constexpr bool kNoFaceIsSmall = sizeof(Index) == 2;

  // Where a search stands, for values [i, end).
  struct Fan {
    uint32_t i = 0, end = 0, start = 0, corner = 0, found = 0;
  };

  struct Fans {
    CornerTable<Index> table;
    View<const Index> corners, complete_at;
    View<uint8_t> found_at;
    View<Index> across_at;

    // Looks at one corner. Where a fan ends is as good as random, so that there are no branches but at borders.
    // Returns whether there are more.
    PSPLIT_HD bool step(Fan& fan) const {
      look(fan, fan.corner);
      const uint32_t beyond = table.opposite[next(fan.corner)], following = next(beyond);
      uint32_t done = fan.found >> 2 | static_cast<uint32_t>(following == fan.start);
      if (PSPLIT_UNLIKELY(beyond == kNone<Index>)) {
        for (Index right = static_cast<Index>(fan.start); fan.found < kMaxParallelograms;) {
          right = table.swing_right(right);
          if (right == kNone<Index>) break;
          look(fan, right);
        }
        done = 1;
      }
      found_at[fan.i] = static_cast<uint8_t>(fan.found);
      fan.i += done;
      // Sequences have room for a corner more than values.
      const uint32_t if_done = 0 - done, fresh = corners[fan.i];
      if constexpr (sizeof(Index) == 4) {
        const uint32_t soon = corners[fan.i + 16 < corners.size() ? fan.i + 16 : fan.i];
        PSPLIT_PREFETCH(&table.opposite[soon]);
      }
      fan.corner = select(if_done, fresh, following);
      fan.start = select(if_done, fresh, fan.start);
      fan.found &= ~if_done;
      return fan.i < fan.end;
    }

    PSPLIT_HD void look(Fan& fan, uint32_t corner) const {
      static_assert(kMaxParallelograms == 4);
      const uint32_t across = table.opposite[corner], face = across >> 2;
      const auto no_face = static_cast<uint32_t>(complete_at.size()) - 1;
      const bool complete = complete_at[kNoFaceIsSmall || face < no_face ? face : no_face] < fan.i;
      // Any corner does where there is none.
      across_at[size_t{4} * fan.i + fan.found] = static_cast<Index>(select(mask(complete), across, fan.start));
      fan.found += complete;
    }
  };

  View<uint8_t> found_;
  View<Index> across_;
};

// floor(sqrt(x)), exactly.
PSPLIT_HD inline uint64_t integer_sqrt(uint64_t x) {
  auto root = static_cast<uint64_t>(__builtin_sqrt(static_cast<double>(x)));
  if (root > 0xffffffffu) root = 0xffffffffu;
  while (root * root > x) --root;
  while (root < 0xffffffffu && (root + 1) * (root + 1) <= x) ++root;
  return root;
}

// Computes an attribute's values from its corrections. kComponents is their number, 0 where it is known at run
// time only. Positions are needed by two schemes: position_at(corner) is the integer position of the vertex
// there.
template <typename Index, uint32_t kComponents>
class Predictor {
 public:
  PSPLIT_HD Predictor(const AttributeTable<Index>& attribute, const Sequence<Index>& sequence,
                      uint32_t components, View<const int32_t> corrections, View<int32_t> values,
                      PredictionData& data)
      : table_(attribute.table),
        sequence_(sequence),
        components_(kComponents != 0 ? kComponents : components),
        corrections_(corrections),
        values_(values),
        data_(data),
        wrap_{data.low, data.high, data.modulus} {}

  PSPLIT_HD void none() {
    for (uint32_t i = 0; i < sequence_.count; ++i)
      for (uint32_t k = 0; k < components_; ++k) value_at(i)[k] = correction(i)[k];
  }

  PSPLIT_HD void difference() {
    for (uint32_t i = 0; i < sequence_.count; ++i) from_last(i);
  }

  // See ParallelogramSteps.
  PSPLIT_HD void parallelogram() {
    int32_t predicted[kMaxComponents];
    for (uint32_t i = 0; i < sequence_.count; ++i) {
      if (i > 0 && complete_parallelogram(i, sequence_.corner[i], predicted))
        correct(i, predicted);
      else
        from_last(i);
    }
  }

  // The mean of all parallelograms clockwise from the corner.
  PSPLIT_HD void multi_parallelogram() {
    int32_t predicted[kMaxComponents], sum[kMaxComponents];
    for (uint32_t i = 0; i < sequence_.count; ++i) {
      const Index start = sequence_.corner[i];
      int32_t count = 0;
      for (uint32_t k = 0; k < components_; ++k) sum[k] = 0;
      Index corner = start;
      while (i > 0 && corner != kNone<Index>) {
        if (complete_parallelogram(i, corner, predicted)) {
          for (uint32_t k = 0; k < components_; ++k) sum[k] = wrapping_add(sum[k], predicted[k]);
          ++count;
        }
        corner = table_.swing_right(corner);
        if (corner == start) break;
      }
      correct_mean(i, sum, count);
    }
  }

  // The mean of up to four parallelograms around the vertex, those left out that lie across a crease.
  PSPLIT_HD Fault constrained_multi_parallelogram(Arena& arena) {
    ParallelogramFinder<Index> finder;
    if (const Fault fault = finder.find(table_, sequence_, arena); fault != Fault::kNone) return fault;
    size_t used[kMaxParallelograms] = {};
    for (uint32_t i = 0; i < sequence_.count; ++i) {
      if constexpr (sizeof(Index) == 4) {
        const uint32_t soon = i + 8 < sequence_.count ? i + 8 : i;
        for (uint32_t j = 0; j < kMaxParallelograms; ++j)
          PSPLIT_PREFETCH(&table_.vertex[finder.across(soon, j)]);
      }
      const uint32_t found = finder.count(i);
      if (found == 0) {
        from_last(i);
        continue;
      }
      const View<uint8_t> creases = data_.creases[found - 1];
      size_t& flag = used[found - 1];
      if (flag + found > creases.size()) return Fault::kPrediction;
      const uint32_t kept = kept_of(creases.data() + flag, found);
      flag += found;
#if defined(PSPLIT_HAS_VECTORS)
      if constexpr (kComponents == 3) {
        if (PSPLIT_UNLIKELY(kept == 0)) {
          from_last(i);
          continue;
        }
        // How many count is as good as random: always four, of which some are nothing.
        Triple sum(0);
        for (uint32_t j = 0; j < kMaxParallelograms; ++j)
          sum = sum + (parallelogram(finder.across(i, j)) & Triple(-static_cast<int32_t>(kept >> j & 1)));
        constexpr uint8_t kBits[16] = {0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};
        wrap_of_three_(sum.mean_of(kBits[kept]), Triple(correction(i))).store(value_at(i));
        continue;
      }
#endif
      int32_t sum[kMaxComponents], count = 0;
      for (uint32_t k = 0; k < components_; ++k) sum[k] = 0;
      for (uint32_t j = 0; j < found; ++j) {
        if ((kept >> j & 1) == 0) continue;
        const Index across = finder.across(i, j);
        const int32_t *far = values_at(across), *a = values_at(next(across)), *b = values_at(previous(across));
        for (uint32_t k = 0; k < components_; ++k)
          sum[k] = wrapping_add(sum[k], wrapping_sub(wrapping_add(a[k], b[k]), far[k]));
        ++count;
      }
      correct_mean(i, sum, count);
    }
    return Fault::kNone;
  }

  // Texture coordinates: the triangle as it lies in space, scaled and turned to fit the edge that is known.
  template <typename PositionAt>
  PSPLIT_HD Fault tex_coords(PositionAt position_at) {
    size_t orientations_left = data_.orientations.size();
    for (uint32_t i = 0; i < sequence_.count; ++i) {
      const Index tip = sequence_.corner[i], at_next = next(tip), at_previous = previous(tip);
      const bool has_next = rank_at(at_next) < i, has_previous = rank_at(at_previous) < i;
      int32_t predicted[2] = {0, 0};
      if (has_next && has_previous) {
        const int32_t* n = values_at(at_next);
        const int32_t* p = values_at(at_previous);
        if (n[0] == p[0] && n[1] == p[1]) {
          predicted[0] = p[0], predicted[1] = p[1];
          correct(i, predicted);
          continue;
        }
        const Vec3 n_at = position_at(at_next), pn = minus(position_at(at_previous), n_at);
        const uint64_t pn_square = dot(pn, pn);
        if (pn_square != 0) {
          const Fault fault =
              place_tip(n, p, n_at, pn, pn_square, position_at(tip), orientations_left, predicted);
          if (fault != Fault::kNone) return fault;
          correct(i, predicted);
          continue;
        }
      }
      if (has_next) {
        correct(i, values_at(at_next));
      } else {
        from_last(i);
      }
    }
    return Fault::kNone;
  }

  // Normals: the sum of the normals of the faces around, each as long as its face is large.
  template <typename PositionAt>
  PSPLIT_HD void geometric_normal(PositionAt position_at) {
    constexpr uint64_t kBound = 1u << 29;
    for (uint32_t i = 0; i < sequence_.count; ++i) {
      const Index start = sequence_.corner[i];
      const Vec3 center = position_at(start);
      Vec3 sum;
      Index corner = start;
      bool leftwards = true;
      while (corner != kNone<Index>) {
        add_cross(sum, minus(position_at(next(corner)), center), minus(position_at(previous(corner)), center));
        corner = leftwards ? table_.swing_left(corner) : table_.swing_right(corner);
        if (corner == start) break;
        if (corner == kNone<Index> && leftwards) {
          leftwards = false;
          corner = table_.swing_right(start);
        }
      }
      const uint64_t x = magnitude(sum.x), y = magnitude(sum.y), z = magnitude(sum.z);
      constexpr uint64_t kMost = ~uint64_t{0} >> 1;
      const uint64_t length = y > kMost - x || z > kMost - x - y ? kMost : x + y + z;
      if (length > kBound) {
        const auto quotient = static_cast<int64_t>(length / kBound);
        sum = {sum.x / quotient, sum.y / quotient, sum.z / quotient};
      }
      const Vec2 predicted = data_.grid.project(sum, data_.flips.next());
      const int32_t guess[2] = {predicted.s, predicted.t};
      correct(i, guess);
    }
  }

 private:
  static constexpr uint32_t kMaxComponents = kComponents != 0 ? kComponents : 255;

  PSPLIT_HD const int32_t* correction(uint32_t i) const { return &corrections_[size_t{i} * components_]; }
  PSPLIT_HD int32_t* values_at(Index corner) const {
    return &values_[size_t{table_.vertex[corner]} * value_stride(components_)];
  }
  PSPLIT_HD int32_t* value_at(uint32_t i) const { return values_at(sequence_.corner[i]); }
  PSPLIT_HD uint32_t rank_at(uint32_t corner) const { return sequence_.rank[table_.vertex[corner]]; }

  PSPLIT_HD void correct(uint32_t i, const int32_t* predicted) {
    const int32_t* by = correction(i);
    int32_t* out = value_at(i);
    if constexpr (kComponents == 2) {
      if (data_.transform != Transform::kWrap) {
        const Vec2 value = data_.grid.correct({predicted[0], predicted[1]}, {by[0], by[1]},
                                              data_.transform == Transform::kOctahedronCanonicalized);
        out[0] = value.s, out[1] = value.t;
        return;
      }
    }
    for (uint32_t k = 0; k < components_; ++k) out[k] = wrap_(predicted[k], by[k]);
  }
  PSPLIT_HD void from_last(uint32_t i) {
    const int32_t zero[kMaxComponents] = {};
    correct(i, i > 0 ? value_at(i - 1) : zero);
  }
  PSPLIT_HD void correct_mean(uint32_t i, int32_t* sum, int32_t count) {
    if (count == 0) return from_last(i);
    for (uint32_t k = 0; k < components_; ++k) sum[k] /= count;
    correct(i, sum);
  }

  // Of the flags of up to four parallelograms a bit for each that is none of a crease.
  PSPLIT_HD static uint32_t kept_of(const uint8_t* creases, uint32_t found) {
    uint32_t kept = 0;
    for (uint32_t j = 0; j < found; ++j) kept |= (creases[j] ^ 1u) << j;
    return kept;
  }
#if defined(PSPLIT_HAS_VECTORS)
  Triple parallelogram(Index across) const {
    return Triple(values_at(next(across))) + Triple(values_at(previous(across))) - Triple(values_at(across));
  }
#endif

  // False where the face across is not known yet.
  PSPLIT_HD bool complete_parallelogram(uint32_t i, Index corner, int32_t* out) const {
    const Index across = table_.opposite[corner];
    if (across == kNone<Index>) return false;
    const Index a = next(across), b = previous(across);
    if (rank_at(across) >= i || rank_at(a) >= i || rank_at(b) >= i) return false;
    const int32_t *far = values_at(across), *at_a = values_at(a), *at_b = values_at(b);
    for (uint32_t k = 0; k < components_; ++k) out[k] = wrapping_sub(wrapping_add(at_a[k], at_b[k]), far[k]);
    return true;
  }

  PSPLIT_HD static Vec3 minus(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  PSPLIT_HD static uint64_t product(int64_t a, int64_t b) {
    return static_cast<uint64_t>(a) * static_cast<uint64_t>(b);
  }
  PSPLIT_HD static uint64_t dot(Vec3 a, Vec3 b) {
    return product(a.x, b.x) + product(a.y, b.y) + product(a.z, b.z);
  }
  PSPLIT_HD static void add_cross(Vec3& sum, Vec3 a, Vec3 b) {
    const auto add = [](int64_t& to, uint64_t what) {
      to = static_cast<int64_t>(static_cast<uint64_t>(to) + what);
    };
    add(sum.x, product(a.y, b.z) - product(a.z, b.y));
    add(sum.y, product(a.z, b.x) - product(a.x, b.z));
    add(sum.z, product(a.x, b.y) - product(a.y, b.x));
  }

  // All in integers, scaled by |pn| squared: the tip's foot X on the edge, then the height over it, to the side
  // that the orientation says.
  PSPLIT_HD Fault place_tip(const int32_t* n, const int32_t* p, Vec3 n_at, Vec3 pn, uint64_t pn_square,
                            Vec3 tip_at, size_t& orientations_left, int32_t* out) const {
    constexpr auto kMost = static_cast<int64_t>(~uint64_t{0} >> 1);
    const auto larger = [](uint64_t a, uint64_t b) { return a > b ? a : b; };
    const int64_t edge_s = int64_t{p[0]} - n[0], edge_t = int64_t{p[1]} - n[1];
    const Vec3 cn = minus(tip_at, n_at);
    const auto along = static_cast<int64_t>(dot(pn, cn));
    const uint64_t n_most = larger(magnitude(int64_t{n[0]}), magnitude(int64_t{n[1]}));
    const uint64_t edge_most = larger(magnitude(edge_s), magnitude(edge_t));
    const uint64_t pn_most = larger(larger(magnitude(pn.x), magnitude(pn.y)), magnitude(pn.z));
    if (n_most > uint64_t{kMost} / pn_square || magnitude(along) > uint64_t{kMost} / edge_most ||
        magnitude(along) > uint64_t{kMost} / pn_most)
      return Fault::kPrediction;
    const auto scale = static_cast<int64_t>(pn_square);
    if (scale <= 0) return Fault::kPrediction;
    const uint64_t foot_s = product(n[0], scale) + product(along, edge_s);
    const uint64_t foot_t = product(n[1], scale) + product(along, edge_t);
    const Vec3 foot_at{n_at.x + along * pn.x / scale, n_at.y + along * pn.y / scale,
                       n_at.z + along * pn.z / scale};
    const Vec3 height = minus(tip_at, foot_at);
    const auto length = static_cast<int64_t>(integer_sqrt(dot(height, height) * pn_square));
    if (orientations_left == 0) return Fault::kPrediction;
    const bool up = data_.orientations[--orientations_left] != 0;
    const uint64_t up_s = product(edge_t, length), up_t = product(-edge_s, length);
    out[0] = static_cast<int32_t>(static_cast<int64_t>(up ? foot_s + up_s : foot_s - up_s) / scale);
    out[1] = static_cast<int32_t>(static_cast<int64_t>(up ? foot_t + up_t : foot_t - up_t) / scale);
    return Fault::kNone;
  }

  const CornerTable<Index>& table_;
  const Sequence<Index>& sequence_;
  uint32_t components_;
  View<const int32_t> corrections_;
  View<int32_t> values_;
  PredictionData& data_;
  Wrap wrap_;
#if defined(PSPLIT_HAS_VECTORS)
  WrapOf<3> wrap_of_three_{wrap_};
#endif
};

}  // namespace psplit::core
