#include "tools/gltf_psplit/diff/compare_group.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "encoder/coding/grid_places.h"
#include "encoder/coding/quantization.h"
#include "gltf_ext/convert/memory_model.h"
#include "tools/gltf_psplit/diff/column_limits.h"
#include "tools/gltf_psplit/diff/element_sums.h"
#include "tools/gltf_psplit/diff/match_elements.h"

namespace psplit {
namespace {

bool has_rounded_weights(AssetPrimitives primitives) {
  return std::ranges::any_of(primitives, [](const AssetPrimitive* primitive) {
    return std::ranges::any_of(primitive->grids,
                               [](const auto& grid) { return grid.first.starts_with("WEIGHTS_"); });
  });
}

// A copy in which weights whose sum is nearly 1 are scaled, so that it is 1.
AssetPrimitive mend_weights(const AssetPrimitive& primitive) {
  constexpr double kWorthMending = 0.02;
  AssetPrimitive mended = primitive;
  std::vector<std::pair<ValuesView*, std::span<float>>> weights;
  for (MeshView::Values& attribute : mended.view.attributes) {
    ValuesView& values = attribute.values;
    if (!attribute.semantic.starts_with("WEIGHTS_") || values.component_type != ComponentType::kFloat32)
      continue;
    const auto numbers = std::make_shared<std::vector<float>>();
    for (size_t i = 0; i < size_t{values.count} * values.component_count; ++i)
      numbers->push_back(
          static_cast<float>(number_at(values, i / values.component_count, i % values.component_count)));
    mended.owned.push_back(numbers);
    values.bytes = std::as_bytes(std::span(*numbers));
    values.stride = 0;
    weights.emplace_back(&values, *numbers);
  }
  for (size_t point = 0; point < mended.view.point_count; ++point) {
    const auto for_each_weight = [&](const auto& visit) {
      for (const auto& [values, numbers] : weights)
        for (float& weight : numbers.subspan(point * values->component_count, values->component_count))
          visit(weight);
    };
    double sum = 0;
    for_each_weight([&](float weight) { sum += double{weight}; });
    if (std::fabs(sum - 1) <= kWorthMending)
      for_each_weight([&](float& weight) { weight = static_cast<float>(double{weight} / sum); });
  }
  return mended;
}

std::vector<double> values_at(const ElementBag& bag, const ElementBag::Located& element, size_t column,
                              int corner) {
  std::vector<double> values;
  for (size_t c = 0; c < bag.parts()[element.part].columns[column].component_count; ++c)
    values.push_back(bag.number(element, column, corner, c));
  return values;
}

using Names = std::vector<std::pair<std::string, int>>;

// Marks the triangles of a part of `bag` of which two corners have the same position on a grid of `others`: an
// encoder that rounds before it makes faces drops those.
void mark_flat_faces(const AssetPrimitive& primitive, AssetPrimitives others, uint32_t first, ElementBag& bag) {
  const ValuesView& position = *primitive.view.find("POSITION");
  if (primitive.corner_count != 3 || position.component_type != ComponentType::kFloat32) return;
  std::map<std::string, const AttributeCoding*> grids;
  for (const AssetPrimitive* other : others)
    if (const auto found = other->grids.find("POSITION");
        found != other->grids.end() && other->origin == primitive.origin)
      grids.emplace(found->second.identity, &found->second.coding);
  grids.erase("");
  if (const auto own = primitive.grids.find("POSITION"); own != primitive.grids.end())
    grids.erase(own->second.identity);
  std::array<std::vector<float>, 3> places;
  for (std::vector<float>& place : places) place.resize(position.component_count);
  for (const auto& [identity, grid] : grids) {
    if (grid->origin.size() != position.component_count) continue;
    for (uint32_t i = 0; i < primitive.element_count(); ++i) {
      const ElementBag::Located element = bag.locate(first + i);
      for (size_t corner = 0; corner < 3; ++corner) {
        std::memcpy(places[corner].data(), position.at(element.points[corner]), position.value_bytes());
        round_to_grid(places[corner], *grid);
      }
      if (places[0] == places[1] || places[1] == places[2] || places[2] == places[0]) bag.mark_flat(element);
    }
  }
}

// Compares the elements of two sides.
class GroupComparer {
 public:
  GroupComparer(AssetPrimitives a, AssetPrimitives b, const CompareRules& rules)
      : primitives_{a, b},
        names_(compared_attributes(*a[0], rules)),
        bags_{ElementBag(a[0]->corner_count), ElementBag(a[0]->corner_count)} {
    ColumnLimiter limiter(a, b, rules);
    std::vector<ColumnLimits> limits;
    for (const auto& [name, components] : names_) limits.push_back(limiter.limits_of(name));
    for (const ColumnLimits& column : limits) directions_.push_back(column.direction);
    tears_ = tears_in(limits[0]);
    for (const size_t side : {0u, 1u})
      for (size_t i = 0; i < primitives_[side].size(); ++i) {
        const MeshView& mesh = primitives_[side][i]->view;
        ElementPart part{mesh.indices, {}, {}};
        part.origin = primitives_[side][i]->origin;
        for (size_t column = 0; column < names_.size(); ++column) {
          part.columns.push_back(*mesh.find(names_[column].first));
          part.limits.push_back(limits[column].limits[side][i]);
        }
        bags_[side].add(std::move(part));
      }
    for (const size_t side : {0u, 1u})
      for (size_t column = 0; column < names_.size(); ++column)
        grids_[side].push_back(limits[column].stated ? nullptr : grid_for(side, names_[column].first));
  }

