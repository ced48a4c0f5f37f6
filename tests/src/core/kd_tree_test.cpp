// Trees that a straightforward encoder makes are decoded to their points; every broken one has a fault.
#include "src/core/kd_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/src/core/rans_encoder.h"

namespace psplit::core {
namespace {

using Bits = std::vector<bool>;
using Point = std::vector<uint32_t>;

void append_number(Bits& bits, uint32_t value, uint32_t count) {
  while (count-- > 0) bits.push_back((value >> count & 1) != 0);
}
void append_word(Bytes& bytes, uint32_t word) {
  for (int k = 0; k < 4; ++k) bytes.push_back(static_cast<uint8_t>(word >> 8 * k));
}
Bytes plain_block(Bits bits) {
  bits.resize((bits.size() / 32 + 1) * 32);
  Bytes bytes;
  append_word(bytes, static_cast<uint32_t>(bits.size() / 8));
  for (size_t i = 0; i < bits.size(); i += 32) {
    uint32_t word = 0;
    for (size_t k = 0; k < 32; ++k) word = word << 1 | uint32_t{bits[i + k]};
    append_word(bytes, word);
  }
  return bytes;
}

// The numbers of a tree, in each of their codings.
class Numbers {
 public:
  void append(uint32_t value, uint32_t count) {
    Bits bits;
    append_number(bits, value, count);
    for (size_t i = 0; i < bits.size(); ++i) all_.push_back(bits[i]), places_[i].push_back(bits[i]);
  }
  Bytes block(uint8_t level) const {
    constexpr uint8_t kProbZero = 100;
    if (level < 2) return plain_block(all_);
    if (level < 4) return encode_bits(all_, kProbZero);
    Bytes bytes;
    for (const Bits& place : places_) core::append(bytes, encode_bits(place, kProbZero));
    core::append(bytes, encode_bits({}, kProbZero));
    return bytes;
  }

 private:
  Bits all_, places_[32];
};

// Sorts the points into the order of the tree.
class TreeEncoder {
 public:
  TreeEncoder(uint8_t level, uint32_t bits, std::vector<Point>& points)
      : level_(level), bits_(bits), axes_(points.front().size()), points_(points) {
    split(points_.begin(), points_.end(), 0, std::vector<uint32_t>(axes_));
  }
  Bytes bytes() const {
    Bytes bytes;
    append_word(bytes, bits_);
    append_word(bytes, static_cast<uint32_t>(points_.size()));
    for (const Bytes& block :
         {numbers_.block(level_), plain_block(rest_), plain_block(selected_), plain_block(halves_)})
      append(bytes, block);
    return bytes;
  }

 private:
  using At = std::vector<Point>::iterator;

  uint32_t choose(size_t count, uint32_t last, const std::vector<uint32_t>& levels) {
    const auto coarsest =
        static_cast<uint32_t>(std::min_element(levels.begin(), levels.end()) - levels.begin());
    if (level_ < 6) return (last + 1) % static_cast<uint32_t>(axes_);
    if (count >= 64) append_number(selected_, coarsest, 4);
    return coarsest;
  }
  void split(At first, At end, uint32_t last, std::vector<uint32_t> levels) {
    const auto count = static_cast<uint32_t>(end - first);
    if (count == 0) return;
    const uint32_t axis = choose(count, last, levels);
    if (levels[axis] == bits_) return;
    if (count <= 2) {
      for (; first != end; ++first)
        for (uint32_t k = 0; k < axes_; ++k) {
          const uint32_t at = (axis + k) % static_cast<uint32_t>(axes_), left = bits_ - levels[at];
          append_number(rest_, (*first)[at], left);
        }
      return;
    }
    const uint32_t half = bits_ - 1 - levels[axis];
    const At middle =
        std::stable_partition(first, end, [&](const Point& point) { return (point[axis] >> half & 1) != 0; });
    const auto upper = static_cast<uint32_t>(middle - first), lower = count - upper;
    numbers_.append(count / 2 - std::min(lower, upper), floor_log2(count));
    if (lower != upper) halves_.push_back(lower < upper);
    ++levels[axis];
    split(first, middle, axis, levels);
    split(middle, end, axis, levels);
  }

