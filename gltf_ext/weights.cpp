#include "gltf_ext/weights.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace psplit {
namespace {

struct Weight {
  std::byte* place = nullptr;
  int steps = 0;        // below the value
  double fraction = 0;  // of a step, above that
};

// Of largest fractions first: as many steps up as are missing from the whole.
void round_point(std::span<Weight> weights, int step_count) {
  double sum = 0;
  int missing = step_count;
  for (Weight& weight : weights) {
    float value = 0;
    std::memcpy(&value, weight.place, sizeof value);
    sum += static_cast<double>(value);
    const double scaled = static_cast<double>(value) * step_count;
    weight.steps = static_cast<int>(scaled);
    weight.fraction = scaled - weight.steps;
    missing -= weight.steps;
  }
  // Weights that do not sum to one in the input are left to quantization.
  if (std::fabs(sum - 1) > 1e-3 || missing < 0 || missing > static_cast<int>(weights.size())) return;
  std::stable_sort(weights.begin(), weights.end(),
                   [](const Weight& a, const Weight& b) { return a.fraction > b.fraction; });
  const float step = 1.0f / static_cast<float>(step_count);
  for (Weight& weight : weights) {
    const float value = static_cast<float>(weight.steps + (missing-- > 0 ? 1 : 0)) * step;
    std::memcpy(weight.place, &value, sizeof value);
  }
}

}  // namespace

void round_weights(Mesh& mesh, std::span<const AttributeCoding> codings) {
  std::vector<Attribute*> attributes;
  int bits = 0;
  for (size_t i = 0; i < mesh.attributes.size(); ++i) {
    const AttributeCoding& coding = codings[i];
    if (!mesh.attributes[i].semantic.starts_with("WEIGHTS_") || !is_unit_grid(coding)) continue;
    attributes.push_back(&mesh.attributes[i]);
    bits = coding.bits;
  }
  std::vector<Weight> weights;
  for (uint32_t point = 0; point < mesh.point_count && !attributes.empty(); ++point) {
    weights.clear();
    for (Attribute* attribute : attributes)
      for (size_t k = 0; k < attribute->component_count; ++k)
        weights.push_back({attribute->values.data() + point * attribute->stride() + k * sizeof(float)});
    round_point(weights, (1 << bits) - 1);
  }
}

}  // namespace psplit
