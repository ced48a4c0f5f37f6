// Each mesh becomes a bag of elements (triangles, then points), each an ordered list of points. Elements whose
// bits and grid points agree are paired by sorting. The few remaining elements either have a value that was
// rounded to an adjacent grid point, or they really differ. They are paired by a maximum matching among
// elements that are near each other.
#include "tests/support/compare_meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <numeric>
#include <tuple>
#include <unordered_map>
#include <utility>

namespace psplit {
namespace {

using Corners = std::array<uint32_t, 3>;

float float_at(const Attribute& attribute, size_t point, size_t component) {
  float value;
  std::memcpy(&value, attribute.values.data() + point * attribute.stride() + component * sizeof value,
              sizeof value);
  return value;
}

struct Column {
  const Attribute* of[2];  // expected, actual
  Tolerance tolerance;
  int64_t steps = 0;  // grid steps that two equal values may differ by
};

int64_t snap(const Column& column, float value, size_t component) {
  const Tolerance& grid = column.tolerance;
  if (!std::isfinite(value)) return std::numeric_limits<int64_t>::max() / 8;
  const auto last = static_cast<float>((int64_t{1} << grid.bits) - 1);
  const float inverse = last / grid.range;
  const float scaled = std::floor((value - grid.origin[component]) * inverse + 0.5f);
  return static_cast<int64_t>(std::clamp(scaled, -1e12f, 1e12f));
}

// One step, plus the rounding error of single precision in steps if that is coarser than the grid.
int64_t allowed_steps(const Tolerance& grid) {
  double magnitude = 0;
  for (const float origin : grid.origin)
    magnitude =
        std::max({magnitude, std::fabs(double{origin}), std::fabs(double{origin} + double{grid.range})});
  const double step = double{grid.range} / static_cast<double>((int64_t{1} << grid.bits) - 1);
  return 1 + static_cast<int64_t>(std::min(1e9, std::floor(magnitude / step / (1 << 22))));
}

class Comparison {
 public:
  Comparison(const Mesh& expected, const Mesh& actual) : meshes_{&expected, &actual} {}

  std::string run(std::span<const Tolerance> per_attribute) {
    std::string difference = compare_shapes(per_attribute);
    if (!difference.empty()) return difference;
    number_points();
    std::vector<Corners> faces[2], used[2], unused[2];
    for (int side = 0; side < 2; ++side) {
      faces[side].assign(meshes_[side]->faces.begin(), meshes_[side]->faces.end());
      std::vector<bool> is_used(meshes_[side]->point_count);
      for (const Corners& face : faces[side])
        for (const uint32_t point : face) is_used[point] = true;
      for (uint32_t point = 0; point < is_used.size(); ++point)
        (is_used[point] ? used : unused)[side].push_back({point, point, point});
    }
    const auto count = [](const char* what, size_t a, size_t b) {
      return std::to_string(a) + " " + what + " expected, but " + std::to_string(b) + " found";
    };
    if (unused[0].size() != unused[1].size()) return count("unused points", unused[0].size(), unused[1].size());
    difference = compare_elements("face", faces[0], faces[1]);
    if (difference.empty()) difference = compare_elements("unused point", unused[0], unused[1]);
    if (difference.empty()) difference = compare_elements("point", used[0], used[1]);
    return difference;
  }

