#include "gltf_ext/compare/compare_group.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "gltf_ext/compare/match_elements.h"

namespace psplit {
namespace {

using Primitives = std::span<const AssetPrimitive* const>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// "target 0 POSITION" is of the kind of POSITION.
std::string kind_of(const std::string& attribute) { return attribute.substr(attribute.rfind(' ') + 1); }

bool starts_with_any(const std::string& text, std::initializer_list<const char*> prefixes) {
  return std::ranges::any_of(prefixes, [&](const char* prefix) { return text.starts_with(prefix); });
}

bool has_rounded_weights(Primitives primitives) {
  return std::ranges::any_of(primitives, [](const AssetPrimitive* primitive) {
    return std::ranges::any_of(primitive->grids,
                               [](const auto& grid) { return grid.first.starts_with("WEIGHTS_"); });
  });
}

// Weights that sum to nearly one as those that do.
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

double extent(Primitives primitives, const std::string& attribute) {
  if (starts_with_any(kind_of(attribute), {"NORMAL", "TANGENT", "COLOR_", "WEIGHTS_"})) return 1;
  std::array<double, 16> low, high;
  low.fill(kInfinity);
  high.fill(-kInfinity);
  for (const AssetPrimitive* primitive : primitives) {
    const Attribute& values = *primitive->mesh.find(attribute);
    for (uint32_t point = 0; point < primitive->mesh.point_count; ++point)
      for (size_t c = 0; c < values.component_count; ++c) {
        const double value = number_at(values, point, c);
        if (!std::isfinite(value)) continue;
        low[c] = std::min(low[c], value);
        high[c] = std::max(high[c], value);
      }
  }
  double most = 0;
  for (size_t c = 0; c < low.size(); ++c) most = std::max(most, high[c] - low[c]);
  return std::isfinite(most) ? most : 0;
}

// How one column is compared: a limit for each primitive of either side.
struct ColumnPlan {
  bool direction = false;
  bool stated = false;  // the limit is the user's: nobody knows which side was quantized
  std::vector<ColumnLimit> limits[2];
};

class Planner {
 public:
  Planner(Primitives a, Primitives b, const CompareRules& rules) : sides_{a, b}, rules_(rules) {}

  ColumnPlan plan(const std::string& attribute) {
    ColumnPlan plan;
    for (const size_t side : {0u, 1u}) plan.limits[side].resize(sides_[side].size());
    const std::string kind = kind_of(attribute);
    if (const std::optional<double> share = stated_share(attribute, kind)) {
      plan.stated = true;
      for (ColumnLimit& limit : plan.limits[0]) limit.within = *share * extent(sides_[0], attribute);
      return plan;
    }
    for (const size_t side : {0u, 1u})
      for (size_t i = 0; i < sides_[side].size(); ++i) {
        const auto grid = sides_[side][i]->grids.find(attribute);
        if (grid == sides_[side][i]->grids.end())
          plan.limits[side][i] = limit_of_type(*sides_[side][i]->mesh.find(attribute), kind);
        else
          plan.limits[side][i] = limit_of_grid(grid->second, kind);
        plan.direction |= grid != sides_[side][i]->grids.end() && grid->second.direction;
      }
    // A grid of numbers beside one of directions: its corners are further away.
    if (plan.direction)
      for (const size_t side : {0u, 1u})
        for (size_t i = 0; i < sides_[side].size(); ++i)
          if (!sides_[side][i]->grids.contains(attribute)) plan.limits[side][i].within *= std::sqrt(3.0);
    return plan;
  }

 private:
  // Nothing where the files decide: that is always so for numbers that are names of something.
  std::optional<double> stated_share(const std::string& attribute, const std::string& kind) const {
    auto found = rules_.tolerances.find(attribute);
    if (found == rules_.tolerances.end()) found = rules_.tolerances.find(kind);
    if (found == rules_.tolerances.end()) found = rules_.tolerances.find("");
    if (found == rules_.tolerances.end() || kind.starts_with("JOINTS_")) return std::nullopt;
    if (!starts_with_any(kind, {"POSITION", "NORMAL", "TANGENT", "TEXCOORD_", "COLOR_", "WEIGHTS_"}))
      for (const Primitives& side : sides_)
        for (const AssetPrimitive* primitive : side) {
          const Attribute& values = *primitive->mesh.find(attribute);
          if (values.component_type != ComponentType::kFloat32 && !values.normalized) return std::nullopt;
        }
    return found->second;
  }

  ColumnLimit limit_of_grid(const DeclaredGrid& grid, const std::string& kind) {
    constexpr double kNoise = 1e-5;  // beyond glTF's limits, which encoders cut off
    ColumnLimit limit{grid.within, grid.identity.empty() ? -1 : number("grid " + grid.identity)};
    if (kind.starts_with("WEIGHTS_")) limit.within *= 3;  // rounded together, so that they sum to one
    if (starts_with_any(kind, {"COLOR_", "WEIGHTS_", "TANGENT"})) limit.within += kNoise;
    return limit;
  }

