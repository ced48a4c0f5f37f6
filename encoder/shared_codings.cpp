#include "encoder/shared_codings.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "encoder/coding/position_bits.h"
#include "encoder/coding/quantization.h"

namespace psplit {

std::vector<std::vector<AttributeCoding>> choose_shared_codings(std::span<const MeshToCode> meshes,
                                                                const CodingOptions& options,
                                                                const std::set<std::string>& exact,
                                                                const ThreadPool& pool) {
  std::vector<std::vector<AttributeCoding>> codings(meshes.size());
  std::vector<std::vector<CodingBounds>> bounds(meshes.size());
  pool.for_each(meshes.size(), [&](size_t k) {
    Mesh& mesh = *meshes[k].mesh;
    for (Attribute& attribute : mesh.attributes)
      if (wanted_bits(attribute, options, exact) > 0) trim_noise(attribute);
    const std::vector<uint8_t> stored = meshes[k].stored_points();
    for (const Attribute& attribute : mesh.attributes) {
      const int bits = wanted_bits(attribute, options, exact);
      bounds[k].push_back(bits == 0 ? CodingBounds() : bounds_of(attribute, bits, stored));
      codings[k].push_back(choose_coding(attribute, bounds[k].back(), bits));
    }
  });
  std::map<std::tuple<size_t, std::string, size_t>, CodingBounds> joined;
  const auto visit = [&](const auto& act) {
    for (size_t k = 0; k < meshes.size(); ++k)
      for (size_t i = 0; i < codings[k].size(); ++i) {
        const Attribute& attribute = meshes[k].mesh->attributes[i];
        AttributeCoding& coding = codings[k][i];
        if (coding.bits > 0 && !coding.octahedral)
          act(joined[{meshes[k].group, attribute.semantic, attribute.component_count}], bounds[k][i], attribute,
              coding);
      }
  };
  visit([](CodingBounds& all, const CodingBounds& own, const auto&...) { all.add(own); });
  visit([&](const CodingBounds& all, const CodingBounds&, const Attribute& attribute, AttributeCoding& coding) {
    AttributeCoding shared = choose_coding(attribute, all, wanted_bits(attribute, options, exact));
    if (shared.bits > 0) coding = std::move(shared);
  });
  return codings;
}

Expected<int> choose_position_bits(const AttributeCoding& coding, std::optional<double> max_error,
                                   double step) {
  return max_error ? position_bits_for_error(coding, *max_error) : position_bits_for_step(coding, step);
}

Status choose_position_bits(std::span<const MeshToCode> meshes, std::optional<double> max_error,
                            std::span<std::vector<AttributeCoding>> codings, size_t& mesh) {
  std::map<size_t, double> steps;  // the finest that the edges of one of the group's meshes want
  for (size_t k = 0; k < meshes.size() && !max_error; ++k) {
    EdgeSample sample;
    sample.add(*meshes[k].mesh);
    const double step = step_for_edges(sample.lengths());
    if (step == 0) continue;
    const auto [found, is_new] = steps.emplace(meshes[k].group, step);
    if (!is_new) found->second = std::min(found->second, step);
  }
  for (mesh = 0; mesh < meshes.size(); ++mesh)
    for (size_t i = 0; i < codings[mesh].size(); ++i) {
      AttributeCoding& coding = codings[mesh][i];
      if (coding.bits == 0 || meshes[mesh].mesh->attributes[i].semantic != "POSITION") continue;
      const Expected<int> bits = choose_position_bits(coding, max_error, steps[meshes[mesh].group]);
      if (!bits) return bits.status();
      coding.bits = *bits;
    }
  return {};
}

}  // namespace psplit
