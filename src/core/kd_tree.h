// Points with whole coordinates, as a kD-tree. A box that holds all points is halved again and again, along one
// axis at a time; for each half the stream has the number of its points, and halves without points are left
// out. Where one or two points are left in a box, their last bits are stored plainly. The order of points is
// that of the tree.
//
//   +-------+---+---+    The box, halved along x, then y, then x. In a box of seven points, the upper half
//   |       |   | . |    along an axis has 7/2 - n or 7 - (7/2 - n) of them: `n` is a number of two bits, and
//   |   .   +---+---+    another bit says which half has fewer.
//   |  .. . |   |...|
//   +-------+---+---+
//
// Devillers, Gandoin: Geometric compression for interactive transmission, 2000.
#pragma once

#include "src/core/kd_tree_bits.h"

namespace psplit::core {

// An axis of the tree: a component of an attribute.
struct TreeAxis {
  View<int32_t> values;                // of the attribute, by point
  uint32_t component = 0, stride = 1;  // where the component is, and from one point to the next
  uint32_t base = 0;                   // the bits that are known of all points in the box; the others are 0
  uint32_t level = 0;                  // the number of known bits, from the highest
};

// Decodes a box a step, from the highest coordinates to the lowest. A box whose points are all in one half
// becomes that half. Otherwise the lower half waits on a stack, and the known bits of the upper half are undone
// when the lower half is taken: so the memory grows with the axes and not with their square.
class KdTree {
 public:
  static constexpr uint8_t kMostLevel = 6;
  // At the highest level, the stream says in kAxisBits bits along which axis a box of kFewestForAxis points or
  // more is halved.
  static constexpr uint32_t kAxisBits = 4, kFewestForAxis = 64;

  PSPLIT_HD static constexpr NumberCoding number_coding(uint8_t level) {
    return level < 2 ? NumberCoding::kPlain : level < 4 ? NumberCoding::kRans : NumberCoding::kFolded;
  }

  // Reads up to the points of the tree. `level` says how it is compressed, up to kMostLevel. Writes the
  // coordinates of `point_count` points to the values of `axes`, which are not known yet.
  PSPLIT_HD Fault start(ByteReader& reader, uint8_t level, uint32_t point_count, View<TreeAxis> axes,
                        Arena& arena) {
    axes_ = axes;
    selects_axes_ = level == kMostLevel;
    bits_ = reader.u32();
    count_ = reader.u32();
    if (reader.truncated()) return Fault::kTruncated;
    if (bits_ > 32) return Fault::kTree;
    if (count_ != point_count) return Fault::kCounts;
    if (count_ == 0) return Fault::kNone;
    Fault fault = numbers_.start(reader, number_coding(level));
    if (fault == Fault::kNone) fault = rest_.start(reader);
    if (fault == Fault::kNone) fault = selected_axes_.start(reader);
    if (fault == Fault::kNone) fault = halves_.start(reader);
    if (fault != Fault::kNone) return fault;
    const uint64_t most_splits = uint64_t{bits_} * axes.size();
    // Boxes that wait have different points.
    return arena.take(splits_, most_splits) &&
                   arena.take(waiting_, most_splits < point_count ? most_splits : point_count)
               ? Fault::kNone
               : Fault::kWorkspace;
  }
  // The memory that `start` takes, for coordinates of 32 bits.
  PSPLIT_HD static constexpr size_t bytes(uint64_t point_count, uint64_t axis_count) {
    const uint64_t most_splits = 32 * axis_count;
    return Arena::bytes<uint32_t>(most_splits) +
           Arena::bytes<Box>(most_splits < point_count ? most_splits : point_count);
  }

  PSPLIT_HD bool running() const { return count_ > 0 && fault_ == Fault::kNone; }
  PSPLIT_HD Fault fault() const { return fault_; }

  PSPLIT_HD void step() {
    const uint32_t axis = next_axis();
    if (axis >= axes_.size()) return stop(Fault::kTree);
    if (axes_[axis].level == bits_) {
      for (; count_ > 0; --count_, ++point_)
        for (size_t i = 0; i < axes_.size(); ++i) write(axes_[i], axes_[i].base);
      return take_waiting();
    }
    if (count_ <= 2) {
      for (; count_ > 0; --count_, ++point_)
        if (!read_point(axis)) return stop(Fault::kTruncated);
      return take_waiting();
    }
    split(axis);
  }

