#include "encoder/coding/precision_guard.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "encoder/coding/grid_loss.h"
#include "encoder/coding/position_bits.h"
#include "encoder/coding/quantization.h"

namespace psplit {
namespace {

// The grid on which nothing collapses any more has places as far apart as what it tells apart. So many bits
// more, and shapes of that size keep their shape.
constexpr int kBitsForShape = 2;
// Components whose extents differ by up to this factor, and outliers up to the second, share a grid without a
// word.
constexpr double kLargeExtent = 4, kFarOutlier = 16;
// Floats have 24 bits: a finer grid takes more bytes than they do.
constexpr int kMostBitsOfSpread = 24;

enum class Measure { kNone, kNoGrid, kPositions, kTextureCoordinates, kSpread };

bool exceeds(const LostShare& share, double most) {
  return static_cast<double>(share.lost) > most * static_cast<double>(share.all);
}
bool is_collapse(const GridLoss& loss) {
  return exceeds(loss.faces, kMostFlatFaces) || exceeds(loss.points, kMostCoinciding) ||
         exceeds(loss.edges, kMostEqualEnds) || exceeds(loss.moved, kMostMoved);
}

// Grids within glTF's limits are not fitted to the values.
bool is_within_limits(const Attribute& attribute, const AttributeCoding& grid) {
  const bool has_limits = attribute.semantic.starts_with("COLOR_") ||
                          attribute.semantic.starts_with("WEIGHTS_") || attribute.semantic == "TANGENT";
  const float low = attribute.semantic == "TANGENT" ? -1.0f : 0.0f;
  return has_limits && std::ranges::all_of(grid.origin, [&](float origin) {
           return origin >= low && origin + grid.range <= 1.001f;
         });
}

Measure measure_of(const Attribute& attribute, const AttributeCoding& coding, int wanted) {
  if (wanted == 0 || coding.exact || attribute.component_type != ComponentType::kFloat32) return Measure::kNone;
  if (coding.bits == 0) return Measure::kNoGrid;
  if (coding.octahedral || coding.range == 0 || is_within_limits(attribute, coding)) return Measure::kNone;
  if (attribute.semantic == "POSITION" && attribute.component_count == 3) return Measure::kPositions;
  if (attribute.semantic.starts_with("TEXCOORD_") && attribute.component_count <= 3)
    return Measure::kTextureCoordinates;
  return Measure::kSpread;
}

// Why an attribute has no grid.
struct NoGrid {
  uint64_t not_finite = 0, not_unit = 0, points = 0;

  void add(const Attribute& attribute, Span<const uint8_t> stored) {
    const bool is_normal = attribute.semantic == "NORMAL" && attribute.component_count == 3;
    std::vector<float> value(attribute.component_count);
    for (size_t i = 0; i < attribute.values.size() / attribute.stride(); ++i) {
      if (!stored.empty() && stored[i] == 0) continue;
      ++points;
      std::memcpy(value.data(), attribute.values.data() + i * attribute.stride(), attribute.stride());
      const bool is_finite = std::ranges::all_of(value, [](float c) { return std::isfinite(c); });
      double square = 0;
      for (const float c : value) square += double{c} * double{c};
      not_finite += is_finite ? 0 : 1;
      not_unit += is_finite && is_normal && !is_unit_square(square) ? 1 : 0;
    }
  }
};

std::string share_text(const LostShare& share, const char* noun) {
  return std::to_string(share.lost) + " of " + std::to_string(share.all) + " " + noun;
}

void describe(const GridLoss& loss, PrecisionFinding& finding) {
  const auto say = [&](std::string subject, std::string predicate) {
    finding.subject = std::move(subject);
    finding.predicate = std::move(predicate);
  };
  if (exceeds(loss.faces, kMostFlatFaces)) return say(share_text(loss.faces, "faces"), "have no area");
  if (exceeds(loss.points, kMostCoinciding))
    return say(share_text(loss.points, "positions"), "coincide with another");
  if (exceeds(loss.moved, kMostMoved))
    return say(share_text(loss.moved, "texture coordinates"),
               "be off by up to " + rounded_text(loss.farthest) + " of a texture");
  say("the ends of " + share_text(loss.edges, "edges"), "have equal texture coordinates");
}

// The mesh, with the requested bits of its attributes.
class Guard {
 public:
  Guard(const GuardedMesh& mesh, Span<const AttributeCoding> codings, Span<const int> wanted,
        const ThreadPool& pool)
      : mesh_(mesh), codings_(codings), wanted_(wanted), pool_(pool), findings_(codings.size()) {}

