#include "encoder/stream/kd_tree_encoder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "encoder/fields/entropy_encoder.h"
#include "src/core/kd_tree.h"

namespace psplit {
namespace {

using core::KdTree;

// The last number of kAxisBits is no axis.
constexpr uint32_t kMostSelectedAxes = (1u << KdTree::kAxisBits) - 1;

// The inverse of core::PlainBits.
class PlainBitWriter {
 public:
  // The lowest `count` bits, at most 32.
  void write(uint32_t value, uint32_t count) {
    if (word_count_ == words_.size()) words_.resize(2 * word_count_ + 64);
    pending_ = pending_ << count | (value & ((uint64_t{1} << count) - 1));
    pending_count_ += count;
    words_[word_count_] = static_cast<uint32_t>(pending_ >> pending_count_ % 32);  // may come again
    word_count_ += pending_count_ / 32;
    pending_count_ %= 32;
  }
  // The last word may be without bits.
  void append_to(std::vector<uint8_t>& out) {
    words_.resize(word_count_);
    words_.push_back(static_cast<uint32_t>(pending_ << (32 - pending_count_)));
    append_u32(static_cast<uint32_t>(words_.size() * sizeof(uint32_t)), out);
    const auto* const bytes = reinterpret_cast<const uint8_t*>(words_.data());
    out.insert(out.end(), bytes, bytes + words_.size() * sizeof(uint32_t));
  }

 private:
  Array<uint32_t> words_;
  size_t word_count_ = 0;
  uint64_t pending_ = 0;
  uint32_t pending_count_ = 0;  // below 32
};

// The inverse of core::TreeNumbers.
class NumberList {
 public:
  // A number of `count` bits, 1 to 31.
  void push(uint32_t number, uint32_t count) { numbers_.push_back(1u << count | number); }

  void append_to(uint8_t level, std::vector<uint8_t>& out) {
    switch (KdTree::number_coding(level)) {
      case core::NumberCoding::kPlain: return append_plain(out);
      case core::NumberCoding::kRans: return append_flags(out);
      case core::NumberCoding::kFolded: return append_folded(out);
    }
  }

 private:
  static uint32_t bit_count(uint32_t marked) { return static_cast<uint32_t>(std::bit_width(marked)) - 1; }

  void append_plain(std::vector<uint8_t>& out) const {
    PlainBitWriter bits;
    for (const uint32_t marked : numbers_) bits.write(marked, bit_count(marked));
    bits.append_to(out);
  }
  void append_flags(std::vector<uint8_t>& out) const {
    std::vector<uint8_t> flags;
    for (const uint32_t marked : numbers_)
      for (uint32_t i = bit_count(marked); i-- > 0;) flags.push_back(marked >> i & 1);
    encode_flags(flags, out);
  }
  // Place by place. Numbers lose their highest bit each time.
  void append_folded(std::vector<uint8_t>& out) {
    std::vector<uint8_t> flags(numbers_.size());
    for (uint32_t place = 0; place < core::TreeNumbers::kPlaces; ++place) {
      flags.resize(numbers_.size());
      size_t left = 0;
      for (size_t i = 0; i < flags.size(); ++i) {
        const uint32_t marked = numbers_[i], mark = 1u << (bit_count(marked) - 1);
        flags[i] = (marked & mark) != 0 ? 1 : 0;
        numbers_[left] = (marked & (mark - 1)) | mark;
        left += mark > 1 ? 1 : 0;
      }
      numbers_.resize(left);
      encode_flags(flags, out);
    }
    encode_flags({}, out);  // bits that are no part of a number
  }

  std::vector<uint32_t> numbers_;  // each with a bit in front, which says how many bits it has
};

uint32_t count_bits(uint64_t flags) {
  flags -= flags >> 1 & 0x5555555555555555;
  flags = (flags & 0x3333333333333333) + (flags >> 2 & 0x3333333333333333);
  return static_cast<uint32_t>(((flags + (flags >> 4)) & 0x0f0f0f0f0f0f0f0f) * 0x0101010101010101 >> 56);
}
uint32_t take_first(uint64_t& flags) {
  const auto first = static_cast<uint32_t>(std::countr_zero(flags));
  flags &= flags - 1;
  return first;
}
uint32_t take_last(uint64_t& flags) {
  const auto last = 63 - static_cast<uint32_t>(std::countl_zero(flags));
  flags ^= uint64_t{1} << last;
  return last;
}

// The rows of points, which move. With `kAxes` 0, the number of axes is that of the points.
template <uint32_t kAxes>
class Rows {
 public:
  explicit Rows(TreePoints& points) : axis_count_(points.axis_count), first_(points.rows.data()) {}