 private:
  std::string compare_shapes(std::span<const Tolerance> per_attribute) {
    const Mesh& expected = *meshes_[0];
    const Mesh& actual = *meshes_[1];
    if (!per_attribute.empty() && per_attribute.size() != expected.attributes.size())
      return "the comparison was given the wrong number of tolerances";
    if (expected.attributes.size() != actual.attributes.size())
      return std::to_string(expected.attributes.size()) + " attributes expected, but " +
             std::to_string(actual.attributes.size()) + " found";
    for (size_t i = 0; i < expected.attributes.size(); ++i) {
      const Attribute& a = expected.attributes[i];
      const Attribute* b = actual.find(a.semantic);
      if (b == nullptr) return a.semantic + " is missing";
      if (a.component_type != b->component_type || a.component_count != b->component_count ||
          a.normalized != b->normalized)
        return a.semantic + " has another type";
      Column column = {{&a, b}, per_attribute.empty() ? Tolerance{} : per_attribute[i]};
      Tolerance& tolerance = column.tolerance;
      if (tolerance.kind != Tolerance::Kind::kExact && a.component_type != ComponentType::kFloat32)
        return a.semantic + ": only floats have grids";
      if (tolerance.kind == Tolerance::Kind::kGrid) {
        if (tolerance.origin.size() != a.component_count)
          return a.semantic + ": the grid has the wrong dimension";
        column.steps = tolerance.range > 0 ? allowed_steps(tolerance) : 0;
      }
      if (tolerance.kind == Tolerance::Kind::kOctahedral && a.component_count != 3)
        return a.semantic + ": only vectors of three have an octahedral grid";
      columns_.push_back(std::move(column));
    }
    for (int side = 0; side < 2; ++side) {
      const std::string whose = side == 0 ? "expected mesh: " : "actual mesh: ";
      for (const Attribute& attribute : meshes_[side]->attributes)
        if (attribute.values.size() != attribute.stride() * meshes_[side]->point_count)
          return whose + attribute.semantic + " has the wrong number of values";
      for (const Corners& face : meshes_[side]->faces)
        if (std::ranges::max(face) >= meshes_[side]->point_count)
          return whose + "a face names a point that is not there";
    }
    if (expected.point_count != actual.point_count)
      return std::to_string(expected.point_count) + " points expected, but " +
             std::to_string(actual.point_count) + " found";
    if (expected.faces.size() != actual.faces.size())
      return std::to_string(expected.faces.size()) + " faces expected, but " +
             std::to_string(actual.faces.size()) + " found";
    return {};
  }

  // Points with the same key get the same number in both meshes. The key has all values except octahedral ones.
  void number_points() {
    size_t key_bytes = 0;
    for (const Column& column : columns_) {
      column_at_.push_back(key_bytes);
      if (column.tolerance.kind == Tolerance::Kind::kExact) key_bytes += column.of[0]->stride();
      if (column.tolerance.kind == Tolerance::Kind::kGrid)
        key_bytes += column.of[0]->component_count * sizeof(int64_t);
    }
    key_bytes_ = key_bytes;
    const size_t point_count = meshes_[0]->point_count;
    for (int side = 0; side < 2; ++side) {
      keys_[side].resize(point_count * key_bytes);
      for (size_t c = 0; c < columns_.size(); ++c)
        for (size_t point = 0; point < point_count; ++point) write_key(side, c, point);
    }
    std::vector<uint32_t> order(2 * point_count);
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](uint32_t i) {
      return i < point_count ? keys_[0].data() + i * key_bytes
                             : keys_[1].data() + (i - point_count) * key_bytes;
    };
    std::ranges::sort(order,
                      [&](uint32_t a, uint32_t b) { return std::memcmp(key(a), key(b), key_bytes) < 0; });
    numbers_[0].resize(point_count);
    numbers_[1].resize(point_count);
    uint32_t number = 0;
    for (size_t i = 0; i < order.size(); ++i) {
      if (i > 0 && std::memcmp(key(order[i - 1]), key(order[i]), key_bytes) != 0) ++number;
      (order[i] < point_count ? numbers_[0][order[i]] : numbers_[1][order[i] - point_count]) = number;
    }
  }

  void write_key(int side, size_t c, size_t point) {
    const Column& column = columns_[c];
    const Attribute& attribute = *column.of[side];
    std::byte* at = keys_[side].data() + point * key_bytes_ + column_at_[c];
    if (column.tolerance.kind == Tolerance::Kind::kExact)
      std::memcpy(at, attribute.values.data() + point * attribute.stride(), attribute.stride());
    if (column.tolerance.kind != Tolerance::Kind::kGrid) return;
    for (size_t i = 0; i < attribute.component_count; ++i) {
      const int64_t value = grid_value(column, side, point, i);
      std::memcpy(at + i * sizeof value, &value, sizeof value);
    }
  }