  Expected<AssetComparison> run(const CompareMeans& means) {
    const ElementPair pair(bags_[0], bags_[1], directions_);
    const Expected<ElementMatch> match = match_all(pair, means);
    if (!match) return match.status();
    AssetComparison result;
    for (size_t column = 0; column < names_.size(); ++column)
      result.values.push_back({names_[column].first, match->largest[column], pair.largest_limit(column)});
    std::ranges::sort(result.values, {}, &AssetComparison::Values::attribute);
    const auto& [of_a, of_b] = match->has_partner;
    // A grid is that of a part only if some of its elements are in the other file.
    bags_[0].forget_flat_parts(of_a);
    bags_[1].forget_flat_parts(of_b);
    const std::optional<uint32_t> first_a = count_alone(bags_[0], of_a, result.a);
    const std::optional<uint32_t> first_b = count_alone(bags_[1], of_b, result.b);
    if (first_a)
      result.first = describe(pair, *first_a, of_b, /*in_b=*/false);
    else if (first_b)
      result.first = describe(ElementPair(bags_[1], bags_[0], directions_), *first_b, of_a, /*in_b=*/true);
    else if (match->tear)
      result.first = describe(*match);
    return result;
  }

 private:
  // The grid of the other side, if all its primitives share it and none of this side has one. Weights are not
  // rounded alone.
  const AttributeCoding* grid_for(size_t side, const std::string& name) const {
    const AttributeCoding* grid = nullptr;
    const std::string* identity = nullptr;
    for (const AssetPrimitive* primitive : primitives_[1 - side]) {
      const auto found = primitive->grids.find(name);
      if (found == primitive->grids.end() || found->second.identity.empty() ||
          (identity != nullptr && found->second.identity != *identity))
        return nullptr;
      identity = &found->second.identity;
      grid = &found->second.coding;
    }
    for (const AssetPrimitive* primitive : primitives_[side]) {
      const ValuesView& values = *primitive->view.find(name);
      if (primitive->grids.contains(name) || values.component_type != ComponentType::kFloat32 ||
          values.component_count != (grid->octahedral ? 3 : grid->origin.size()))
        return nullptr;
    }
    return name.starts_with("WEIGHTS_") ? nullptr : grid;
  }

