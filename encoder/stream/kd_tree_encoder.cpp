#include "encoder/stream/kd_tree_encoder.h"

#include <algorithm>
#include <bit>
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
  // The lowest `count` bits, 1 to 32.
  void write(uint32_t value, uint32_t count) {
    pending_ = pending_ << count | (value & ((uint64_t{1} << count) - 1));
    pending_count_ += count;
    if (pending_count_ < 32) return;
    pending_count_ -= 32;
    words_.push_back(static_cast<uint32_t>(pending_ >> pending_count_));
  }
  // The last word may be without bits.
  void append_to(std::vector<uint8_t>& out) {
    words_.push_back(static_cast<uint32_t>(pending_ << (32 - pending_count_)));
    append_u32(static_cast<uint32_t>(words_.size() * sizeof(uint32_t)), out);
    for (const uint32_t word : words_) append_u32(word, out);
  }

 private:
  std::vector<uint32_t> words_;
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

// With `kAxes` 0, the number of axes is that of the points.
template <uint32_t kAxes>
class TreeEncoder {
 public:
  TreeEncoder(TreePoints points, uint8_t level)
      : points_(std::move(points)), level_(level), known_(axis_count()) {}

  std::vector<uint32_t> encode(std::vector<uint8_t>& out) {
    const uint32_t count = points_.count();
    uint32_t all = 0;
    for (uint32_t i = 0; i < count; ++i)
      for (uint32_t axis = 0; axis < axis_count(); ++axis) all |= row(i)[axis];
    bits_ = static_cast<uint32_t>(std::bit_width(all));
    append_u32(bits_, out);
    append_u32(count, out);
    if (count == 0) return {};
    order_.reserve(count);
    walk(count);
    numbers_.append_to(level_, out);
    rest_.append_to(out);
    selected_axes_.append_to(out);
    halves_.append_to(out);
    return std::move(order_);
  }

 private:
  struct Box {
    uint32_t begin = 0, end = 0, split_count = 0;
    uint32_t size() const { return end - begin; }
  };
  static constexpr uint32_t kBlock = 64;

  uint32_t axis_count() const { return kAxes != 0 ? kAxes : points_.axis_count; }
  uint32_t* row(uint32_t i) { return points_.rows.data() + size_t{i} * (axis_count() + 1); }

  void walk(uint32_t count) {
    Box box{0, count, 0};
    while (true) {
      const uint32_t axis = next_axis(box);
      if (known_[axis] == bits_ || box.size() <= 2) {
        for (uint32_t i = box.begin; i < box.end; ++i) write_point(row(i), axis);
        if (waiting_.empty()) return;
        box = waiting_.back();
        waiting_.pop_back();
        while (splits_.size() > box.split_count) {
          --known_[splits_.back()];
          splits_.pop_back();
        }
        last_axis_ = splits_.back();
        continue;
      }
      split(box, axis);
    }
  }

  // The bit that tells the halves of an axis apart.
  uint32_t half_bit(uint32_t axis) const { return 1u << (bits_ - 1 - known_[axis]); }

  uint32_t next_axis(const Box& box) {
    if (level_ != KdTree::kMostLevel) return last_axis_ + 1 == axis_count() ? 0 : last_axis_ + 1;
    if (box.size() >= KdTree::kFewestForAxis) return evenest_axis(box);
    return static_cast<uint32_t>(std::min_element(known_.begin(), known_.end()) - known_.begin());
  }
  // The first axis whose larger half has the most points: so points stay together.
  uint32_t evenest_axis(const Box& box) {
    const uint32_t axes = axis_count();
    uint32_t bits[kMostSelectedAxes] = {}, upper[kMostSelectedAxes] = {};
    for (uint32_t axis = 0; axis < axes; ++axis) bits[axis] = known_[axis] < bits_ ? half_bit(axis) : 0;
    for (uint32_t i = box.begin; i < box.end; ++i) {
      const uint32_t* const point = row(i);
      for (uint32_t axis = 0; axis < axes; ++axis) upper[axis] += (point[axis] & bits[axis]) != 0 ? 1 : 0;
    }
    uint32_t best = 0, most = 0;
    for (uint32_t axis = 0; axis < axes; ++axis) {
      if (bits[axis] == 0) continue;
      const uint32_t larger = std::max(upper[axis], box.size() - upper[axis]);
      if (larger > most) most = larger, best = axis;
    }
    selected_axes_.write(best, KdTree::kAxisBits);
    return best;
  }