  uint32_t axis_count() const { return kAxes != 0 ? kAxes : axis_count_; }
  const uint32_t* row(uint32_t i) const { return first_ + size_t{i} * row_size(); }

  // Moves the points whose coordinate has the bit at `place` after the others, and returns where they begin.
  // Points that share all bits, or are two in a box, are stored in the order that the moves give them. That is
  // the order of std::partition: the first and the last point on the wrong side change places, and so on. Most
  // boxes have few points; the points of larger boxes are examined block by block, from both ends.
  uint32_t move_upper_half(uint32_t begin, uint32_t end, uint32_t axis, uint32_t place) {
    constexpr uint32_t kBlock = 32;
    uint64_t wrong_front = 0, wrong_back = 0;
    while (end - begin >= 2 * kBlock) {
      if (wrong_front == 0) wrong_front = points_with(begin, kBlock, axis, place);
      if (wrong_back == 0) wrong_back = ~points_with(end - kBlock, kBlock, axis, place) & 0xffffffff;
      while (wrong_front != 0 && wrong_back != 0)
        swap(begin + take_first(wrong_front), end - kBlock + take_last(wrong_back));
      if (wrong_front == 0) begin += kBlock;
      if (wrong_back == 0) end -= kBlock;
    }
    const uint64_t all = (uint64_t{1} << (end - begin)) - 1;
    const uint64_t upper = points_with(begin, end - begin, axis, place) & all;
    const uint32_t lower_count = end - begin - count_bits(upper);
    const uint64_t front = (uint64_t{1} << lower_count) - 1;
    wrong_front = upper & front;
    wrong_back = ~upper & all & ~front;
    while (wrong_front != 0) swap(begin + take_first(wrong_front), begin + take_last(wrong_back));
    return begin + lower_count;
  }

 private:
  static constexpr uint32_t kStep = TreePoints::kRowsBehind;

  size_t row_size() const { return size_t{axis_count()} + 1; }
  // A flag for each of at most 64 points, in their order. They are read kStep at a time, possibly beyond the
  // last.
  uint64_t points_with(uint32_t begin, uint32_t count, uint32_t axis, uint32_t place) const {
    const uint32_t bit = 1u << place;
    uint64_t points = 0;
    const uint32_t* at = row(begin) + axis;
    for (uint32_t i = 0; i < count; i += kStep, at += kStep * row_size()) {
      uint64_t step = 0;
      for (uint32_t k = kStep; k-- > 0;) step = 2 * step + (at[k * row_size()] & bit);
      points |= step >> place << i;
    }
    return points;
  }
  void swap(uint32_t a, uint32_t b) {
    uint32_t *const first = first_ + a * row_size(), *const second = first_ + b * row_size();
    if constexpr (kAxes != 0) {
      std::array<uint32_t, kAxes + 1> kept;
      std::memcpy(kept.data(), first, sizeof kept);
      std::memmove(first, second, sizeof kept);
      std::memcpy(second, kept.data(), sizeof kept);
    } else {
      std::swap_ranges(first, first + row_size(), second);
    }
  }

  const uint32_t axis_count_;
  uint32_t* const first_;
};

// How far the points of a box are known: as the decoder, encoders cut the axes one after the other...
class CutsInTurn {
 public:
  CutsInTurn(uint32_t axis_count, uint32_t bits) {
    // After the last cut, all bits of the axes are known.
    for (uint32_t i = 0; i < axis_count * (bits + 1); ++i)
      cuts_.push_back({(i + 1) % axis_count, bits - i / axis_count});
  }