  uint8_t level_;
  uint32_t bits_;
  size_t axes_;
  std::vector<Point>& points_;
  Numbers numbers_;
  Bits rest_, selected_, halves_;
};

// Decodes the tree into one attribute.
Fault decode(const Bytes& bytes, uint8_t level, uint32_t point_count, size_t axis_count,
             std::vector<int32_t>& values, size_t memory_bytes) {
  values.assign(point_count * axis_count, -1);
  std::vector<TreeAxis> axes(axis_count);
  for (uint32_t k = 0; k < axis_count; ++k) {
    axes[k].values = {values.data(), values.size()};
    axes[k].component = k;
    axes[k].stride = static_cast<uint32_t>(axis_count);
  }
  std::vector<uint8_t> memory(memory_bytes);
  Arena arena(memory.data(), memory.size());
  ByteReader reader(bytes.data(), bytes.size());
  KdTree tree;
  const Fault fault = tree.start(reader, level, point_count, {axes.data(), axes.size()}, arena);
  if (fault != Fault::kNone) return fault;
  while (tree.running()) tree.step();
  if (tree.fault() == Fault::kNone) {
    EXPECT_EQ(reader.remaining(), 0u);
  }
  return tree.fault();
}
Fault decode(const Bytes& bytes, uint8_t level, uint32_t point_count, size_t axis_count,
             std::vector<int32_t>& values) {
  return decode(bytes, level, point_count, axis_count, values, KdTree::bytes(point_count, axis_count));
}

TEST(KdTree, DecodesWhatWasEncoded) {
  std::mt19937 random(1);
  for (uint8_t level = 0; level <= KdTree::kMostLevel; ++level)
    for (const uint32_t bits : {1u, 2u, 9u, 31u, 32u})
      for (const size_t axes : {1u, 2u, 3u, 7u, 15u, 100u})
        for (const uint32_t count : {1u, 2u, 3u, 10u, 63u, 64u, 300u}) {
          if (level == KdTree::kMostLevel && axes > 15 && count >= 64) continue;  // the axis takes four bits
          std::vector<Point> points(count, Point(axes));
          const bool is_clustered = random() % 2 == 0;
          for (Point& point : points)
            for (uint32_t& x : point)
              x = static_cast<uint32_t>((is_clustered && random() % 4 != 0 ? 5u : random()) &
                                        ((uint64_t{1} << bits) - 1));
          const Bytes bytes = TreeEncoder(level, bits, points).bytes();
          std::vector<int32_t> values;
          SCOPED_TRACE("level " + std::to_string(level) + ", " + std::to_string(bits) + " bits, " +
                       std::to_string(axes) + " axes, " + std::to_string(count) + " points");
          ASSERT_STREQ(fault_text(decode(bytes, level, count, axes, values)), fault_text(Fault::kNone));
          for (uint32_t i = 0; i < count; ++i)
            for (size_t k = 0; k < axes; ++k)
              ASSERT_EQ(static_cast<uint32_t>(values[i * axes + k]), points[i][k]) << i << ", " << k;
        }
}

TEST(KdTree, CoordinatesWithoutBitsAre0) {
  std::vector<Point> points(5, Point(3));
  const Bytes bytes = TreeEncoder(6, 0, points).bytes();
  std::vector<int32_t> values;
  ASSERT_EQ(decode(bytes, 6, 5, 3, values), Fault::kNone);
  EXPECT_EQ(values, std::vector<int32_t>(15));
}

// Equal points split a box once for each bit of each axis. The search for the next axis looks at each of them
// once for a bit, not once for a split.
TEST(KdTree, DecodesThousandsOfAxes) {
  constexpr uint32_t kAxes = 20'000, kPoints = 40;
  std::vector<Point> points(kPoints, Point(kAxes));
  Numbers numbers;
  for (uint32_t i = 0; i < 32 * kAxes; ++i) numbers.append(kPoints / 2, floor_log2(kPoints));
  Bytes bytes;
  append_word(bytes, 32);
  append_word(bytes, kPoints);
  append(bytes, numbers.block(6));
  for (int k = 0; k < 3; ++k) append(bytes, plain_block({}));  // without bits, the lower half has more points
  std::vector<int32_t> values;
  ASSERT_STREQ(fault_text(decode(bytes, 6, kPoints, kAxes, values)), fault_text(Fault::kNone));
  EXPECT_EQ(std::ranges::count(values, 0), std::ssize(values));
}

class BrokenTree : public testing::Test {
 protected:
  // Fields of a tree of four points with two axes of three bits.
  uint32_t bits = 3, count = 4;
  Bits numbers, rest, selected, halves;

