#include "encoder/coding/target_codings.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "encoder/coding/quantization.h"
#include "psplit/mesh.h"

namespace psplit {
namespace {

constexpr int kMantissa = 24;  // of a float, in bits
// Every place of a grid is a float if its number and the step have no more bits together.
constexpr int kMostStepBits = 8, kMostTargetBits = 22;

struct Target {
  MeshToEncode* mesh = nullptr;
  size_t attribute = 0;
  CodingBounds bounds;
};

// Targets with one step.
struct TargetGroup {
  double step = 0;
  std::vector<Target> targets;
};

// The wanted step of a target; 0 if its deltas stay exact.
double wanted_step(const MeshToEncode& mesh, const std::string& base, const CodingOptions& options) {
  for (size_t i = 0; i < mesh.codings.size(); ++i) {
    const AttributeCoding& coding = mesh.codings[i];
    if (mesh.mesh.attributes[i].semantic != base || coding.bits == 0) continue;
    const auto places = [](int bits) { return std::exp2(bits) - 1; };
    const double step = coding.octahedral ? 2 / places(coding.bits) : grid_step(coding);
    return options.morph_bits == 0 ? step : step * places(coding.bits) / places(options.morph_bits);
  }
  return 0;
}

// A float of at most `bits` bits that is not above the step.
float shorten(double step, int bits) {
  int exponent = 0;
  const double mantissa = std::frexp(step, &exponent);
  return static_cast<float>(std::ldexp(std::floor(std::ldexp(mantissa, bits)), exponent - bits));
}

// The place of a delta on a grid that begins at 0. Equal deltas have equal places, whatever the origin of their
// grid is.
int64_t place_of(float delta, double step) { return static_cast<int64_t>(std::floor(delta / step + 0.5)); }

// The grid of places from `low` on, which zero is one of.
struct Places {
  std::vector<int64_t> low;
  int bits = 1;

  Places(const CodingBounds& bounds, double step) {
    int64_t most = 1;
    for (size_t c = 0; c < bounds.low.size(); ++c) {
      low.push_back(std::min(int64_t{0}, place_of(bounds.low[c], step)));
      most = std::max(most, std::max(int64_t{0}, place_of(bounds.high[c], step)) - low.back());
    }
    bits = static_cast<int>(std::bit_width(static_cast<uint64_t>(most)));
  }
};

void round_values(MeshToEncode& mesh, size_t i, float step) {
  Attribute& attribute = mesh.mesh.attributes[i];
  mesh.unrounded.push_back(attribute);
  for (size_t at = 0; at < attribute.values.size(); at += sizeof(float)) {
    float delta;
    std::memcpy(&delta, attribute.values.data() + at, sizeof delta);
    delta = static_cast<float>(place_of(delta, step)) * step;
    std::memcpy(attribute.values.data() + at, &delta, sizeof delta);
  }
}

void set_grids(const TargetGroup& group) {
  constexpr double kLeastStep = 0x1p-100, kMostStep = 0x1p100;  // far from the ends of floats
  if (!(group.step >= kLeastStep && group.step <= kMostStep)) return;
  int most_bits = 0;
  for (const Target& target : group.targets)
    for (const auto& bounds : {target.bounds.low, target.bounds.high})
      for (const float bound : bounds)
        if (!(std::fabs(bound) < std::exp2(kMostTargetBits - 1) * group.step)) return;
  for (const Target& target : group.targets)
    most_bits = std::max(most_bits, Places(target.bounds, group.step).bits);
  // A shorter step may need one bit more.
  const float step = shorten(group.step, std::clamp(kMantissa - most_bits - 1, 1, kMostStepBits));
  for (const Target& target : group.targets) {
    const Places places(target.bounds, step);
    AttributeCoding& coding = target.mesh->codings[target.attribute];
    coding = {};
    coding.bits = places.bits;
    coding.range = step * static_cast<float>((1u << places.bits) - 1);
    for (const int64_t low : places.low) coding.origin.push_back(static_cast<float>(low) * step);
    round_values(*target.mesh, target.attribute, step);
  }
}

}  // namespace

void choose_target_codings(Span<MeshToEncode* const> meshes, const CodingOptions& options) {
  std::map<std::pair<size_t, std::string>, TargetGroup> groups;
  for (MeshToEncode* const mesh : meshes)
    for (size_t i = 0; i < mesh->mesh.attributes.size(); ++i) {
      const Attribute& attribute = mesh->mesh.attributes[i];
      const auto target = target_of(attribute.semantic);
      if (!target || attribute.component_type != ComponentType::kFloat32 || mesh->own_codings.contains(i) ||
          options.lossless)
        continue;
      const double step = wanted_step(*mesh, target->semantic, options);
      CodingBounds bounds = bounds_of(attribute, 1);
      if (step == 0 || !bounds.is_finite) continue;
      TargetGroup& group = groups[{mesh->group, target->semantic}];
      group.step = group.step == 0 ? step : std::min(group.step, step);
      group.targets.push_back({mesh, i, std::move(bounds)});
    }
  for (const auto& [key, group] : groups) set_grids(group);
}

}  // namespace psplit