  struct State {
    uint32_t cut_count = 0;
  };
  template <uint32_t kAxes>
  uint32_t axis(const Rows<kAxes>&, const State& state, uint32_t, uint32_t) const {
    return cuts_[state.cut_count].axis;
  }
  uint32_t unknown_bits(const State& state, uint32_t) const { return cuts_[state.cut_count].unknown_bits; }
  void cut(State& state, uint32_t) const { ++state.cut_count; }

  // Writes the unknown bits of a point, if the point exists.
  template <uint32_t kAxes>
  void write_rest(const Rows<kAxes>& rows, const State& state, uint32_t, const uint32_t* point, bool is_there,
                  PlainBitWriter& rest) const {
    const Cut* cut = &cuts_[state.cut_count];
    const uint32_t axes = rows.axis_count(), all = static_cast<uint32_t>(cuts_.size()) - axes;
    if (const uint32_t unknown = all - state.cut_count; unknown < 32) {
      uint32_t bits = 0;
      for (uint32_t i = 0; i < axes; ++i, ++cut)
        bits = bits << cut->unknown_bits | (point[cut->axis] & ((1u << cut->unknown_bits) - 1));
      return rest.write(bits, is_there ? unknown : 0);
    }
    for (uint32_t i = 0; i < axes; ++i, ++cut) rest.write(point[cut->axis], is_there ? cut->unknown_bits : 0);
  }
  void append_to(std::vector<uint8_t>& out) { PlainBitWriter().append_to(out); }

 private:
  struct Cut {
    uint32_t axis, unknown_bits;  // before the cut
  };
  std::vector<Cut> cuts_;
};

// ... or the axis that keeps the points together, of large boxes, and the coarsest one of others.
class CutsByChoice {
 public:
  CutsByChoice(uint32_t, uint32_t bits) : bits_(bits) {}

  struct State {
    std::array<uint8_t, kMostSelectedAxes> known{};  // bits of each axis
  };
  template <uint32_t kAxes>
  uint32_t axis(const Rows<kAxes>& rows, const State& state, uint32_t begin, uint32_t end) {
    if (end - begin >= KdTree::kFewestForAxis) return evenest_axis(rows, state, begin, end);
    const auto first = state.known.begin();
    return static_cast<uint32_t>(std::min_element(first, first + rows.axis_count()) - first);
  }
  uint32_t unknown_bits(const State& state, uint32_t axis) const { return bits_ - state.known[axis]; }
  void cut(State& state, uint32_t axis) const { ++state.known[axis]; }
  template <uint32_t kAxes>
  void write_rest(const Rows<kAxes>& rows, const State& state, uint32_t first, const uint32_t* point,
                  bool is_there, PlainBitWriter& rest) const {
    for (uint32_t i = 0, axis = first; i < rows.axis_count(); ++i) {
      rest.write(point[axis], is_there ? unknown_bits(state, axis) : 0);
      if (++axis == rows.axis_count()) axis = 0;
    }
  }
  void append_to(std::vector<uint8_t>& out) { axes_.append_to(out); }

 private:
  // The first axis whose larger half has the most points.
  template <uint32_t kAxes>
  uint32_t evenest_axis(const Rows<kAxes>& rows, const State& state, uint32_t begin, uint32_t end) {
    const uint32_t axes = rows.axis_count();
    uint32_t bits[kMostSelectedAxes] = {}, upper[kMostSelectedAxes] = {};
    for (uint32_t axis = 0; axis < axes; ++axis)
      if (const uint32_t unknown = unknown_bits(state, axis); unknown > 0) bits[axis] = 1u << (unknown - 1);
    for (uint32_t i = begin; i < end; ++i) {
      const uint32_t* const point = rows.row(i);
      for (uint32_t axis = 0; axis < axes; ++axis) upper[axis] += (point[axis] & bits[axis]) != 0 ? 1 : 0;
    }
    uint32_t best = 0, most = 0;
    for (uint32_t axis = 0; axis < axes; ++axis) {
      if (bits[axis] == 0) continue;
      const uint32_t larger = std::max(upper[axis], end - begin - upper[axis]);
      if (larger > most) most = larger, best = axis;
    }
    axes_.write(best, KdTree::kAxisBits);
    return best;
  }