  Expected<std::vector<PrecisionFinding>> find() {
    std::vector<GridLoss> losses(codings_.size());
    std::vector<NoGrid> no_grids(codings_.size());
    std::vector<ValueSpread> spreads(codings_.size());
    std::vector<Measure> measures(codings_.size(), Measure::kNone);
    Status status = mesh_.for_each_part([&](const Mesh& part, Span<const uint8_t> stored) {
      for (size_t i = 0; i < codings_.size(); ++i) {
        const Attribute& attribute = part.attributes[i];
        measures[i] = measure_of(attribute, codings_[i], wanted_[i]);
        const uint64_t count = stored.empty()
                                   ? part.point_count
                                   : static_cast<uint64_t>(std::count_if(
                                         stored.begin(), stored.end(), [](uint8_t flag) { return flag != 0; }));
        findings_[i].values += count * attribute.component_count;
        if (measures[i] == Measure::kNoGrid) no_grids[i].add(attribute, stored);
        if (measures[i] == Measure::kSpread) spreads[i].add(attribute, stored);
        add_loss(losses[i], measures[i], part, i, codings_[i], stored);
      }
    });
    for (size_t i = 0; i < codings_.size() && status.ok(); ++i) {
      if (measures[i] == Measure::kNoGrid) explain(no_grids[i], i);
      if (measures[i] == Measure::kSpread) judge_spread(spreads[i], i);
      if (is_collapse(losses[i])) status = search(losses[i], measures[i], i);
    }
    if (!status.ok()) return status;
    return std::move(findings_);
  }

 private:
  void add_loss(GridLoss& loss, Measure measure, const Mesh& part, size_t i, const AttributeCoding& grid,
                Span<const uint8_t> stored) const {
    const double scale = i < mesh_.texture_scales.size() ? mesh_.texture_scales[i] : 1;
    if (measure == Measure::kPositions) loss.add_positions(part, part.attributes[i], grid, stored, pool_);
    if (measure == Measure::kTextureCoordinates)
      loss.add_texture_coordinates(part, part.attributes[i], grid, stored, scale, pool_);
  }

  // Finds the fewest bits with which nothing collapses.
  Status search(const GridLoss& found, Measure measure, size_t i) {
    PrecisionFinding& finding = findings_[i];
    finding.is_loss = true;
    describe(found, finding);
    Status status;
    const auto collapses = [&](int bits) {
      const AttributeCoding grid = grid_with_bits(codings_[i], bits);
      GridLoss loss;
      status = mesh_.for_each_part([&](const Mesh& part, Span<const uint8_t> stored) {
        add_loss(loss, measure, part, i, grid, stored);
      });
      return is_collapse(loss);
    };
    int too_few = codings_[i].bits, enough = kMostGridBits;
    if (too_few >= kMostGridBits || collapses(kMostGridBits)) return status;
    while (status.ok() && enough - too_few > 1) {
      const int bits = (too_few + enough) / 2;
      (collapses(bits) ? too_few : enough) = bits;
    }
    if (measure == Measure::kPositions) enough = std::min(enough + kBitsForShape, kMostGridBits);
    finding.better = grid_with_bits(codings_[i], enough);
    return status;
  }

  void explain(const NoGrid& no_grid, size_t i) {
    PrecisionFinding& finding = findings_[i];
    finding.is_loss = true;
    if (no_grid.not_finite > 0)
      finding.subject =
          share_text({no_grid.not_finite, no_grid.points}, "points") + " have a value that is not finite";
    else if (no_grid.not_unit > 0)
      finding.subject = share_text({no_grid.not_unit, no_grid.points}, "points") + " have no unit vector";
    else
      finding.is_loss = false;
  }

