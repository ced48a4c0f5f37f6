#include "encoder/stream/smallest_stream.h"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "encoder/fields/entropy_encoder.h"
#include "encoder/stream/encode_attributes.h"
#include "encoder/stream/patch_steps.h"
#include "encoder/stream/stream_steps.h"
#include "src/container/bit_string.h"
#include "src/container/claims.h"
#include "src/core/traversal.h"

namespace psplit {
namespace {

using core::Coding, core::Scheme;

// One level of each kind that the symbol encoder distinguishes.
constexpr std::array<int, 5> kLevels = {0, 4, 6, 8, 10};
// The one of speed 5.
constexpr size_t kUsualLevel = 1;
using LevelBytes = std::array<size_t, kLevels.size()>;

// A way to code an attribute, and the bytes that it takes.
struct Choice {
  Scheme scheme = Scheme::kNone;
  bool by_degree = false;
  size_t rank = 0;  // of equal ones, the lowest is taken, which is the fastest to decode
  LevelBytes bytes{};
};

// The choices that were tried for an attribute. Only fields of a choice that is smallest at some level are
// kept, because fields take as much memory as the values.
struct Tried {
  std::vector<Choice> choices;
  size_t kept = 0;
  AttributeFields fields;

  size_t best_at(size_t level) const {
    const auto is_less = [&](const Choice& a, const Choice& b) {
      return std::pair(a.bytes[level], a.rank) < std::pair(b.bytes[level], b.rank);
    };
    return static_cast<size_t>(std::min_element(choices.begin(), choices.end(), is_less) - choices.begin());
  }
};

// The walk by prediction degree over the table of POSITION, which all groups without seams share.
class WalkByDegree {
 public:
  core::Fault walk(const core::Group<uint32_t>& positions, uint32_t face_count) {
    const uint32_t vertices = positions.table.vertex_count;
    const size_t size =
        core::Sequence<uint32_t>::bytes(vertices) + core::traverse_bytes<uint32_t>(true, face_count, vertices);
    memory_.reset(new uint8_t[size]);
    core::Arena arena(memory_.get(), size);
    if (!sequence_.allocate(vertices, arena)) return core::Fault::kWorkspace;
    return core::traverse(positions.table, true, arena, sequence_);
  }
  const core::Sequence<uint32_t>& sequence() const { return sequence_; }

 private:
  std::unique_ptr<uint8_t[]> memory_;
  core::Sequence<uint32_t> sequence_;
};

// The bytes that an attribute takes in a stream at each level, without its description and what turns integers
// into values. Estimates are enough for a choice that takes more than `fewest` at all levels.
LevelBytes attribute_bytes(const AttributePlan& plan, const AttributeFields& fields, const LevelBytes& fewest) {
  LevelBytes sums{};
  if (plan.description.coding == Coding::kRaw) {
    sums.fill(fields.raw.size());
    return sums;
  }
  std::vector<uint8_t> bytes;
  append_scheme(plan, bytes);
  append_prediction_grid(plan, bytes);
  constexpr size_t kRangeBytes = 8, kCountBytes = 4;
  size_t more = plan.is_predicted() && plan.transform == core::Transform::kWrap ? kRangeBytes : 0;
  if (plan.scheme == Scheme::kConstrainedMultiParallelogram)
    for (const std::vector<uint8_t>& flags : fields.creases) {
      append_varint(flags.size(), bytes);
      if (!flags.empty()) encode_flags(flags, bytes);
    }
  if (plan.scheme == Scheme::kTexCoords) {
    more += kCountBytes;
    encode_flags(fields.same_orientations, bytes);
  }
  if (plan.scheme == Scheme::kGeometricNormal) encode_flags(fields.flips, bytes);
  const CountedSymbols symbols(fields.symbols, fields.components);
  const size_t others = bytes.size() + more;
  bool is_larger = true;
  for (size_t level = 0; level < kLevels.size(); ++level) {
    sums[level] = others + symbols.estimate(kLevels[level]);
    is_larger &= sums[level] > fewest[level] + fewest[level] / 32 + 64;
  }
  if (is_larger) return sums;
  for (size_t level = 0; level < kLevels.size(); ++level) {
    bytes.clear();
    symbols.write(kLevels[level], bytes);
    sums[level] = others + bytes.size();
  }
  return sums;
}

class SmallestAttributes {
 public:
  SmallestAttributes(const WeldedMesh& welded, const PatchMesh& patch, std::span<const AttributeCoding> codings,
                     const EncodedConnectivity& connectivity, bool in_creation_order)
      : welded_(welded),
        patch_(patch),
        codings_(codings),
        groups_(connectivity.patch.groups.data(), connectivity.patch.groups.size()),
        source_{welded, codings, patch.points},
        encoder_(source_, false, groups_, connectivity.point_of_corner),
        group_sizes_(groups_.size(), 0),
        face_count_(connectivity.patch.face_count),
        in_creation_order_(in_creation_order) {}