  static int64_t grid_value(const Column& column, int side, size_t point, size_t component) {
    const float value = float_at(*column.of[side], point, component);
    if (column.tolerance.range > 0) return snap(column, value, component);
    // A grid of one point cannot round anything, so the value itself is the key. Both zeros are the same value.
    const float no_sign_of_zero = value + 0.0f;
    uint32_t bits;
    std::memcpy(&bits, &no_sign_of_zero, sizeof bits);
    return bits;
  }

  bool points_match(uint32_t expected, uint32_t actual) const {
    const bool same_key = numbers_[0][expected] == numbers_[1][actual];
    for (const Column& column : columns_) {
      if (column.tolerance.kind == Tolerance::Kind::kOctahedral) {
        if (!normals_match(column, expected, actual)) return false;
      } else if (same_key) {
        continue;
      } else if (column.tolerance.kind == Tolerance::Kind::kExact) {
        const size_t stride = column.of[0]->stride();
        if (std::memcmp(column.of[0]->values.data() + expected * stride,
                        column.of[1]->values.data() + actual * stride, stride) != 0)
          return false;
      } else {
        for (size_t i = 0; i < column.of[0]->component_count; ++i)
          if (std::abs(grid_value(column, 0, expected, i) - grid_value(column, 1, actual, i)) > column.steps)
            return false;
      }
    }
    return true;
  }

  static bool normals_match(const Column& column, uint32_t expected, uint32_t actual) {
    double dot = 0, expected_square = 0, actual_square = 0;
    for (size_t i = 0; i < 3; ++i) {
      const double a = double{float_at(*column.of[0], expected, i)},
                   b = double{float_at(*column.of[1], actual, i)};
      dot += a * b;
      expected_square += a * a;
      actual_square += b * b;
    }
    if (std::fabs(actual_square - 1) > 1e-3) return false;
    if (!(expected_square > 0) || !std::isfinite(expected_square)) return true;
    // Half the diagonal of a grid cell, stretched by at most sqrt(3), where the octahedron is nearest to the
    // centre.
    const double angle = 4.0 / static_cast<double>((int64_t{1} << column.tolerance.bits) - 1) + 1e-3;
    const double cosine = dot / std::sqrt(expected_square * actual_square);
    return std::acos(std::clamp(cosine, -1.0, 1.0)) <= angle;
  }

  bool elements_match(const Corners& expected, const Corners& actual) const {
    for (size_t turn = 0; turn < 3; ++turn)
      if (points_match(expected[0], actual[turn]) && points_match(expected[1], actual[(turn + 1) % 3]) &&
          points_match(expected[2], actual[(turn + 2) % 3]))
        return true;
    return false;
  }

  struct Keyed {
    Corners key;  // the numbers of the corners, in the smallest rotation
    uint32_t element;
    bool operator<(const Keyed& other) const {
      return std::tie(key, element) < std::tie(other.key, other.element);
    }
  };

  std::vector<Keyed> sort_elements(int side, const std::vector<Corners>& elements) const {
    std::vector<Keyed> keyed(elements.size());
    for (uint32_t i = 0; i < elements.size(); ++i) {
      const std::vector<uint32_t>& number = numbers_[side];
      const auto [a, b, c] = std::array{number[elements[i][0]], number[elements[i][1]], number[elements[i][2]]};
      keyed[i] = {std::min({Corners{a, b, c}, Corners{b, c, a}, Corners{c, a, b}}), i};
    }
    std::sort(keyed.begin(), keyed.end());
    return keyed;
  }

