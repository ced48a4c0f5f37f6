#include "gltf_ext/compare/compare_group.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "gltf_ext/compare/column_limits.h"
#include "gltf_ext/compare/match_elements.h"
#include "gltf_ext/compare/rounded_mesh.h"

namespace psplit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool has_rounded_weights(AssetPrimitives primitives) {
  return std::ranges::any_of(primitives, [](const AssetPrimitive* primitive) {
    return std::ranges::any_of(primitive->grids,
                               [](const auto& grid) { return grid.first.starts_with("WEIGHTS_"); });
  });
}

// Scales weights whose sum is nearly 1, so that it is 1.
void mend_weights(Mesh& mesh) {
  constexpr double kWorthMending = 0.02;
  std::vector<Attribute*> weights;
  for (Attribute& attribute : mesh.attributes)
    if (attribute.semantic.starts_with("WEIGHTS_") && attribute.component_type == ComponentType::kFloat32)
      weights.push_back(&attribute);
  for (uint32_t point = 0; point < mesh.point_count; ++point) {
    double sum = 0;
    for (const Attribute* attribute : weights)
      for (size_t c = 0; c < attribute->component_count; ++c) sum += number_at(*attribute, point, c);
    if (!(std::fabs(sum - 1) <= kWorthMending)) continue;
    for (Attribute* attribute : weights)
      for (size_t c = 0; c < attribute->component_count; ++c) {
        const auto value = static_cast<float>(number_at(*attribute, point, c) / sum);
        std::memcpy(attribute->values.data() + point * attribute->stride() + c * sizeof value, &value,
                    sizeof value);
      }
  }
}

std::vector<double> values_at(const Attribute& attribute, uint32_t point) {
  std::vector<double> values;
  for (size_t c = 0; c < attribute.component_count; ++c) values.push_back(number_at(attribute, point, c));
  return values;
}

using Names = std::vector<std::pair<std::string, int>>;

