// Triangles, segments and points of two assets side by side, as what stands at their corners: how far apart two
// of them are, and how far they may be.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "src/mesh/mesh.h"

namespace psplit {

// How far the values of a column may be from those that they stand for.
struct ColumnLimit {
  double within = 0;  // of a component; of directions, the chord between unit vectors
  int32_t grid = -1;  // values of parts on the same grid must be equal; -1 is none
};

// Elements of one primitive. What it refers to is the caller's.
struct ElementPart {
  std::span<const std::array<uint32_t, 3>> elements;  // points, of which the bag's corner_count count
  std::vector<const Attribute*> columns;              // the first is POSITION
  std::vector<ColumnLimit> limits;                    // one for each column
};

// Elements of several primitives, numbered through.
class ElementBag {
 public:
  // 3 for triangles, 2 for segments, 1 for points.
  explicit ElementBag(int corner_count) : corner_count_(corner_count) {}
  void add(ElementPart part);

  struct Located {
    size_t part = 0;
    uint32_t element = 0;  // of the part
    std::array<uint32_t, 3> points{};
  };
  Located locate(uint32_t element) const;
  uint32_t size() const { return first_.back(); }
  int corner_count() const { return corner_count_; }
  const std::vector<ElementPart>& parts() const { return parts_; }

  // Whether two corners of a triangle stand at the same position.
  bool is_degenerate(uint32_t element) const;

 private:
  int corner_count_;
  std::vector<ElementPart> parts_;
  std::vector<uint32_t> first_{0};
};

// One component as the number that it means: of normalized integers, a fraction.
double number_at(const Attribute& attribute, size_t point, size_t component);

// Two bags of the same columns, whose attributes have as many components in every part.
class ElementPair {
 public:
  // directions[i]: whether the first three components of column i are a direction, of any length, where values
  // may differ.
  ElementPair(const ElementBag& a, const ElementBag& b, std::vector<bool> directions)
      : a_(&a), b_(&b), directions_(std::move(directions)) {}

  const ElementBag& a() const { return *a_; }
  const ElementBag& b() const { return *b_; }
  size_t column_count() const { return directions_.size(); }
  bool is_direction(size_t column) const { return directions_[column]; }

  // How far values of the column may be apart in these parts.
  double limit(size_t column, size_t part_a, size_t part_b) const;
  // The most that this is for any parts.
  double largest_limit(size_t column) const;

  // How far two corners are apart in a column: the largest difference of a component, or a chord; infinite
  // where one of them is no number. `turn`: corner 0 of `a` stands beside corner `turn` of `b`.
  double difference(size_t column, const ElementBag::Located& a, const ElementBag::Located& b, int corner,
                    int turn) const;
  // Nothing where a value is beyond its limit, or else how well the elements fit: less is better, 0 is equal.
  std::optional<double> fit(const ElementBag::Located& a, const ElementBag::Located& b, int turn) const;

 private:
  const ElementBag* a_;
  const ElementBag* b_;
  std::vector<bool> directions_;
};

}  // namespace psplit