 private:
  // The lower half of a box that was split.
  struct Box {
    uint32_t point_count, split_count;
  };

  // The bit that tells the halves of an axis apart that has `level` known bits.
  PSPLIT_HD uint32_t half(uint32_t level) const { return 1u << (bits_ - 1 - level); }

  PSPLIT_HD uint32_t next_axis() {
    if (!selects_axes_) return last_axis_ + 1 == axes_.size() ? 0 : last_axis_ + 1;
    uint32_t axis = 0;
    if (count_ < kFewestForAxis) return coarsest_axis();
    (void)selected_axes_.read(kAxisBits, axis);
    return axis;
  }
  // The first axis of which the fewest bits are known. Levels only grow until a waiting box is taken, so it
  // looks on from where it was.
  PSPLIT_HD uint32_t coarsest_axis() {
    for (; coarsest_ < axes_.size(); ++coarsest_)
      if (axes_[coarsest_].level == coarsest_level_) return coarsest_;
    coarsest_ = 0;
    for (uint32_t i = 1; i < axes_.size(); ++i)
      if (axes_[i].level < axes_[coarsest_].level) coarsest_ = i;
    coarsest_level_ = axes_[coarsest_].level;
    return coarsest_;
  }

  PSPLIT_HD void split(uint32_t axis) {
    const uint32_t number = numbers_.read(floor_log2(count_));
    if (number > count_ / 2) return stop(Fault::kTree);
    uint32_t lower = count_ / 2 - number, upper = count_ - lower;
    uint32_t is_lower_smaller = 0;
    if (lower != upper) {
      (void)halves_.read(1, is_lower_smaller);
      if (is_lower_smaller == 0) {
        const uint32_t more = upper;
        upper = lower;
        lower = more;
      }
    }
    TreeAxis& split = axes_[axis];
    splits_[split_count_++] = last_axis_ = axis;
    ++split.level;
    if (upper == 0) return;
    split.base |= half(split.level - 1);
    if (lower > 0) waiting_[waiting_count_++] = {lower, split_count_};
    count_ = upper;
  }

  // Goes on with the box that was split last, or ends.
  PSPLIT_HD void take_waiting() {
    if (waiting_count_ == 0) return;
    const Box box = waiting_[--waiting_count_];
    while (split_count_ > box.split_count) {
      TreeAxis& axis = axes_[splits_[--split_count_]];
      axis.base &= ~half(--axis.level);
    }
    last_axis_ = splits_[split_count_ - 1];
    TreeAxis& axis = axes_[last_axis_];
    axis.base &= ~half(axis.level - 1);
    count_ = box.point_count;
    coarsest_ = static_cast<uint32_t>(axes_.size());  // look at all of them
  }

  // Reads the unknown bits of a point, beginning with an axis. Returns false if they end.
  PSPLIT_HD bool read_point(uint32_t first) {
    for (uint32_t i = 0, axis = first; i < axes_.size(); ++i, axis = axis + 1 == axes_.size() ? 0 : axis + 1) {
      uint32_t rest = 0;
      const uint32_t unknown = bits_ - axes_[axis].level;
      if (unknown > 0 && !rest_.read(unknown, rest)) return false;
      write(axes_[axis], axes_[axis].base | rest);
    }
    return true;
  }

  PSPLIT_HD void write(const TreeAxis& axis, uint32_t coordinate) {
    axis.values[size_t{point_} * axis.stride + axis.component] = static_cast<int32_t>(coordinate);
  }
  PSPLIT_HD void stop(Fault fault) { fault_ = fault; }

  View<TreeAxis> axes_;
  View<uint32_t> splits_;  // the axes along which the box was split
  View<Box> waiting_;
  uint32_t bits_ = 0;   // of a coordinate
  uint32_t count_ = 0;  // of points in the box
  uint32_t last_axis_ = 0, split_count_ = 0, waiting_count_ = 0, point_ = 0;
  // No axis has a lower level than coarsest_level_, and none before coarsest_ has that level.
  uint32_t coarsest_ = 0, coarsest_level_ = 0;
  bool selects_axes_ = false;
  Fault fault_ = Fault::kNone;
  TreeNumbers numbers_;
  PlainBits rest_, selected_axes_, halves_;
};

}  // namespace psplit::core