// For each triangle whether two corners have the same position on a grid of `others`: an encoder that rounds
// before it makes faces drops those. Empty if none has.
std::vector<bool> flat_faces(const AssetPrimitive& primitive, AssetPrimitives others) {
  std::vector<bool> is_flat;
  const Attribute& position = *primitive.mesh.find("POSITION");
  if (primitive.corner_count != 3 || position.component_type != ComponentType::kFloat32) return is_flat;
  std::map<std::string, const DeclaredGrid*> grids;
  for (const AssetPrimitive* other : others)
    if (const auto found = other->grids.find("POSITION"); found != other->grids.end())
      grids.emplace(found->second.identity, &found->second);
  grids.erase("");
  if (const auto own = primitive.grids.find("POSITION"); own != primitive.grids.end())
    grids.erase(own->second.identity);
  for (const auto& named : grids) {
    const DeclaredGrid* const grid = named.second;
    if (grid->origin.size() != position.component_count) continue;
    const auto same_place = [&](uint32_t a, uint32_t b) {
      bool same = true;
      for (size_t c = 0; same && c < position.component_count; ++c) {
        const auto place = [&](uint32_t point) {
          return round_to_step(static_cast<float>(number_at(position, point, c)), *grid, c);
        };
        same = place(a) == place(b);
      }
      return same;
    };
    is_flat.resize(primitive.mesh.faces.size());
    for (size_t i = 0; i < is_flat.size(); ++i) {
      const auto& face = primitive.mesh.faces[i];
      if (same_place(face[0], face[1]) || same_place(face[1], face[2]) || same_place(face[2], face[0]))
        is_flat[i] = true;
    }
  }
  return is_flat;
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
        const Mesh& mesh = primitives_[side][i]->mesh;
        ElementPart part{mesh.faces, {}, {}};
        for (size_t column = 0; column < names_.size(); ++column) {
          part.columns.push_back(mesh.find(names_[column].first));
          part.limits.push_back(limits[column].limits[side][i]);
        }
        part.is_flat = flat_faces(*primitives_[side][i], primitives_[1 - side]);
        bags_[side].add(std::move(part));
      }
  }

  Expected<AssetComparison> run() {
    const ElementPair pair(bags_[0], bags_[1], directions_);
    const Expected<ElementMatch> match = match_elements(pair, tears_);
    if (!match) return match.status();
    AssetComparison result;
    for (size_t column = 0; column < names_.size(); ++column)
      result.values.push_back({names_[column].first, match->largest[column], pair.largest_limit(column)});
    std::ranges::sort(result.values, {}, &AssetComparison::Values::attribute);
    std::vector<uint8_t> taken(bags_[0].size());
    for (uint32_t i = 0; i < taken.size(); ++i) taken[i] = match->partner[i] != kNoElement;
    // A grid is that of a part only if some of its elements are in the other file.
    bags_[0].forget_flat_parts(taken);
    bags_[1].forget_flat_parts(match->taken);
    const std::optional<uint32_t> first_a = count_alone(bags_[0], taken, result.a);
    const std::optional<uint32_t> first_b = count_alone(bags_[1], match->taken, result.b);
    if (first_a)
      result.first = describe(pair, *first_a, match->taken, /*in_b=*/false);
    else if (first_b)
      result.first = describe(ElementPair(bags_[1], bags_[0], directions_), *first_b, taken, /*in_b=*/true);
    else if (match->tear)
      result.first = describe(*match);
    return result;
  }

 private:
  static std::optional<uint32_t> count_alone(const ElementBag& bag, const std::vector<uint8_t>& taken,
                                             AssetComparison::Counts& counts) {
    std::optional<uint32_t> first;
    for (uint32_t i = 0; i < bag.size(); ++i) {
      if (taken[i] != 0) continue;
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
    double apart = kInfinity;  // sum of squared distances of positions beyond their limit
    int off = 0;               // number of values beyond their limit
  };
  static Nearest nearest(const ElementPair& pair, const ElementBag::Located& element,
                         const std::vector<uint8_t>& taken) {
    Nearest best;
    for (uint32_t i = 0; i < pair.b().size(); ++i) {
      if (taken[i] != 0) continue;
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

  AssetDifference describe(const ElementPair& pair, uint32_t element, const std::vector<uint8_t>& taken,
                           bool in_b) const {
    const ElementBag::Located located = pair.a().locate(element);
    AssetDifference difference = at(in_b ? 1 : 0, located);
    const Nearest near = nearest(pair, located, taken);
    if (stands_there(pair, located)) {
      difference.what = "occurs more often than in the other file";
      return difference;
    }
    // The position of a corner shows where the element is.
    difference.what = "has no counterpart";
    difference.attribute = names_[0].first;
    difference.corner = 0;
    difference.value = values_at(*pair.a().parts()[located.part].columns[0], located.points[0]);
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
        const int other_corner = (corner + near.turn) % pair.a().corner_count();
        difference.corner = corner;
        difference.attribute = names_[column].first;
        difference.value = values_at(*pair.a().parts()[located.part].columns[column],
                                     located.points[static_cast<size_t>(corner)]);
        difference.other = values_at(*pair.b().parts()[other.part].columns[column],
                                     other.points[static_cast<size_t>(other_corner)]);
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
    AssetDifference difference = at(0, bags_[0].locate(tear.elements[0]));
    difference.partner = bags_[0].locate(tear.elements[1]).element;
    difference.corner = tear.corners[0];
    difference.attribute = names_[0].first;
    const ElementBag::Located located = bags_[0].locate(tear.elements[0]);
    difference.value = values_at(*bags_[0].parts()[located.part].columns[0],
                                 located.points[static_cast<size_t>(tear.corners[0])]);
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
  std::vector<bool> directions_;
};

uint64_t element_count(AssetPrimitives primitives) {
  uint64_t count = 0;
  for (const AssetPrimitive* primitive : primitives) count += primitive->mesh.faces.size();
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
  for (const Attribute& attribute : primitive.mesh.attributes)
    if (rules.attributes.empty() || attribute.semantic == "POSITION" ||
        std::ranges::find(rules.attributes, attribute.semantic) != rules.attributes.end() ||
        std::ranges::find(rules.attributes, kind_of(attribute.semantic)) != rules.attributes.end())
      names.emplace_back(attribute.semantic, attribute.component_count);
  std::ranges::sort(names, {},
                    [](const auto& name) { return std::pair(name.first != "POSITION", name.first); });
  return names;
}

Expected<AssetComparison> compare_group(AssetPrimitives a, AssetPrimitives b, bool with_materials,
                                        const CompareRules& rules) {
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
  Expected<AssetComparison> comparison = GroupComparer(a, b, rules).run();
  if (!comparison || comparison->same() || has_rounded_weights(a) == has_rounded_weights(b)) return comparison;
  // Some encoders correct weights whose sum is not 1, others do not.
  std::vector<AssetPrimitive> mended;
  std::vector<const AssetPrimitive*> pointers;
  for (const AssetPrimitive* primitive : has_rounded_weights(a) ? b : a) mended.push_back(*primitive);
  for (AssetPrimitive& primitive : mended) {
    mend_weights(primitive.mesh);
    pointers.push_back(&primitive);
  }
  Expected<AssetComparison> with_mended = has_rounded_weights(a) ? GroupComparer(a, pointers, rules).run()
                                                                 : GroupComparer(pointers, b, rules).run();
  return with_mended && with_mended->same() ? with_mended : comparison;
}

}  // namespace psplit