  std::string compare_elements(const char* what, const std::vector<Corners>& expected,
                               const std::vector<Corners>& actual) {
    const std::vector<Keyed> left = sort_elements(0, expected), right = sort_elements(1, actual);
    std::vector<uint32_t> left_over, right_over;
    for (size_t i = 0, j = 0; i < left.size() || j < right.size();) {
      const bool from_left = j == right.size() || (i < left.size() && left[i].key <= right[j].key);
      const Corners key = from_left ? left[i].key : right[j].key;
      std::vector<uint32_t> a, b;
      for (; i < left.size() && left[i].key == key; ++i) a.push_back(left[i].element);
      for (; j < right.size() && right[j].key == key; ++j) b.push_back(right[j].element);
      const auto candidates = [&](size_t) -> const std::vector<uint32_t>& { return b; };
      pair_up(expected, actual, a, b, candidates, left_over, right_over);
    }
    if (left_over.empty() && right_over.empty()) return {};
    const bool may_round = std::ranges::any_of(columns_, [](const Column& column) { return column.steps > 0; });
    if (!may_round) return describe(what, expected, actual, left_over, right_over);

    // If elements match, each grid value is near its counterpart. So are their sums, which do not depend on the
    // rotation.
    std::unordered_map<uint64_t, std::vector<uint32_t>> cells;
    for (const uint32_t element : right_over) cells[cell_of(1, actual[element], {})].push_back(element);
    std::vector<std::vector<uint32_t>> near(left_over.size());
    // Only meshes with little in common have this many.
    size_t pairs_left = 20'000'000;
    for (size_t i = 0; i < left_over.size(); ++i)
      for (int64_t offset = 0; offset < 27; ++offset) {
        const std::array<int64_t, 3> shift = {offset % 3 - 1, offset / 3 % 3 - 1, offset / 9 - 1};
        const auto cell = cells.find(cell_of(0, expected[left_over[i]], shift));
        if (cell == cells.end() || cell->second.size() > pairs_left) continue;
        near[i].insert(near[i].end(), cell->second.begin(), cell->second.end());
        pairs_left -= cell->second.size();
      }
    std::vector<uint32_t> still_left, still_right;
    pair_up(
        expected, actual, left_over, right_over,
        [&](size_t i) -> const std::vector<uint32_t>& { return near[i]; }, still_left, still_right);
    if (still_left.empty() && still_right.empty()) return {};
    return describe(what, expected, actual, still_left, still_right);
  }

  // The cell in a coarse grid for the sums of an element's first three grid components.
  uint64_t cell_of(int side, const Corners& element, std::array<int64_t, 3> shift) const {
    uint64_t hash = 0;
    for (const Column& column : columns_) {
      if (column.tolerance.kind != Tolerance::Kind::kGrid || !(column.tolerance.range > 0)) continue;
      for (size_t i = 0; i < std::min<size_t>(3, column.of[0]->component_count); ++i) {
        int64_t sum = 0;
        for (const uint32_t point : element) sum += grid_value(column, side, point, i);
        const int64_t size = 3 * column.steps + 1;
        const int64_t cell = (sum >= 0 ? sum : sum - size + 1) / size + shift[i];
        hash = (hash ^ static_cast<uint64_t>(cell)) * 0x9e3779b97f4a7c15u;
      }
      break;
    }
    return hash;
  }