  // Elements whose sums are equal need no search.
  Expected<ElementMatch> match_all(const ElementPair& pair, const CompareMeans& means) {
    MatchLimits limits;
    constexpr uint64_t kLeastWindow = 4096;
    if (means.memory > 0) limits.window = std::max(kLeastWindow, means.memory / kMatchedElement);
    std::optional<EqualSums> sums = equal_sums(pair, grids_[0], grids_[1], means.pool);
    for (size_t column = 0; sums && column < names_.size(); ++column)
      if (sums->rounded_off[column] > pair.largest_limit(column)) sums.reset();
    if (!sums) {
      for (const size_t side : {0u, 1u}) {
        uint32_t first = 0;
        for (const AssetPrimitive* primitive : primitives_[side]) {
          mark_flat_faces(*primitive, primitives_[1 - side], first, bags_[side]);
          first += primitive->element_count();
        }
      }
      return match_elements(pair, tears_, limits);
    }
    for (const size_t side : {0u, 1u})
      for (const uint32_t element : sums->left_out[side]) bags_[side].mark_flat(bags_[side].locate(element));
    const ElementBag rest[] = {bags_[0].chosen(sums->left_out[0]), bags_[1].chosen(sums->left_out[1])};
    Expected<ElementMatch> match = match_elements(pair.of(rest[0], rest[1]), TearSearch::kNone, limits);
    if (!match) return match;
    for (size_t column = 0; column < names_.size(); ++column)
      match->largest[column] = std::max(match->largest[column], sums->rounded_off[column]);
    for (const size_t side : {0u, 1u}) {
      std::vector<bool> has_partner(bags_[side].size(), true);
      for (size_t i = 0; i < sums->left_out[side].size(); ++i)
        has_partner[sums->left_out[side][i]] = match->has_partner[side][i];
      match->has_partner[side] = std::move(has_partner);
    }
    return match;
  }

  static std::optional<uint32_t> count_alone(const ElementBag& bag, const std::vector<bool>& has_partner,
                                             AssetComparison::Counts& counts) {
    std::optional<uint32_t> first;
    for (uint32_t i = 0; i < bag.size(); ++i) {
      if (has_partner[i]) continue;
      const bool degenerate = bag.is_degenerate(i);
      ++(degenerate ? counts.degenerate_alone : counts.alone);
      if (!degenerate && !first) first = i;
    }
    return first;
  }

  AssetDifference at(size_t side, const ElementBag::Located& element) const {
    AssetDifference difference;
    difference.in_b = side == 1;
    difference.mesh = static_cast<int64_t>(primitives_[side][element.part]->id.mesh);
    difference.primitive = static_cast<int64_t>(primitives_[side][element.part]->id.primitive);
    difference.element = element.element;
    difference.corner_count = bags_[side].corner_count();
    return difference;
  }

  // The nearest element of the other side that has no partner: by positions first, then by the number of values
  // beyond their limits.
  struct Nearest {
    std::optional<uint32_t> element;
    int turn = 0;
    double apart = INFINITY;  // sum of squared distances of positions beyond their limit
    int off = 0;              // number of values beyond their limit
  };
  static Nearest nearest(const ElementPair& pair, const ElementBag::Located& element,
                         const std::vector<bool>& has_partner) {
    Nearest best;
    for (uint32_t i = 0; i < pair.b().size(); ++i) {
      if (has_partner[i]) continue;
      const ElementBag::Located other = pair.b().locate(i);
      for (int turn = 0; turn < pair.a().corner_count(); ++turn) {
        Nearest candidate{i, turn, 0};
        for (int corner = 0; corner < pair.a().corner_count(); ++corner)
          for (size_t column = 0; column < pair.column_count(); ++column) {
            const double apart = pair.difference(column, element, other, corner, turn);
            const bool off = apart > pair.limit(column, element.part, other.part);
            candidate.off += off;
            if (column == 0 && off) candidate.apart += apart * apart;
          }
        if (!best.element || std::tie(candidate.apart, candidate.off) < std::tie(best.apart, best.off))
          best = candidate;
      }
    }
    return best;
  }

