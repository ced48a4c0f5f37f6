#include "gltf_ext/compare/elements.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "gltf_ext/primitive/number_of.h"

namespace psplit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double number_difference(double a, double b) {
  if (a == b || std::bit_cast<uint64_t>(a) == std::bit_cast<uint64_t>(b)) return 0;
  const double difference = std::fabs(a - b);
  return std::isnan(difference) ? kInfinity : difference;
}

// A vector of length 0 has no direction: every result of an encoder is right.
double chord(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  const double length_a = std::hypot(a[0], a[1], a[2]), length_b = std::hypot(b[0], b[1], b[2]);
  if (length_a == 0 || length_b == 0) return 0;
  double square = 0;
  for (size_t i = 0; i < 3; ++i) square += std::pow(a[i] / length_a - b[i] / length_b, 2);
  return std::isnan(square) ? kInfinity : std::sqrt(square);
}

}  // namespace

void ElementBag::add(ElementPart part) {
  first_.push_back(first_.back() + static_cast<uint32_t>(part.elements.size()));
  parts_.push_back(std::move(part));
}

ElementBag::Located ElementBag::locate(uint32_t element) const {
  const auto behind = parts_.size() == 1 ? first_.begin() + 1 : std::ranges::upper_bound(first_, element);
  const auto part = static_cast<size_t>(behind - first_.begin()) - 1;
  const uint32_t number = element - first_[part];
  return {part, number, parts_[part].elements[number]};
}

void ElementBag::forget_flat_parts(const std::vector<uint8_t>& has_partner) {
  for (size_t i = 0; i < parts_.size(); ++i) {
    const auto begin = has_partner.begin() + first_[i], end = has_partner.begin() + first_[i + 1];
    if (std::find(begin, end, uint8_t{1}) == end) parts_[i].is_flat.clear();
  }
}

bool ElementBag::is_degenerate(uint32_t element) const {
  if (corner_count_ != 3) return false;
  const Located located = locate(element);
  const ElementPart& part = parts_[located.part];
  if (!part.is_flat.empty() && part.is_flat[located.element]) return true;
  const Attribute& position = *part.columns[0];
  for (size_t corner = 0; corner < 3; ++corner) {
    const uint32_t one = located.points[corner], other = located.points[(corner + 1) % 3];
    bool same = true;
    for (size_t c = 0; one != other && same && c < position.component_count; ++c)
      same = number_difference(number_at(position, one, c), number_at(position, other, c)) == 0;
    if (same) return true;
  }
  return false;
}

double number_at(const Attribute& attribute, size_t point, size_t component) {
  const size_t index = point * attribute.component_count + component;
  return number_of(attribute.values.data() + index * component_bytes(attribute.component_type),
                   attribute.component_type, attribute.normalized);
}

double ElementPair::limit(size_t column, size_t part_a, size_t part_b) const {
  const ColumnLimit& of_a = a_->parts()[part_a].limits[column];
  const ColumnLimit& of_b = b_->parts()[part_b].limits[column];
  return of_a.grid >= 0 && of_a.grid == of_b.grid ? 0 : of_a.within + of_b.within;
}

double ElementPair::largest_limit(size_t column) const {
  double of_a = 0, of_b = 0;
  bool one_grid = true;
  const int32_t grid = a_->parts().empty() ? -1 : a_->parts()[0].limits[column].grid;
  for (const ElementPart& part : a_->parts()) {
    of_a = std::max(of_a, part.limits[column].within);
    one_grid &= part.limits[column].grid == grid;
  }
  for (const ElementPart& part : b_->parts()) {
    of_b = std::max(of_b, part.limits[column].within);
    one_grid &= part.limits[column].grid == grid;
  }
  return one_grid && grid >= 0 ? 0 : of_a + of_b;
}

double ElementPair::difference(size_t column, const ElementBag::Located& a, const ElementBag::Located& b,
                               int corner, int turn) const {
  const Attribute& of_a = *a_->parts()[a.part].columns[column];
  const Attribute& of_b = *b_->parts()[b.part].columns[column];
  const int corner_count = a_->corner_count();
  const uint32_t point_a = a.points[static_cast<size_t>(corner)];
  const uint32_t point_b = b.points[static_cast<size_t>((corner + turn) % corner_count)];
  const size_t components = of_a.component_count;
  double largest = 0;
  size_t c = 0;
  if (directions_[column] && components >= 3 && limit(column, a.part, b.part) > 0) {
    std::array<double, 3> vector_a, vector_b;
    for (; c < 3; ++c) {
      vector_a[c] = number_at(of_a, point_a, c);
      vector_b[c] = number_at(of_b, point_b, c);
    }
    largest = vector_a == vector_b ? 0 : chord(vector_a, vector_b);
  }
  for (; c < components; ++c)
    largest = std::max(largest, number_difference(number_at(of_a, point_a, c), number_at(of_b, point_b, c)));
  return largest;
}

std::optional<double> ElementPair::fit(const ElementBag::Located& a, const ElementBag::Located& b,
                                       int turn) const {
  double sum = 0;
  for (size_t column = 0; column < directions_.size(); ++column) {
    const double most = limit(column, a.part, b.part);
    for (int corner = 0; corner < a_->corner_count(); ++corner) {
      const double apart = difference(column, a, b, corner, turn);
      if (!(apart <= most)) return std::nullopt;
      if (apart > 0) sum += (apart / most) * (apart / most);
    }
  }
  return sum;
}

}  // namespace psplit
