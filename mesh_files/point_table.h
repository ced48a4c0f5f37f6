// The points of a mesh file whose format repeats them at every corner.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

namespace psplit {

// Points in the order in which they came first, found through a hash table with at least twice as many slots. A
// Point has == and hash().
template <typename Point>
class PointTable {
 public:
  // The index of the point, and whether it is new.
  std::pair<uint32_t, bool> find_or_add(const Point& point) {
    if (slots_.size() < 2 * (points_.size() + 1)) grow();
    const size_t slot = slot_of(point);
    const bool is_new = slots_[slot] == kFree;
    if (is_new) {
      slots_[slot] = static_cast<uint32_t>(points_.size());
      points_.push_back(point);
    }
    return {slots_[slot], is_new};
  }

  const std::vector<Point>& points() const { return points_; }
  void drop_table() { slots_ = {}; }
  void clear() {
    points_.clear();
    slots_.clear();
  }

 private:
  static constexpr uint32_t kFree = UINT32_MAX;

  // The slot of the point, or the free one that it would take.
  size_t slot_of(const Point& point) const {
    const size_t mask = slots_.size() - 1;
    size_t slot = point.hash() & mask;
    while (slots_[slot] != kFree && !(points_[slots_[slot]] == point)) slot = (slot + 1) & mask;
    return slot;
  }

  void grow() {
    slots_.assign(std::bit_ceil(std::max<size_t>(64, 4 * points_.size())), kFree);
    for (uint32_t i = 0; i < points_.size(); ++i) slots_[slot_of(points_[i])] = i;
  }

  std::vector<Point> points_;
  std::vector<uint32_t> slots_;
};

}  // namespace psplit