  // Sets the level of symbols as well.
  Expected<EncodedAttributes> choose(int& symbol_level) {
    if (const core::Fault fault = by_degree_.walk(groups_[0], face_count_); fault != core::Fault::kNone)
      return status_of(fault);
    // Schemes follow. The speed is one at which each attribute has a table of its own.
    const StreamTraits traits{.speed = kSpeedOfOneTable - 1,
                              .point_count = static_cast<uint32_t>(patch_.points.size())};
    EncodedAttributes out;
    out.plans =
        plan_attributes(*welded_.mesh, welded_.seams_of, codings_, traits, [](size_t) { return false; });
    for (const AttributePlan& plan : out.plans) ++group_sizes_[plan.group];
    std::vector<Tried> tried;
    for (AttributePlan& plan : out.plans) {
      Expected<Tried> all = try_all(plan, out.plans[0]);
      if (!all) return all.status();
      tried.push_back(std::move(*all));
    }
    const size_t level = in_creation_order_ ? kUsualLevel : best_level(tried);
    symbol_level = kLevels[level];
    for (size_t i = 0; i < tried.size(); ++i) {
      AttributePlan& plan = out.plans[i];
      const size_t best = tried[i].best_at(level);
      plan.scheme = tried[i].choices[best].scheme;
      plan.by_degree = tried[i].choices[best].by_degree;
      // Rarely, another choice is best at the level that is best for all.
      if (best != tried[i].kept)
        if (Status status = make(plan, tried[i].fields); !status.ok()) return status;
      out.fields.push_back(std::move(tried[i].fields));
    }
    return out;
  }

 private:
  core::Group<uint32_t> group_of(const AttributePlan& plan) const {
    core::Group<uint32_t> group = groups_[plan.group];
    group.by_prediction_degree = plan.by_degree;
    if (plan.by_degree) group.sequence = by_degree_.sequence();
    return group;
  }

  Status make(AttributePlan& plan, AttributeFields& out) {
    const core::Group<uint32_t> group = group_of(plan);
    if (Status status = encoder_.take(plan, group); !status.ok()) return status;
    Expected<AttributeFields> fields = encoder_.correct(plan, group);
    if (!fields) return fields.status();
    out = std::move(*fields);
    return {};
  }

  // All that is possible for one attribute. What libdraco's encoder would refuse is not.
  Expected<Tried> try_all(AttributePlan& plan, const AttributePlan& positions) {
    std::vector<Scheme> schemes = possible_schemes(plan, texture_bits(plan), positions, [&](size_t texcoords) {
      return texture_prediction_may_overflow(welded_, patch_, codings_, texcoords);
    });
    const bool is_created = in_creation_order_ &&
                            (&plan == &positions || target_of(welded_.mesh->attributes[plan.source].semantic));
    if (is_created) std::erase(schemes, Scheme::kConstrainedMultiParallelogram);
    // All attributes of a group have one walk.
    const bool has_walks = !is_created && plan.description.coding != Coding::kRaw &&
                           !groups_[plan.group].per_corner && group_sizes_[plan.group] == 1;
    Tried tried;
    LevelBytes fewest;
    fewest.fill(SIZE_MAX / 2);
    Status refused;
    for (const bool by_degree : {false, true}) {
      if (by_degree && !has_walks) break;
      plan.by_degree = by_degree;
      const core::Group<uint32_t> group = group_of(plan);
      if (Status status = encoder_.take(plan, group); !status.ok()) return status;
      // The last is often the smallest. Bytes of the others are then estimated.
      for (size_t rank = schemes.size(); rank-- > 0;) {
        plan.scheme = schemes[rank];
        Expected<AttributeFields> fields = encoder_.correct(plan, group);
        if (!fields) {
          refused = fields.status();
          continue;
        }
        const Choice choice{plan.scheme, by_degree, rank + (by_degree ? schemes.size() : 0),
                            attribute_bytes(plan, *fields, fewest)};
        const auto least = [](const Choice& of) {
          return std::pair(*std::min_element(of.bytes.begin(), of.bytes.end()), of.rank);
        };
        if (tried.choices.empty() || least(choice) < least(tried.choices[tried.kept])) {
          tried.kept = tried.choices.size();
          tried.fields = std::move(*fields);
        }
        for (size_t level = 0; level < fewest.size(); ++level)
          fewest[level] = std::min(fewest[level], choice.bytes[level]);
        tried.choices.push_back(choice);
      }
    }
    if (tried.choices.empty()) return refused;
    return tried;
  }