  const uint32_t bits_;
  PlainBitWriter axes_;
};

// What an encoder stores of the tree, and the order of the points.
struct WrittenTree {
  NumberList numbers;
  PlainBitWriter rest, halves;
  std::vector<uint32_t> order;
};

// Most boxes are small, and nothing predicts how many points their halves have. So what depends on that is
// written anyway, and counts or not.
template <uint32_t kAxes, typename Cuts>
void walk(Rows<kAxes> rows, uint32_t point_count, uint32_t most_cuts, Cuts& cuts, WrittenTree& out) {
  struct Box {
    uint32_t begin, end;
    typename Cuts::State state;
  };
  std::vector<Box> waiting(size_t{most_cuts} + 1);  // lower halves
  size_t waiting_count = 0;
  Box box{0, point_count, {}};
  uint32_t* order = out.order.data();
  const auto write_point = [&](uint32_t i, uint32_t axis, bool is_there) {
    const uint32_t* const point = rows.row(i);
    cuts.write_rest(rows, box.state, axis, point, is_there, out.rest);
    *order = point[rows.axis_count()];
    order += is_there ? 1 : 0;
  };
  while (true) {
    const uint32_t size = box.end - box.begin, axis = cuts.axis(rows, box.state, box.begin, box.end);
    const uint32_t unknown = cuts.unknown_bits(box.state, axis);
    if (size <= 2 || unknown == 0) {
      write_point(box.begin, axis, true);
      write_point(box.begin + 1, axis, size > 1);
      for (uint32_t i = 2; i < size; ++i) write_point(box.begin + i, axis, true);
      if (waiting_count == 0) return;
      box = waiting[--waiting_count];
      continue;
    }
    const uint32_t middle = rows.move_upper_half(box.begin, box.end, axis, unknown - 1);
    const uint32_t lower = middle - box.begin, upper = box.end - middle;
    out.numbers.push(size / 2 - std::min(lower, upper), core::floor_log2(size));
    out.halves.write(lower < upper ? 1 : 0, lower != upper ? 1 : 0);
    cuts.cut(box.state, axis);
    waiting[waiting_count] = {box.begin, middle, box.state};
    waiting_count += lower > 0 && upper > 0 ? 1 : 0;
    box.begin = upper > 0 ? middle : box.begin;
  }
}

template <uint32_t kAxes, typename Cuts>
std::vector<uint32_t> encode(TreePoints& points, uint8_t level, uint32_t bits, std::vector<uint8_t>& out) {
  WrittenTree tree;
  tree.order.resize(size_t{points.count} + 1);
  Cuts cuts(points.axis_count, bits);
  walk(Rows<kAxes>(points), points.count, bits * points.axis_count, cuts, tree);
  tree.order.pop_back();
  tree.numbers.append_to(level, out);
  tree.rest.append_to(out);
  cuts.append_to(out);
  tree.halves.append_to(out);
  return std::move(tree.order);
}

}  // namespace

uint8_t tree_level(int speed, uint32_t axis_count) {
  const int level = std::min(10 - speed, int{KdTree::kMostLevel});
  return static_cast<uint8_t>(axis_count > kMostSelectedAxes ? std::min(level, KdTree::kMostLevel - 1) : level);
}

std::vector<uint32_t> encode_tree(TreePoints points, uint8_t level, std::vector<uint8_t>& out) {
  uint32_t all = 0;
  for (size_t at = 0; at < points.count * points.row_size(); at += points.row_size())
    for (uint32_t axis = 0; axis < points.axis_count; ++axis) all |= points.rows[at + axis];
  const auto bits = static_cast<uint32_t>(std::bit_width(all));
  append_u32(bits, out);
  append_u32(points.count, out);
  if (points.count == 0) return {};
  const bool is_by_choice = level == KdTree::kMostLevel;
  if (!PSPLIT_IS_SMALL_CODE && points.axis_count == 3)
    return is_by_choice ? encode<3, CutsByChoice>(points, level, bits, out)
                        : encode<3, CutsInTurn>(points, level, bits, out);
  return is_by_choice ? encode<0, CutsByChoice>(points, level, bits, out)
                      : encode<0, CutsInTurn>(points, level, bits, out);
}

}  // namespace psplit