  // Integers of one type are compared exactly; beside another type they may be off by their rounding.
  ColumnLimit limit_of_type(const Attribute& attribute, const std::string& kind) {
    if (attribute.component_type == ComponentType::kFloat32) return {};
    ColumnLimit limit;
    limit.grid = number("type " + std::to_string(static_cast<int>(attribute.component_type)) +
                        (attribute.normalized ? " normalized" : ""));
    const size_t bits = 8 * component_bytes(attribute.component_type);
    const bool is_signed =
        attribute.component_type == ComponentType::kInt8 || attribute.component_type == ComponentType::kInt16;
    if (attribute.normalized)
      limit.within = 0.5 / (std::ldexp(1.0, static_cast<int>(bits) - (is_signed ? 1 : 0)) - 1) + 1e-7;
    else if (starts_with_any(kind, {"POSITION", "TEXCOORD_"}))
      limit.within = 0.5;
    return limit;
  }

  int32_t number(const std::string& identity) {
    return numbers_.emplace(identity, static_cast<int32_t>(numbers_.size())).first->second;
  }

  Primitives sides_[2];
  const CompareRules& rules_;
  std::map<std::string, int32_t> numbers_;
};

std::vector<double> values_at(const Attribute& attribute, uint32_t point) {
  std::vector<double> values;
  for (size_t c = 0; c < attribute.component_count; ++c) values.push_back(number_at(attribute, point, c));
  return values;
}

using Names = std::vector<std::pair<std::string, int>>;

// What the elements of a group are, and who of them is alone.
class GroupComparer {
 public:
  GroupComparer(Primitives a, Primitives b, const CompareRules& rules)
      : primitives_{a, b},
        names_(compared_attributes(*a[0], rules)),
        bags_{ElementBag(a[0]->corner_count), ElementBag(a[0]->corner_count)} {
    Planner planner(a, b, rules);
    std::vector<ColumnPlan> plans;
    for (const auto& [name, components] : names_) plans.push_back(planner.plan(name));
    for (const ColumnPlan& plan : plans) directions_.push_back(plan.direction);
    tears_ = tears_in(plans[0]);
    for (const size_t side : {0u, 1u})
      for (size_t i = 0; i < primitives_[side].size(); ++i) {
        const Mesh& mesh = primitives_[side][i]->mesh;
        ElementPart part{mesh.faces, {}, {}};
        for (size_t column = 0; column < names_.size(); ++column) {
          part.columns.push_back(mesh.find(names_[column].first));
          part.limits.push_back(plans[column].limits[side][i]);
        }
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

  // The element without a partner of the other side that is nearest: by positions first, then by how many
  // values are off.
  struct Nearest {
    std::optional<uint32_t> element;
    int turn = 0;
    double apart = kInfinity;  // sum of squares of the positions that are beyond their limit
    int off = 0;               // values beyond their limit
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
      difference.what = "stands there more often than in the other file";
      return difference;
    }
    // A position of its own says where the element is, if nothing else does.
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
    difference.what = tear.in_b ? "came apart in the second file from its neighbour"
                                : "came apart in the first file from its neighbour";
    return difference;
  }

  // Where both sides were quantized in different ways, one position may have become two in either.
  static TearSearch tears_in(const ColumnPlan& positions) {
    if (positions.stated) return TearSearch::kInEither;
    const auto is_rounded = [](const ColumnLimit& limit) { return limit.within > 0; };
    const bool a = std::ranges::any_of(positions.limits[0], is_rounded),
               b = std::ranges::any_of(positions.limits[1], is_rounded);
    return a == b ? TearSearch::kNone : a ? TearSearch::kInA : TearSearch::kInB;
  }

  Primitives primitives_[2];
  TearSearch tears_ = TearSearch::kNone;
  Names names_;
  ElementBag bags_[2];
  std::vector<bool> directions_;
};

uint64_t element_count(Primitives primitives) {
  uint64_t count = 0;
  for (const AssetPrimitive* primitive : primitives) count += primitive->mesh.faces.size();
  return count;
}

AssetComparison whole_group_differs(Primitives a, Primitives b, std::string what) {
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

// A sentence on how two primitives differ as wholes, or nothing.
std::string difference_of_kind(const AssetPrimitive& a, const AssetPrimitive& b, bool with_materials,
                               const CompareRules& rules) {
  if (a.corner_count != b.corner_count)
    return std::string("is of ") + element_name(a.corner_count) + ", and of " + element_name(b.corner_count) +
           " in the other file";
  const Names names_a = compared_attributes(a, rules), names_b = compared_attributes(b, rules);
  for (const auto& [name, components] : names_a) {
    const auto found = std::ranges::find(names_b, name, &Names::value_type::first);
    if (found == names_b.end()) return "has " + name + ", and in the other file it has not";
    if (found->second != components)
      return "has " + name + " of " + std::to_string(components) + " components, and of " +
             std::to_string(found->second) + " in the other file";
  }
  for (const auto& [name, components] : names_b)
    if (std::ranges::find(names_a, name, &Names::value_type::first) == names_a.end())
      return "has no " + name + ", and in the other file it has";
  if (with_materials && a.material != b.material)
    return "has material " + std::to_string(a.material) + ", and " + std::to_string(b.material) +
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

Expected<AssetComparison> compare_group(Primitives a, Primitives b, bool with_materials,
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
  // Some encoders set weights right whose sum is off, others do not.
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