  // has_partner[i] says whether element i of the other side has a partner.
  AssetDifference describe(const ElementPair& pair, uint32_t element, const std::vector<bool>& has_partner,
                           bool in_b) const {
    const ElementBag::Located located = pair.a().locate(element);
    AssetDifference difference = at(in_b ? 1 : 0, located);
    const Nearest near = nearest(pair, located, has_partner);
    if (stands_there(pair, located)) {
      difference.what = "occurs more often than in the other file";
      return difference;
    }
    // The position of a corner shows where the element is.
    difference.what = "has no counterpart";
    difference.attribute = names_[0].first;
    difference.corner = 0;
    difference.value = values_at(pair.a(), located, 0, 0);
    if (!near.element) return difference;
    const ElementBag::Located other = pair.b().locate(*near.element);
    difference.partner = other.element;
    if (is_mirrored(pair, located, other)) {
      difference.what = "is mirrored";
      return difference;
    }
    difference.what = "differs";
    for (int corner = 0; corner < pair.a().corner_count(); ++corner)
      for (size_t column = 0; column < names_.size(); ++column) {
        if (pair.difference(column, located, other, corner, near.turn) <=
            pair.limit(column, located.part, other.part))
          continue;
        difference.corner = corner;
        difference.attribute = names_[column].first;
        difference.value = values_at(pair.a(), located, column, corner);
        difference.other = values_at(pair.b(), other, column, (corner + near.turn) % pair.a().corner_count());
        return difference;
      }
    return difference;
  }

  static bool stands_there(const ElementPair& pair, const ElementBag::Located& element) {
    for (uint32_t i = 0; i < pair.b().size(); ++i)
      for (int turn = 0; turn < pair.a().corner_count(); ++turn)
        if (pair.fit(element, pair.b().locate(i), turn)) return true;
    return false;
  }

  static bool is_mirrored(const ElementPair& pair, ElementBag::Located element,
                          const ElementBag::Located& other) {
    std::swap(element.points[1], element.points[2]);
    for (int turn = 0; pair.a().corner_count() == 3 && turn < 3; ++turn)
      if (pair.fit(element, other, turn)) return true;
    return false;
  }

  AssetDifference describe(const ElementMatch& match) const {
    const Tear& tear = *match.tear;
    const ElementBag::Located located = bags_[0].locate(tear.elements[0]);
    AssetDifference difference = at(0, located);
    difference.partner = bags_[0].locate(tear.elements[1]).element;
    difference.corner = tear.corners[0];
    difference.attribute = names_[0].first;
    difference.value = values_at(bags_[0], located, 0, tear.corners[0]);
    difference.what = tear.in_b ? "is separated from its neighbour in the second file"
                                : "is separated from its neighbour in the first file";
    return difference;
  }

  // If both sides are quantized, one position may have become two in either of them.
  static TearSearch tears_in(const ColumnLimits& positions) {
    if (positions.stated) return TearSearch::kInEither;
    const auto is_rounded = [](const ColumnLimit& limit) { return limit.within > 0; };
    const bool a = std::ranges::any_of(positions.limits[0], is_rounded),
               b = std::ranges::any_of(positions.limits[1], is_rounded);
    return a == b ? TearSearch::kNone : a ? TearSearch::kInA : TearSearch::kInB;
  }

