#include "tools/gltf_psplit/diff/elements.h"

#include <algorithm>
#include <cstring>

#include "encoder/coding/quantization.h"
#include "src/mesh/number_of.h"

namespace psplit {

double ElementPart::number(size_t column, size_t point, size_t component) const {
  const double number = number_at(columns[column], point, component);
  return column == 0 && component < origin.size() ? number + origin[component] : number;
}

void ElementBag::add(ElementPart part) {
  first_.push_back(first_.back() + part.indices.count / 3);
  parts_.push_back(std::move(part));
}

ElementBag ElementBag::chosen(std::vector<uint32_t> elements) const {
  if (is_chosen_)
    for (uint32_t& element : elements) element = chosen_[element];
  ElementBag bag = *this;
  bag.is_chosen_ = true;
  bag.chosen_ = std::move(elements);
  return bag;
}

ElementBag::Located ElementBag::locate(uint32_t element) const {
  if (is_chosen_) element = chosen_[element];
  const auto behind = parts_.size() == 1 ? first_.begin() + 1 : std::ranges::upper_bound(first_, element);
  const auto part = static_cast<size_t>(behind - first_.begin()) - 1;
  const uint32_t number = element - first_[part];
  const ValuesView& indices = parts_[part].indices;
  Located located{part, number};
  if (indices.bytes.empty()) {
    located.points = {3 * number, 3 * number + 1, 3 * number + 2};
    return located;
  }
  const std::byte* const first = indices.at(size_t{3} * number);
  const size_t step = indices.step();
  const auto read = [&](auto index) {
    for (size_t corner = 0; corner < 3; ++corner) {
      std::memcpy(&index, first + corner * step, sizeof index);
      located.points[corner] = index;
    }
    return located;
  };
  switch (indices.value_bytes()) {
    case 1: return read(uint8_t{});
    case 2: return read(uint16_t{});
    default: return read(uint32_t{});
  }
}

void ElementBag::mark_flat(const Located& element) {
  ElementPart& part = parts_[element.part];
  part.is_flat.resize(part.indices.count / 3);
  part.is_flat[element.element] = true;
}

void ElementBag::forget_flat_parts(const std::vector<bool>& has_partner) {
  for (size_t i = 0; i < parts_.size(); ++i) {
    const auto begin = has_partner.begin() + first_[i], end = has_partner.begin() + first_[i + 1];
    if (std::find(begin, end, true) == end) parts_[i].is_flat.clear();
  }
}

void ElementBag::release() const {
  const auto release = [](const ValuesView& values) {
    release_mapped({reinterpret_cast<const uint8_t*>(values.bytes.data()), values.bytes.size()});
  };
  for (const ElementPart& part : parts_) {
    release(part.indices);
    for (const ValuesView& column : part.columns) release(column);
  }
}

bool ElementBag::is_degenerate(uint32_t element) const {
  if (corner_count_ != 3) return false;
  const Located located = locate(element);
  const ElementPart& part = parts_[located.part];
  if (!part.is_flat.empty() && part.is_flat[located.element]) return true;
  const ValuesView& position = part.columns[0];
  for (size_t corner = 0; corner < 3; ++corner) {
    const uint32_t one = located.points[corner], other = located.points[(corner + 1) % 3];
    bool same = true;
    for (size_t c = 0; one != other && same && c < position.component_count; ++c)
      same = component_distance(number_at(position, one, c), number_at(position, other, c)) == 0;
    if (same) return true;
  }
  return false;
}

double number_at(const ValuesView& values, size_t point, size_t component) {
  return number_of(values.at(point) + component * component_bytes(values.component_type), values.component_type,
                   values.normalized);
}

double ElementPair::limit(size_t column, size_t part_a, size_t part_b) const {
  const ColumnLimit& of_a = a_->parts()[part_a].limits[column];
  const ColumnLimit& of_b = b_->parts()[part_b].limits[column];
  return of_a.grid >= 0 && of_a.grid == of_b.grid ? 0 : of_a.within + of_b.within;
}

double ElementPair::largest_limit(size_t column) const {
  double sum = 0;
  bool one_grid = true;
  const int32_t grid = a_->parts().empty() ? -1 : a_->parts()[0].limits[column].grid;
  for (const ElementBag* const bag : {a_, b_}) {
    double largest = 0;
    for (const ElementPart& part : bag->parts()) {
      largest = std::max(largest, part.limits[column].within);
      one_grid &= part.limits[column].grid == grid;
    }
    sum += largest;
  }
  return one_grid && grid >= 0 ? 0 : sum;
}

double ElementPair::difference(size_t column, const ElementBag::Located& a, const ElementBag::Located& b,
                               int corner, int turn) const {
  const ValuesView& of_a = a_->parts()[a.part].columns[column];
  const ValuesView& of_b = b_->parts()[b.part].columns[column];
  const int corner_count = a_->corner_count();
  const uint32_t point_a = a.points[static_cast<size_t>(corner)];
  const uint32_t point_b = b.points[static_cast<size_t>((corner + turn) % corner_count)];
  const size_t components = of_a.component_count;
  const bool is_direction = directions_[column] && components >= 3 && limit(column, a.part, b.part) > 0;
  // The difference of origins is exact, and nothing is rounded where there is none.
  std::array<double, 3> apart{};
  for (size_t c = 0; column == 0 && c < apart.size(); ++c)
    apart[c] = a_->parts()[a.part].origin[c] - b_->parts()[b.part].origin[c];
  return value_distance(
      components, is_direction,
      [&](size_t c) { return number_at(of_a, point_a, c) + (c < apart.size() ? apart[c] : 0); },
      [&](size_t c) { return number_at(of_b, point_b, c); });
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
