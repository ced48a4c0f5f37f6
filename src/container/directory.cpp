#include "src/container/directory.h"

#include <algorithm>

#include "src/container/bit_string.h"
#include "src/container/condensed_head.h"

namespace psplit {
namespace {

// Predicts the next value of a column: a base that the row knows, and the mean by which earlier rows exceeded
// theirs.
class ExpectedSum {
 public:
  int64_t from(int64_t base) const { return base + (sixteenths_ >> 4); }
  void follow(int64_t base, int64_t value) {
    const int64_t step = value - from(base);
    sixteenths_ = is_first_ ? 16 * step : sixteenths_ + step;
    is_first_ = false;
  }

 private:
  int64_t sixteenths_ = 0;  // of the mean
  bool is_first_ = true;
};

// Predicts a value that is roughly proportional to another one of its row, the scale.
class ExpectedRatio {
 public:
  int64_t from(int64_t scale) const { return ratio_ * std::max<int64_t>(scale, 1) >> 10; }
  void follow(int64_t scale, int64_t value) {
    const int64_t sixty_fourths = std::min(value * 64 / std::max<int64_t>(scale, 1), kMostSixtyFourths);
    ratio_ = is_first_ ? 16 * sixty_fourths : ratio_ + sixty_fourths - (ratio_ >> 4);
    is_first_ = false;
  }

 private:
  // So that all products have less than 53 bits, which also a double holds exactly.
  static constexpr int64_t kMostSixtyFourths = (1 << 17) - 1;

  int64_t ratio_ = 0;  // in 1024ths, never negative
  bool is_first_ = true;
};

template <typename Expected>
struct Column {
  explicit Column(uint32_t order) : kind(order) {}
  core::NumberKind kind;
  Expected expected;
};

// Takes numbers from bits. The functions of PutNumbers do the reverse.
class TakeNumbers {
 public:
  explicit TakeNumbers(std::span<const uint8_t> bytes) : bits_(bytes) {}

  void flag(bool& value) { value = bits_.bits(1) != 0; }
  void number(core::NumberKind& kind, uint32_t& value) { value = bits_.number(kind); }
  void distance(core::NumberKind& kind, int64_t expected, uint32_t& value) {
    value = static_cast<uint32_t>(expected + bits_.signed_number(kind));
  }
  bool broken() const { return bits_.broken(); }
  bool ends_here() { return bits_.ends_here(); }

 private:
  BitStringReader bits_;
};

class PutNumbers {
 public:
  void flag(bool value) { bits_.bits(value ? 1 : 0, 1); }
  void number(core::NumberKind& kind, uint32_t value) { bits_.number(kind, value); }
  void distance(core::NumberKind& kind, int64_t expected, uint32_t value) {
    bits_.signed_number(kind, static_cast<int32_t>(value - static_cast<uint32_t>(expected)));
  }
  bool broken() const { return false; }
  std::vector<uint8_t> take() { return bits_.take(); }

 private:
  BitStringWriter bits_;
};

// The directory from its first number on. Reader and writer share the order of the numbers and their
// predictions.
template <typename Way>
class Rows {
 public:
  explicit Rows(Way way) : way_(std::move(way)) {}

  Way& way() { return way_; }
  // How many skeletons there are, and whether patches are stored beside condensed ones.
  void begin(uint32_t& skeleton_count, bool& is_mixed) {
    core::NumberKind count(0);
    way_.number(count, skeleton_count);
    if (skeleton_count > 0) way_.flag(is_mixed);
    skeleton_count_ = skeleton_count;
    is_mixed_ = is_mixed;
  }
  // `Entry` is const for PutNumbers. Returns false if the row ends early or has no skeleton.
  template <typename Entry>
  bool next(Entry& entry, bool is_residue) {
    if (!is_residue && skeleton_count_ > 0 && !next_skeleton(entry)) return false;
    near(faces_, 0, entry.face_count);
    near(points_, entry.face_count / 2, entry.point_count);
    near(references_, 0, entry.reference_count);
    if (entry.reference_count > 0) near(stitch_, entry.reference_count, entry.stitch_bytes);
    near(bytes_, entry.point_count, entry.stream_bytes);
    return !way_.broken();
  }

 private:
  template <typename Entry>
  bool next_skeleton(Entry& entry) {
    bool is_condensed = true;
    uint32_t skeleton = 0;
    if constexpr (std::is_const_v<Entry>) is_condensed = entry.is_condensed, skeleton = entry.skeleton;
    if (is_mixed_) way_.flag(is_condensed);
    if (is_condensed && skeleton_count_ > 1) way_.number(skeletons_, skeleton);
    if constexpr (!std::is_const_v<Entry>) {
      entry.is_condensed = is_condensed;
      entry.skeleton = static_cast<uint8_t>(skeleton);
    }
    return !is_condensed || skeleton < skeleton_count_;
  }
  // `known` is the base of a sum, or the scale of a ratio.
  template <typename Expected, typename Value>
  void near(Column<Expected>& column, int64_t known, Value& value) {
    way_.distance(column.kind, column.expected.from(known), value);
    column.expected.follow(known, value);
  }

  Way way_;
  uint32_t skeleton_count_ = 0;
  bool is_mixed_ = false;
  core::NumberKind skeletons_{0};
  Column<ExpectedSum> faces_{6}, points_{3}, references_{3};
  Column<ExpectedRatio> stitch_{2}, bytes_{6};
};

}  // namespace

Expected<uint32_t> read_directory(std::span<const uint8_t> bytes, bool has_residue,
                                  std::span<StreamEntry> entries) {
  Rows<TakeNumbers> rows{TakeNumbers(bytes)};
  uint32_t skeleton_count = 0;
  bool is_mixed = false;
  rows.begin(skeleton_count, is_mixed);
  if (skeleton_count > kMostSkeletons) return invalid_input("directory: more than 255 skeletons");
  for (size_t i = 0; i < entries.size(); ++i)
    if (!rows.next(entries[i], has_residue && i + 1 == entries.size()))
      return invalid_input("directory: a row that ends early, or names a skeleton that does not exist",
                           {.patch = static_cast<int64_t>(i)});
  if (!rows.way().ends_here()) return invalid_input("directory: it goes on after its last row");
  return skeleton_count;
}

std::vector<uint8_t> write_directory(std::span<const StreamEntry> entries, bool has_residue) {
  const auto patches = entries.first(entries.size() - (has_residue ? 1 : 0));
  uint32_t skeleton_count = 0;
  bool is_mixed = false;
  for (const StreamEntry& entry : patches) {
    if (entry.is_condensed) skeleton_count = std::max(skeleton_count, entry.skeleton + 1u);
    is_mixed |= !entry.is_condensed;
  }
  Rows<PutNumbers> rows{PutNumbers()};
  rows.begin(skeleton_count, is_mixed);
  for (size_t i = 0; i < entries.size(); ++i) rows.next(entries[i], i >= patches.size());
  return rows.way().take();
}

}  // namespace psplit