  Bytes bytes() const {
    Bytes bytes;
    append_word(bytes, bits);
    append_word(bytes, count);
    for (const Bits& block : {numbers, rest, selected, halves}) append(bytes, plain_block(block));
    return bytes;
  }
  Fault fault(uint8_t level = 0) const {
    std::vector<int32_t> values;
    return decode(bytes(), level, 4, 2, values);
  }
};

TEST_F(BrokenTree, IsWholeBefore) { EXPECT_EQ(fault(), Fault::kNone); }
TEST_F(BrokenTree, HasTooManyBits) {
  bits = 33;
  EXPECT_EQ(fault(), Fault::kTree);
}
TEST_F(BrokenTree, HasAnotherNumberOfPoints) {
  count = 5;
  EXPECT_EQ(fault(), Fault::kCounts);
}
TEST_F(BrokenTree, SplitsMorePointsThanItHas) {
  append_number(numbers, 3, 2);
  EXPECT_EQ(fault(), Fault::kTree);
}
TEST_F(BrokenTree, EndsBeforeTheLastBits) {
  bits = 30;  // four points have 230 bits left, and the block has 32
  EXPECT_EQ(fault(), Fault::kTruncated);
}
TEST_F(BrokenTree, EndsBeforeABlock) {
  Bytes whole = bytes();
  std::vector<int32_t> values;
  for (size_t size = 0; size < whole.size(); ++size) {
    const Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(decode(part, 0, 4, 2, values), Fault::kTruncated) << size;
  }
}
TEST_F(BrokenTree, NeedsMemory) {
  std::vector<int32_t> values;
  EXPECT_EQ(decode(bytes(), 0, 4, 2, values, 8), Fault::kWorkspace);
}

TEST(KdTree, SelectsAnAxisThatDoesNotExist) {
  std::vector<Point> points(64, Point(2));
  Bytes bytes = TreeEncoder(6, 3, points).bytes();
  // The blocks of selected axes and of halves are the last ones, of one word each.
  const size_t word = bytes.size() - 12;
  bytes[word + 3] = 0x20;
  std::vector<int32_t> values;
  EXPECT_EQ(decode(bytes, 6, 64, 2, values), Fault::kTree);
}

TEST(PlainBits, ReadsAcrossWordsAndStopsAtTheEnd) {
  Bytes bytes;
  for (const uint32_t word : {8u, 0x89abcdefu, 0x01234567u}) append_word(bytes, word);
  ByteReader reader(bytes.data(), bytes.size());
  PlainBits bits;
  ASSERT_EQ(bits.start(reader), Fault::kNone);
  EXPECT_EQ(reader.remaining(), 0u);
  uint32_t value = 7;
  EXPECT_TRUE(bits.read(4, value));
  EXPECT_EQ(value, 8u);
  EXPECT_TRUE(bits.read(32, value));
  EXPECT_EQ(value, 0x9abcdef0u);
  EXPECT_FALSE(bits.read(29, value));
  EXPECT_EQ(value, 0x9abcdef0u);
  EXPECT_TRUE(bits.read(28, value));
  EXPECT_EQ(value, 0x1234567u);
  EXPECT_FALSE(bits.read(1, value));
}

TEST(PlainBits, AreWholeWords) {
  for (const uint32_t size : {0u, 1u, 2u, 3u, 5u}) {
    Bytes bytes;
    append_word(bytes, size);
    bytes.resize(16);
    ByteReader reader(bytes.data(), bytes.size());
    EXPECT_EQ(PlainBits().start(reader), Fault::kEntropy) << size;
  }
}

}  // namespace
}  // namespace psplit::core