  int texture_bits(const AttributePlan& plan) const {
    return plan.description.coding == Coding::kInteger ? kMostBitsOfIntegers : codings_[plan.source].bits;
  }

  static size_t best_level(std::span<const Tried> tried) {
    LevelBytes sums{};
    for (const Tried& of_attribute : tried)
      for (size_t level = 0; level < sums.size(); ++level)
        sums[level] += of_attribute.choices[of_attribute.best_at(level)].bytes[level];
    return static_cast<size_t>(std::min_element(sums.begin(), sums.end()) - sums.begin());
  }

  const WeldedMesh& welded_;
  const PatchMesh& patch_;
  const std::span<const AttributeCoding> codings_;
  const std::span<const core::Group<uint32_t>> groups_;
  const AttributeSource source_;
  AttributeEncoder encoder_;
  std::vector<size_t> group_sizes_;  // the number of attributes
  const uint32_t face_count_;
  const bool in_creation_order_;
  WalkByDegree by_degree_;
};

// The bytes of the symbols alone; all else is the same.
bool is_valence_smaller(const DracoFields& fields) {
  size_t bits = 0;
  for (const uint8_t symbol : fields.symbols) bits += symbol == core::kC ? 1 : 3;
  std::vector<uint8_t> lists, length;
  append_varint((bits + 7) / 8, length);
  for (const std::vector<uint8_t>& list : fields.symbol_lists) {
    append_varint(list.size(), lists);
    encode_symbols(std::vector<uint32_t>(list.begin(), list.end()), 1, kDefaultSymbolLevel, lists);
  }
  return lists.size() < length.size() + (bits + 7) / 8;
}

}  // namespace

std::vector<Scheme> possible_schemes(const AttributePlan& plan, int texture_bits,
                                     const AttributePlan& positions,
                                     const std::function<bool(size_t)>& texture_may_overflow) {
  const core::Attribute<uint32_t>& description = plan.description;
  const bool are_integers =
      positions.description.coding != Coding::kRaw && positions.description.components == 3;
  std::vector<Scheme> schemes = {Scheme::kNone};
  if (description.coding == Coding::kRaw) return schemes;
  schemes.push_back(Scheme::kDifference);
  if (description.coding == Coding::kNormal) {
    if (are_integers) schemes.push_back(Scheme::kGeometricNormal);
    return schemes;
  }
  schemes.push_back(Scheme::kParallelogram);
  schemes.push_back(Scheme::kConstrainedMultiParallelogram);
  if (static_cast<DracoSemantic>(description.semantic) == DracoSemantic::kTexCoord &&
      description.components == 2 && are_integers &&
      predicts_texture(positions.description.bits, texture_bits) && !texture_may_overflow(plan.source))
    schemes.push_back(Scheme::kTexCoords);
  return schemes;
}

Expected<EncodedPatch> encode_smallest_stream(const WeldedMesh& welded, const PatchMesh& patch,
                                              std::span<const AttributeCoding> codings, bool with_values,
                                              bool in_creation_order) {
  // The fields of a valence traversal include the fields of a standard one.
  Expected<EncodedConnectivity> connectivity = connect_patch(welded, patch, {.valence = true});
  if (!connectivity) return connectivity.status();
  int symbol_level = 0;
  Expected<EncodedAttributes> attributes =
      SmallestAttributes(welded, patch, codings, *connectivity, in_creation_order).choose(symbol_level);
  if (!attributes) return attributes.status();
  const bool is_valence = !in_creation_order && is_valence_smaller(connectivity->fields);
  Expected<std::vector<uint8_t>> bytes =
      write_stream(*connectivity, std::move(*attributes), is_valence, symbol_level);
  if (!bytes) return bytes.status();
  return describe_stream(welded, *connectivity, std::move(*bytes), with_values);
}

}  // namespace psplit