  AssetPrimitives primitives_[2];
  TearSearch tears_ = TearSearch::kNone;
  Names names_;
  ElementBag bags_[2];
  RoundingGrids grids_[2];  // for equal_sums
  std::vector<bool> directions_;
};

uint64_t element_count(AssetPrimitives primitives) {
  uint64_t count = 0;
  for (const AssetPrimitive* primitive : primitives) count += primitive->element_count();
  return count;
}

AssetComparison whole_group_differs(AssetPrimitives a, AssetPrimitives b, std::string what) {
  AssetComparison result;
  result.a.alone = element_count(a);
  result.b.alone = element_count(b);
  const AssetPrimitive& primitive = a.empty() ? *b[0] : *a[0];
  result.first.emplace();
  result.first->in_b = a.empty();
  result.first->mesh = static_cast<int64_t>(primitive.id.mesh);
  result.first->primitive = static_cast<int64_t>(primitive.id.primitive);
  result.first->what = std::move(what);
  return result;
}

const char* element_name(int corner_count) {
  return corner_count == 3 ? "triangles" : corner_count == 2 ? "lines" : "points";
}

// A sentence about a difference of the primitives as wholes, or an empty string.
std::string difference_of_kind(const AssetPrimitive& a, const AssetPrimitive& b, bool with_materials,
                               const CompareRules& rules) {
  if (a.corner_count != b.corner_count)
    return std::string("has ") + element_name(a.corner_count) + ", but " + element_name(b.corner_count) +
           " in the other file";
  const Names names_a = compared_attributes(a, rules), names_b = compared_attributes(b, rules);
  for (const auto& [name, components] : names_a) {
    const auto found = std::ranges::find(names_b, name, &Names::value_type::first);
    if (found == names_b.end()) return "has " + name + ", which the other file lacks";
    if (found->second != components)
      return "has " + name + " of " + std::to_string(components) + " components, but " +
             std::to_string(found->second) + " in the other file";
  }
  for (const auto& [name, components] : names_b)
    if (std::ranges::find(names_a, name, &Names::value_type::first) == names_a.end())
      return "lacks " + name + ", which the other file has";
  if (with_materials && a.material != b.material)
    return "has material " + std::to_string(a.material) + ", but " + std::to_string(b.material) +
           " in the other file";
  return "";
}

}  // namespace

std::vector<std::pair<std::string, int>> compared_attributes(const AssetPrimitive& primitive,
                                                             const CompareRules& rules) {
  Names names;
  for (const MeshView::Values& attribute : primitive.view.attributes)
    if (rules.attributes.empty() || attribute.semantic == "POSITION" ||
        std::ranges::find(rules.attributes, attribute.semantic) != rules.attributes.end() ||
        std::ranges::find(rules.attributes, kind_of(attribute.semantic)) != rules.attributes.end())
      names.emplace_back(attribute.semantic, attribute.values.component_count);
  std::ranges::sort(names, {},
                    [](const auto& name) { return std::pair(name.first != "POSITION", name.first); });
  return names;
}

Expected<AssetComparison> compare_group(AssetPrimitives a, AssetPrimitives b, bool with_materials,
                                        const CompareRules& rules, const CompareMeans& means) {
  if (a.empty() || b.empty()) {
    if (element_count(a) + element_count(b) == 0) return AssetComparison{};
    return whole_group_differs(a, b,
                               with_materials
                                   ? "has no primitive of its kind, attributes and material in the other file"
                                   : "has no primitive of its kind and attributes in the other file");
  }
  std::string what = difference_of_kind(*a[0], *b[0], with_materials, rules);
  if (!what.empty()) return whole_group_differs(a, b, std::move(what));
  if (element_count(a) >= kNoElement || element_count(b) >= kNoElement)
    return unsupported("2^32 elements and more are not compared");
  Expected<AssetComparison> comparison = GroupComparer(a, b, rules).run(means);
  if (!comparison || comparison->same() || has_rounded_weights(a) == has_rounded_weights(b)) return comparison;
  // Some encoders correct weights whose sum is not 1, others do not.
  const bool is_b = has_rounded_weights(a);
  std::vector<AssetPrimitive> mended;
  std::vector<const AssetPrimitive*> pointers;
  for (const AssetPrimitive* primitive : is_b ? b : a) mended.push_back(mend_weights(*primitive));
  for (const AssetPrimitive& primitive : mended) pointers.push_back(&primitive);
  const AssetPrimitives mended_a = is_b ? a : AssetPrimitives(pointers),
                        mended_b = is_b ? AssetPrimitives(pointers) : b;
  Expected<AssetComparison> with_mended = GroupComparer(mended_a, mended_b, rules).run(means);
  return with_mended && with_mended->same() ? with_mended : comparison;
}

}  // namespace psplit