  void judge_spread(const ValueSpread& spread, size_t i) {
    const AttributeCoding& grid = codings_[i];
    PrecisionFinding& finding = findings_[i];
    double finest = 0;  // the smallest extent that gets too few places
    for (size_t c = 0; c < spread.component_count(); ++c)
      for (const auto& [extent, most, who] :
           {std::tuple(spread.extent(c), kLargeExtent, "the values of component "),
            std::tuple(spread.inner_extent(c), kFarOutlier, "nearly all values of component ")}) {
        if (extent == 0 || double{grid.range} <= most * extent || (finest > 0 && extent >= finest)) continue;
        finest = extent;
        const double bits = std::max(0.0, std::floor(std::log2(extent / grid_step(grid) + 1)));
        finding.subject = who + std::to_string(c);
        finding.predicate = "keep " + rounded_text(bits) + " of " + std::to_string(wanted_[i]) + " bits";
      }
    if (finest == 0) return;
    const double wanted_step = finest / (std::ldexp(1.0, wanted_[i]) - 1);
    if (grid_step(grid) <= wanted_step) return;
    finding.is_loss = true;
    for (int bits = grid.bits + 1; bits <= kMostBitsOfSpread && finding.better.bits == 0; ++bits)
      if (const AttributeCoding finer = grid_with_bits(grid, bits); grid_step(finer) <= wanted_step)
        finding.better = finer;
  }

  const GuardedMesh& mesh_;
  const Span<const AttributeCoding> codings_;
  const Span<const int> wanted_;
  const ThreadPool& pool_;
  std::vector<PrecisionFinding> findings_;
};

std::string bits_text(int bits) { return std::to_string(bits) + (bits == 1 ? " bit" : " bits"); }

}  // namespace

Expected<std::vector<PrecisionFinding>> find_losses(const GuardedMesh& mesh,
                                                    Span<const AttributeCoding> codings, Span<const int> wanted,
                                                    const ThreadPool& pool) {
  return Guard(mesh, codings, wanted, pool).find();
}

PrecisionNote note_of(const std::string& semantic, const PrecisionFinding& finding, int bits,
                      const AttributeCoding& used, bool is_given, uint64_t values) {
  const std::string exact_bytes = std::to_string(4 * values) + " bytes";
  const auto bytes_of = [&](int count) {
    return std::to_string((values * static_cast<uint64_t>(count) + 7) / 8);
  };
  if (finding.predicate.empty())
    return {semantic + " is kept exactly, in at most " + exact_bytes + " instead of " + bytes_of(bits) + ": " +
            finding.subject};
  const std::string loss =
      finding.subject + (is_given ? " " : " would ") + finding.predicate + " with " + bits_text(bits);
  if (is_given)
    return {semantic + ": " + loss + ", as given; " +
                (finding.better.bits > 0 ? bits_text(finding.better.bits) : "only exact values") +
                " would keep them apart",
            true};
  if (used.bits == 0)
    return {semantic + " is kept exactly, in at most " + exact_bytes + " instead of " + bytes_of(bits) + ": " +
            loss};
  return {semantic + " gets " + bits_text(used.bits) + ", which takes at most " + bytes_of(used.bits - bits) +
          " bytes more: " + loss};
}

Expected<std::vector<PrecisionNote>> guard_codings(const GuardedMesh& mesh, Span<const Attribute> attributes,
                                                   const CodingOptions& options, Span<const int> wanted,
                                                   const ThreadPool& pool,
                                                   std::vector<AttributeCoding>& codings) {
  const auto findings = find_losses(mesh, codings, wanted, pool);
  if (!findings) return findings.status();
  std::vector<PrecisionNote> notes;
  for (size_t i = 0; i < codings.size(); ++i) {
    const PrecisionFinding& finding = (*findings)[i];
    if (!finding.is_loss) continue;
    const int bits = codings[i].bits > 0 ? codings[i].bits : wanted[i];
    const bool is_given = are_given(attributes[i], options);
    if (!is_given) codings[i] = finding.better;
    notes.push_back(note_of(attributes[i].semantic, finding, bits, codings[i], is_given, finding.values));
  }
  return notes;
}

}  // namespace psplit
