#include "src/container/condensed_directory.h"

#include <algorithm>
#include <limits>

#include "src/container/bit_string.h"

namespace psplit {
namespace {

// What a column's next value is expected to be: a base that the row knows, and about as much more as the rows
// before had.
class ExpectedSum {
 public:
  std::optional<int64_t> from(int64_t base) const { return base + (sixteenths_ >> 4); }
  void follow(int64_t base, int64_t value) {
    const int64_t step = value - base - (sixteenths_ >> 4);
    sixteenths_ = is_first_ ? 16 * step : sixteenths_ + step;
    is_first_ = false;
  }

 private:
  int64_t sixteenths_ = 0;  // of the mean
  bool is_first_ = true;
};

// The same for a value that is about in proportion to another one of its row, the scale.
class ExpectedRatio {
 public:
  // Nothing if the product has more than 63 bits.
  std::optional<int64_t> from(int64_t scale) const {
    scale = std::max<int64_t>(scale, 1);
    if (ratio_ > std::numeric_limits<int64_t>::max() / scale) return std::nullopt;
    return ratio_ * scale >> 10;
  }
  void follow(int64_t scale, int64_t value) {
    const int64_t sixty_fourths = value * 64 / std::max<int64_t>(scale, 1);
    ratio_ = is_first_ ? 16 * sixty_fourths : ratio_ + sixty_fourths - (ratio_ >> 4);
    is_first_ = false;
  }

 private:
  int64_t ratio_ = 0;  // in 1024ths, never negative
  bool is_first_ = true;
};

template <typename Expected>
struct Column {
  explicit Column(uint32_t order) : kind(order) {}
  core::NumberKind kind;
  Expected expected;
};

// Takes a row from bits. The functions of PutRow do the reverse.
class TakeRow {
 public:
  explicit TakeRow(std::span<const uint8_t> bytes) : bits_(bytes) {}

  void flag(bool& value) { value = bits_.bits(1) != 0; }
  void number(core::NumberKind& kind, uint32_t& value) { value = bits_.number(kind); }
  void distance(core::NumberKind& kind, std::optional<int64_t> expected, uint32_t& value) {
    const int64_t sum = expected.value_or(-1) + bits_.signed_number(kind);
    is_impossible_ |= !expected || sum < 0 || sum > 0xffffffff;
    value = static_cast<uint32_t>(sum);
  }
  bool failed() const { return is_impossible_ || bits_.broken(); }
  bool ends_here() { return bits_.ends_here(); }

 private:
  BitStringReader bits_;
  bool is_impossible_ = false;
};

class PutRow {
 public:
  void flag(bool value) { bits_.bits(value ? 1 : 0, 1); }
  void number(core::NumberKind& kind, uint32_t value) { bits_.number(kind, value); }
  void distance(core::NumberKind& kind, std::optional<int64_t> expected, uint32_t value) {
    const int64_t step = int64_t{value} - expected.value_or(0);
    is_impossible_ |= !expected || core::fold(step) > 0xffffffff;
    if (!is_impossible_) bits_.signed_number(kind, step);
  }
  bool failed() const { return is_impossible_; }
  std::vector<uint8_t> take() { return bits_.take(); }

 private:
  BitStringWriter bits_;
  bool is_impossible_ = false;
};

// The rows from the first on. Reader and writer share the order of the numbers and what is expected of them.
template <typename Way>
class Rows {
 public:
  Rows(Way way, uint32_t skeleton_count) : way_(std::move(way)), skeleton_count_(skeleton_count) {}

  Way& way() { return way_; }
  // `Entry` is const for PutRow. Returns false if the row does not exist, or cannot be written.
  template <typename Entry>
  bool next(Entry& entry) {
    way_.flag(entry.is_condensed);
    if (entry.is_condensed && skeleton_count_ == 0) return false;
    if (entry.is_condensed && skeleton_count_ > 1) {
      uint32_t skeleton = entry.skeleton;
      way_.number(skeleton_, skeleton);
      if (skeleton >= skeleton_count_) return false;
      if constexpr (!std::is_const_v<Entry>) entry.skeleton = static_cast<uint8_t>(skeleton);
    }
    near(faces_, 0, entry.face_count);
    near(points_, entry.face_count / 2, entry.point_count);
    near(references_, 0, entry.reference_count);
    if (entry.reference_count > 0) near(stitch_, entry.reference_count, entry.stitch_bytes);
    near(bytes_, entry.point_count, entry.stream_bytes);
    return !way_.failed();
  }

 private:
  // `known` is the base of a sum, or the scale of a ratio.
  template <typename Expected, typename Value>
  void near(Column<Expected>& column, int64_t known, Value& value) {
    way_.distance(column.kind, column.expected.from(known), value);
    if (!way_.failed()) column.expected.follow(known, value);
  }

  Way way_;
  uint32_t skeleton_count_;
  core::NumberKind skeleton_{0};
  Column<ExpectedSum> faces_{6}, points_{3}, references_{3};
  Column<ExpectedRatio> stitch_{2}, bytes_{6};
};

}  // namespace

uint32_t count_skeletons(std::span<const uint8_t> head) {
  core::NumberKind count(0);
  return head.empty() ? 0 : BitStringReader(head).number(count) + 1;
}

Status read_condensed_directory(std::span<const uint8_t> bytes, uint32_t skeleton_count,
                                std::span<StreamEntry> entries) {
  Rows<TakeRow> rows(TakeRow(bytes), skeleton_count);
  for (size_t i = 0; i < entries.size(); ++i)
    if (!rows.next(entries[i]))
      return invalid_input("directory: a row that ends early, or with an impossible number",
                           {.patch = static_cast<int64_t>(i)});
  return rows.way().ends_here() ? Status() : invalid_input("directory: it goes on after its last row");
}

std::optional<std::vector<uint8_t>> write_condensed_directory(std::span<const StreamEntry> entries,
                                                              uint32_t skeleton_count) {
  Rows<PutRow> rows(PutRow(), skeleton_count);
  for (const StreamEntry& entry : entries)
    if (!rows.next(entry)) return std::nullopt;
  return rows.way().take();
}

}  // namespace psplit