  // A maximum matching of a with b by augmenting paths. Unmatched elements are put into the two lists at the
  // end. candidates(i) are the elements that a[i] may be paired with.
  template <typename Candidates>
  void pair_up(const std::vector<Corners>& expected, const std::vector<Corners>& actual,
               const std::vector<uint32_t>& a, const std::vector<uint32_t>& b, const Candidates& candidates,
               std::vector<uint32_t>& left_over, std::vector<uint32_t>& right_over) const {
    constexpr size_t kFree = SIZE_MAX;
    if (a.size() == 1 && b.size() == 1 && elements_match(expected[a[0]], actual[b[0]])) return;
    std::unordered_map<uint32_t, size_t> taken_by;  // element of b -> index in a
    for (const uint32_t element : b) taken_by[element] = kFree;
    struct Step {
      size_t index, next;
    };
    for (size_t i = 0; i < a.size(); ++i) {
      std::unordered_map<uint32_t, bool> seen;
      std::vector<Step> path = {{i, 0}};
      std::vector<uint32_t> wanted;  // wanted[k]: the element that path[k] would be paired with
      bool found = false;
      while (!path.empty() && !found) {
        Step& step = path.back();
        const std::vector<uint32_t>& options = candidates(step.index);
        if (step.next == options.size()) {
          path.pop_back();
          if (!wanted.empty()) wanted.pop_back();
          continue;
        }
        // Commonly, a free partner is at the same place in its list, so look there first.
        const uint32_t option = options[(step.next++ + step.index) % options.size()];
        if (seen.contains(option) || !elements_match(expected[a[step.index]], actual[option])) continue;
        seen[option] = true;
        wanted.push_back(option);
        const size_t holder = taken_by[option];
        if (holder == kFree)
          found = true;
        else
          path.push_back({holder, 0});
      }
      if (!found) {
        left_over.push_back(a[i]);
        continue;
      }
      for (size_t k = 0; k < path.size(); ++k) taken_by[wanted[k]] = path[k].index;
    }
    for (const uint32_t element : b)
      if (taken_by[element] == kFree) right_over.push_back(element);
  }

  std::string describe(const char* what, const std::vector<Corners>& expected,
                       const std::vector<Corners>& actual, const std::vector<uint32_t>& left,
                       const std::vector<uint32_t>& right) const {
    if (left.empty())
      return std::string(what) + " " + name(actual, right[0]) +
             " is not expected: " + values(1, actual[right[0]]);
    std::string text = std::to_string(left.size()) + " of " + std::to_string(expected.size()) +
                       " differ: expected " + what + " " + name(expected, left[0]) +
                       " has no equal: " + values(0, expected[left[0]]);
    const Corners& first = expected[left[0]];
    for (const uint32_t element : right)
      if (elements_match({first[0], first[2], first[1]}, actual[element]))
        return text + "; face " + std::to_string(element) + " is its mirror image";
    if (!right.empty()) text += "; left over is " + name(actual, right[0]) + ": " + values(1, actual[right[0]]);
    return text;
  }

  static std::string name(const std::vector<Corners>& elements, uint32_t element) {
    const Corners& corners = elements[element];
    const bool is_point = corners[0] == corners[1] && corners[1] == corners[2];
    return std::to_string(is_point ? corners[0] : element);
  }

  // The positions of a few corners are enough to identify an element.
  std::string values(int side, const Corners& element) const {
    std::string text;
    for (const uint32_t point : element) {
      text += " (";
      for (const Column& column : columns_) {
        const Attribute& attribute = *column.of[side];
        if (attribute.component_type != ComponentType::kFloat32) continue;
        text += text.ends_with("(") ? attribute.semantic : ", " + attribute.semantic;
        for (size_t i = 0; i < attribute.component_count; ++i) {
          char digits[32];
          std::snprintf(digits, sizeof digits, " %.9g", double{float_at(attribute, point, i)});
          text += digits;
        }
      }
      text += ")";
      if (element[0] == element[1] && element[1] == element[2]) break;
    }
    return text;
  }

  const Mesh* meshes_[2];
  std::vector<Column> columns_;
  std::vector<size_t> column_at_;
  size_t key_bytes_ = 0;
  std::vector<std::byte> keys_[2];
  std::vector<uint32_t> numbers_[2];
};

}  // namespace

Tolerance exact_tolerance() { return {}; }

Tolerance grid_tolerance(int bits, std::vector<float> origin, float range) {
  return {Tolerance::Kind::kGrid, bits, std::move(origin), range};
}

Tolerance octahedral_tolerance(int bits) { return {Tolerance::Kind::kOctahedral, bits, {}, 0}; }

std::string compare_meshes(const Mesh& expected, const Mesh& actual, std::span<const Tolerance> per_attribute) {
  return Comparison(expected, actual).run(per_attribute);
}

}  // namespace psplit
