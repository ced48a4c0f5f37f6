// Triangles, segments and points of two assets, as the values at their corners: how far two elements are apart,
// and how far apart they may be.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "gltf_ext/primitive/accessors.h"

namespace psplit {

// How far the values of a column may be from the original values.
struct ColumnLimit {
  double within = 0;  // for a component; for directions, for the chord between unit vectors
  int32_t grid = -1;  // values of two parts on the same grid must be equal; -1 means no grid
};

// Elements of one primitive. The caller owns the data that it points to.
struct ElementPart {
  ValuesView indices;               // three for each element, of which the first corner_count count
  std::vector<ValuesView> columns;  // the first is POSITION
  std::vector<ColumnLimit> limits;  // one for each column
  std::vector<bool> is_flat{};      // see mark_flat; empty if none is
  std::array<double, 3> origin{};   // what the positions are relative to

  // The number that a component means, counted from the same origin in all parts.
  double number(size_t column, size_t point, size_t component) const;
};

// Elements of several primitives with consecutive numbers.
class ElementBag {
 public:
  // 3 for triangles, 2 for segments, 1 for points.
  explicit ElementBag(int corner_count) : corner_count_(corner_count) {}
  void add(ElementPart part);
  // A bag of some elements of this one, which get the numbers 0, 1, 2 ...
  ElementBag chosen(std::vector<uint32_t> elements) const;

  struct Located {
    size_t part = 0;
    uint32_t element = 0;  // of the part
    std::array<uint32_t, 3> points{};
  };
  Located locate(uint32_t element) const;
  // ElementPart::number at a corner of an element.
  double number(const Located& element, size_t column, int corner, size_t component) const {
    return parts_[element.part].number(column, element.points[static_cast<size_t>(corner)], component);
  }
  uint32_t size() const { return static_cast<uint32_t>(is_chosen_ ? chosen_.size() : first_.back()); }
  int corner_count() const { return corner_count_; }
  const std::vector<ElementPart>& parts() const { return parts_; }

  // Two corners of the element have the same position on a grid of the other side.
  void mark_flat(const Located& element);
  // Whether two corners of a triangle have the same position, here or on a grid of the other side.
  bool is_degenerate(uint32_t element) const;
  // Forgets the marks of parts of which no element has a partner: the grids of the other side are not theirs.
  void forget_flat_parts(const std::vector<bool>& has_partner);
  // Returns the memory of mapped files to the system.
  void release() const;

 private:
  int corner_count_;
  bool is_chosen_ = false;
  std::vector<uint32_t> chosen_;
  std::vector<ElementPart> parts_;
  std::vector<uint32_t> first_{0};
};

// The number that a component means: a fraction for normalized integers.
double number_at(const ValuesView& values, size_t point, size_t component);

// Two bags with the same columns. An attribute has the same number of components in every part.
class ElementPair {
 public:
  // directions[i]: whether the first three components of column i are a direction of any length. Directions are
  // compared so unless their values must be equal.
  ElementPair(const ElementBag& a, const ElementBag& b, std::vector<bool> directions)
      : a_(&a), b_(&b), directions_(std::move(directions)) {}

  const ElementBag& a() const { return *a_; }
  const ElementBag& b() const { return *b_; }
  // A pair of some elements of either bag.
  ElementPair of(const ElementBag& a, const ElementBag& b) const { return {a, b, directions_}; }
  size_t column_count() const { return directions_.size(); }
  bool is_direction(size_t column) const { return directions_[column]; }

  // How far apart two values of the column may be in these parts.
  double limit(size_t column, size_t part_a, size_t part_b) const;
  // The largest limit for any two parts.
  double largest_limit(size_t column) const;

  // How far apart two corners are in a column: the largest difference of a component, or a chord. Infinite if
  // one value is NaN. `turn`: corner 0 of `a` is compared with corner `turn` of `b`.
  double difference(size_t column, const ElementBag::Located& a, const ElementBag::Located& b, int corner,
                    int turn) const;
  // How well the elements fit: 0 means equal, and less is better. Nothing if a value exceeds its limit.
  std::optional<double> fit(const ElementBag::Located& a, const ElementBag::Located& b, int turn) const;

 private:
  const ElementBag* a_;
  const ElementBag* b_;
  std::vector<bool> directions_;
};

}  // namespace psplit
