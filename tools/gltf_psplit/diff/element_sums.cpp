#include "tools/gltf_psplit/diff/element_sums.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <mutex>

#include "encoder/coding/grid_places.h"
#include "encoder/coding/quantization.h"
#include "system/content_hash.h"

namespace psplit {
namespace {

constexpr uint32_t kElementsOfATask = 1u << 15;
constexpr uint32_t kElementsOfARound = 1u << 20;  // memory of files is released after each

struct ElementSum {
  uint64_t low = 0, high = 0;
  std::vector<double> rounded_off;  // in each column, the most
  std::vector<uint32_t> left_out{};

  void add(const Hash128& hash) {
    low += hash.low;
    high += hash.high + (low < hash.low ? 1 : 0);
  }
  void add(const ElementSum& other) {
    add(Hash128{other.high, other.low});
    for (size_t i = 0; i < rounded_off.size(); ++i)
      rounded_off[i] = std::max(rounded_off[i], other.rounded_off[i]);
    left_out.insert(left_out.end(), other.left_out.begin(), other.left_out.end());
  }
};

// Writes the values of one point as they are hashed.
void write_point(const ElementPart& part, uint32_t point, const RoundingGrids& grids, uint8_t* to,
                 ElementSum& sum) {
  constexpr size_t kMostComponents = 16;
  for (size_t i = 0; i < part.columns.size(); ++i) {
    const ValuesView& column = part.columns[i];
    const size_t bytes = column.value_bytes();
    std::memcpy(to, column.at(point), bytes);
    if (column.component_type == ComponentType::kFloat32) {
      std::array<float, kMostComponents> from, rounded;
      std::memcpy(from.data(), to, bytes);
      rounded = from;
      const std::span<float> value(rounded.data(), column.component_count);
      if (grids[i] != nullptr) {
        round_to_grid(value, *grids[i]);
        const double off = value_distance(
            value.size(), grids[i]->octahedral, [&](size_t c) { return double{from[c]}; },
            [&](size_t c) { return double{value[c]}; });
        sum.rounded_off[i] = std::max(sum.rounded_off[i], off);
      }
      for (float& number : value)
        if (number == 0) number = 0;  // without a sign
      std::memcpy(to, rounded.data(), bytes);
    }
    to += bytes;
  }
}

ElementSum sum_of(const ElementBag& bag, uint32_t first, uint32_t end, const RoundingGrids& grids) {
  size_t size = 0;
  for (const ValuesView& column : bag.parts()[0].columns) size += column.value_bytes();
  const auto corner_count = static_cast<size_t>(bag.corner_count());
  // The corners twice, so that each turn is a range of them.
  std::vector<uint8_t> corners(2 * corner_count * size);
  const size_t position_bytes = bag.parts()[0].columns[0].value_bytes();
  const auto same_position = [&](size_t a, size_t b) {
    return std::memcmp(corners.data() + a * size, corners.data() + b * size, position_bytes) == 0;
  };
  ElementSum sum{0, 0, std::vector<double>(grids.size())};
  for (uint32_t i = first; i < end; ++i) {
    const ElementBag::Located element = bag.locate(i);
    for (size_t c = 0; c < corner_count; ++c)
      write_point(bag.parts()[element.part], element.points[c], grids, corners.data() + c * size, sum);
    if (corner_count == 3 && (same_position(0, 1) || same_position(1, 2) || same_position(2, 0))) {
      sum.left_out.push_back(i);
      continue;
    }
    std::memcpy(corners.data() + corner_count * size, corners.data(), corner_count * size);
    const uint8_t* least = corners.data();
    for (size_t c = 1; c < corner_count; ++c)
      if (std::memcmp(corners.data() + c * size, least, corner_count * size) < 0)
        least = corners.data() + c * size;
    sum.add(hash_of({reinterpret_cast<const char*>(least), corner_count * size}));
  }
  return sum;
}

ElementSum sum_of(const ElementBag& bag, const RoundingGrids& grids, const ThreadPool& pool) {
  ElementSum total{0, 0, std::vector<double>(grids.size())};
  std::mutex mutex;
  for (uint64_t round = 0; round < bag.size(); round += kElementsOfARound) {
    const uint64_t end = std::min<uint64_t>(round + kElementsOfARound, bag.size());
    pool.for_each((end - round + kElementsOfATask - 1) / kElementsOfATask, [&](size_t task) {
      const uint64_t first = round + task * kElementsOfATask;
      const ElementSum sum = sum_of(bag, static_cast<uint32_t>(first),
                                    static_cast<uint32_t>(std::min(first + kElementsOfATask, end)), grids);
      const std::lock_guard lock(mutex);
      total.add(sum);
    });
    bag.release();
  }
  return total;
}

// Whether all parts of both bags store a column in the same type.
bool have_same_types(const ElementPair& pair) {
  const std::vector<ValuesView>& columns = pair.a().parts()[0].columns;
  for (const ElementBag* bag : {&pair.a(), &pair.b()})
    for (const ElementPart& part : bag->parts())
      for (size_t i = 0; i < columns.size(); ++i)
        if (part.columns[i].component_type != columns[i].component_type ||
            part.columns[i].normalized != columns[i].normalized)
          return false;
  return true;
}

// Equal numbers are equal positions only then.
bool have_one_origin(const ElementPair& pair) {
  for (const ElementBag* bag : {&pair.a(), &pair.b()})
    for (const ElementPart& part : bag->parts())
      if (part.origin != pair.a().parts()[0].origin) return false;
  return true;
}

}  // namespace

std::optional<EqualSums> equal_sums(const ElementPair& pair, const RoundingGrids& grids_of_a,
                                    const RoundingGrids& grids_of_b, const ThreadPool& pool) {
  if (!have_same_types(pair) || !have_one_origin(pair)) return std::nullopt;
  ElementSum a = sum_of(pair.a(), grids_of_a, pool), b = sum_of(pair.b(), grids_of_b, pool);
  if (a.low != b.low || a.high != b.high ||
      pair.a().size() - a.left_out.size() != pair.b().size() - b.left_out.size())
    return std::nullopt;
  for (size_t i = 0; i < a.rounded_off.size(); ++i)
    a.rounded_off[i] = std::max(a.rounded_off[i], b.rounded_off[i]);
  for (ElementSum* sum : {&a, &b}) std::ranges::sort(sum->left_out);  // tasks end in any order
  return EqualSums{std::move(a.rounded_off), {std::move(a.left_out), std::move(b.left_out)}};
}

}  // namespace psplit