  void split(Box& box, uint32_t axis) {
    const uint32_t size = box.size(), lower = move_upper_half(box, axis, half_bit(axis)), upper = size - lower;
    const uint32_t smaller = std::min(lower, upper);
    numbers_.push(size / 2 - smaller, core::floor_log2(size));
    if (lower != upper) halves_.write(lower < upper ? 1 : 0, 1);
    splits_.push_back(axis);
    last_axis_ = axis;
    ++known_[axis];
    const uint32_t middle = box.begin + lower;
    if (upper == 0) return;
    if (lower > 0) waiting_.push_back({box.begin, middle, static_cast<uint32_t>(splits_.size())});
    box.begin = middle;
  }

  // Moves the points of the upper half behind the others, and returns how many others there are. Points that
  // share all bits, or are two in a box, are stored in the order that the moves give them. It is that of
  // std::partition: the first point on the wrong side and the last one change places, and so on.
  uint32_t move_upper_half(const Box& box, uint32_t axis, uint32_t bit) {
    const uint32_t size = box.size();
    if (size <= kBlock) {
      const uint64_t is_upper = upper_points(box.begin, size, axis, bit);
      if (is_upper == 0) return size;
      const auto lower = size - static_cast<uint32_t>(std::popcount(is_upper));
      const uint64_t front = (uint64_t{1} << lower) - 1;
      uint64_t wrong_front = is_upper & front;
      uint64_t wrong_back = ~is_upper & ~front & (~uint64_t{0} >> (kBlock - size));
      for (; wrong_front != 0; wrong_front &= wrong_front - 1) {
        const auto last = 63 - static_cast<uint32_t>(std::countl_zero(wrong_back));
        swap_rows(box.begin + static_cast<uint32_t>(std::countr_zero(wrong_front)), box.begin + last);
        wrong_back ^= uint64_t{1} << last;
      }
      return lower;
    }
    uint32_t lower = 0;
    for (uint32_t i = box.begin; i < box.end; ++i) lower += (row(i)[axis] & bit) == 0 ? 1 : 0;
    const uint32_t middle = box.begin + lower;
    uint64_t wrong_front = 0, wrong_back = 0;
    uint32_t front = box.begin, back = box.end, front_end = front, back_begin = back;
    while (true) {
      while (wrong_front == 0) {
        if (front_end == middle) return lower;
        front = front_end;
        front_end = std::min(front + kBlock, middle);
        wrong_front = upper_points(front, front_end - front, axis, bit);
      }
      while (wrong_back == 0) {
        back = back_begin;
        back_begin = std::max(back, middle + kBlock) - kBlock;
        const uint32_t count = back - back_begin;
        wrong_back = ~upper_points(back_begin, count, axis, bit) & (~uint64_t{0} >> (kBlock - count));
      }
      for (; wrong_front != 0 && wrong_back != 0; wrong_front &= wrong_front - 1) {
        const auto last = 63 - static_cast<uint32_t>(std::countl_zero(wrong_back));
        swap_rows(front + static_cast<uint32_t>(std::countr_zero(wrong_front)), back_begin + last);
        wrong_back ^= uint64_t{1} << last;
      }
    }
  }
  // A bit for each of up to kBlock points.
  uint64_t upper_points(uint32_t begin, uint32_t count, uint32_t axis, uint32_t bit) {
    uint64_t points = 0;
    for (uint32_t i = 0; i < count; ++i) points |= uint64_t{(row(begin + i)[axis] & bit) != 0} << i;
    return points;
  }
  void swap_rows(uint32_t a, uint32_t b) { std::swap_ranges(row(a), row(a) + axis_count() + 1, row(b)); }

  // The unknown bits of a point, beginning with an axis.
  void write_point(const uint32_t* point, uint32_t first) {
    for (uint32_t i = 0, axis = first; i < axis_count(); ++i, axis = axis + 1 == axis_count() ? 0 : axis + 1)
      if (const uint32_t unknown = bits_ - known_[axis]; unknown > 0) rest_.write(point[axis], unknown);
    order_.push_back(point[axis_count()]);
  }

  TreePoints points_;
  const uint8_t level_;
  uint32_t bits_ = 0;            // of a coordinate
  std::vector<uint32_t> known_;  // for each axis the number of bits that all points of the box share
  std::vector<uint32_t> splits_, order_;
  std::vector<Box> waiting_;
  uint32_t last_axis_ = 0;
  NumberList numbers_;
  PlainBitWriter rest_, selected_axes_, halves_;
};

}  // namespace

uint8_t tree_level(int speed, uint32_t axis_count) {
  const int level = std::min(10 - speed, int{KdTree::kMostLevel});
  return static_cast<uint8_t>(axis_count > kMostSelectedAxes ? std::min(level, KdTree::kMostLevel - 1) : level);
}

std::vector<uint32_t> encode_tree(TreePoints points, uint8_t level, std::vector<uint8_t>& out) {
  if (points.axis_count == 3) return TreeEncoder<3>(std::move(points), level).encode(out);
  return TreeEncoder<0>(std::move(points), level).encode(out);
}

}  // namespace psplit
