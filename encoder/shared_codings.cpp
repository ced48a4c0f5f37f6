#include "encoder/shared_codings.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "encoder/coding/position_bits.h"
#include "encoder/coding/quantization.h"
#include "encoder/kept_grids.h"

namespace psplit {

bool is_shared(const std::string& semantic) {
  return semantic == "POSITION" || semantic.starts_with("WEIGHTS_");
}

SharedCodings choose_shared_codings(std::span<MeshToEncode* const> meshes, const EncodeOptions& options,
                                    const ThreadPool& pool, std::span<const KeptMesh> kept) {
  std::vector<std::vector<AttributeCoding>> codings(meshes.size());
  std::vector<StoredFlags> stored(meshes.size());
  std::vector<std::vector<CodingBounds>> bounds(meshes.size());
  pool.for_each(meshes.size(), [&](size_t k) {
    Mesh& mesh = meshes[k]->mesh;
    for (Attribute& attribute : mesh.attributes)
      if (wanted_bits(attribute, options) > 0) trim_noise(attribute);
    stored[k] = stored_points(*meshes[k], options, pool);
    for (const Attribute& attribute : mesh.attributes) {
      bounds[k].push_back(wanted_bounds(attribute, options, stored[k]));
      codings[k].push_back(choose_coding(attribute, bounds[k].back(), options));
    }
  });
  const auto is_final = keep_grids(meshes, kept, options, bounds, stored, codings, pool);
  std::map<std::tuple<size_t, std::string, size_t>, CodingBounds> joined;
  const auto visit = [&](const auto& act) {
    for (size_t k = 0; k < meshes.size(); ++k)
      for (size_t i = 0; i < codings[k].size(); ++i) {
        const Attribute& attribute = meshes[k]->mesh.attributes[i];
        AttributeCoding& coding = codings[k][i];
        // Values that come back as they are fit to all others.
        if (coding.bits > 0 && !coding.octahedral && !coding.exact && !is_final[k][i] &&
            is_shared(attribute.semantic))
          act(joined[{meshes[k]->group, attribute.semantic, attribute.component_count}], bounds[k][i],
              attribute, coding);
      }
  };
  visit([](CodingBounds& all, const CodingBounds& own, const auto&...) { all.add(own); });
  visit([&](const CodingBounds& all, const CodingBounds&, const Attribute& attribute, AttributeCoding& coding) {
    AttributeCoding shared = choose_coding(attribute, all, options);
    if (shared.bits > 0) coding = std::move(shared);
  });
  return {std::move(codings), std::move(stored)};
}

Expected<int> choose_position_bits(const AttributeCoding& coding, std::optional<double> max_error,
                                   double step) {
  return max_error ? position_bits_for_error(coding, *max_error) : position_bits_for_step(coding, step);
}

Status choose_position_bits(std::span<MeshToEncode* const> meshes, std::optional<double> max_error,
                            std::span<std::vector<AttributeCoding>> codings, size_t& mesh) {
  std::map<size_t, double> steps;  // the finest that the edges of one of the group's meshes want
  for (size_t k = 0; k < meshes.size() && !max_error; ++k) {
    EdgeSample sample;
    sample.add(meshes[k]->mesh);
    const double step = step_for_edges(sample.lengths());
    if (step == 0) continue;
    const auto [found, is_new] = steps.emplace(meshes[k]->group, step);
    if (!is_new) found->second = std::min(found->second, step);
  }
  for (mesh = 0; mesh < meshes.size(); ++mesh)
    for (size_t i = 0; i < codings[mesh].size(); ++i) {
      AttributeCoding& coding = codings[mesh][i];
      if (coding.bits == 0 || coding.exact || meshes[mesh]->mesh.attributes[i].semantic != "POSITION") continue;
      const Expected<int> bits = choose_position_bits(coding, max_error, steps[meshes[mesh]->group]);
      if (!bits) return bits.status();
      coding.bits = *bits;
    }
  return {};
}

std::vector<std::vector<PrecisionNote>> guard_precision(std::span<MeshToEncode* const> meshes,
                                                        const EncodeOptions& options, SharedCodings& chosen,
                                                        const ThreadPool& pool) {
  std::vector<std::vector<AttributeCoding>>& codings = chosen.codings;
  // apply_own_codings replaces the coding, so that what a chosen one loses says nothing.
  const auto has_own_coding = [&](size_t k, size_t i) { return meshes[k]->own_codings.contains(i); };
  std::vector<std::vector<PrecisionFinding>> findings(meshes.size());
  std::vector<std::vector<int>> wanted(meshes.size());
  pool.for_each(meshes.size(), [&](size_t k) {
    const Mesh& mesh = meshes[k]->mesh;
    GuardedMesh guarded{[&](const GuardedMesh::VisitPart& visit) {
      visit(mesh, chosen.stored[k]);
      return Status();
    }};
    for (size_t i = 0; i < mesh.attributes.size(); ++i) {
      const Attribute& attribute = mesh.attributes[i];
      wanted[k].push_back(has_own_coding(k, i) ? 0 : wanted_bits(attribute, options));
      const auto scale = meshes[k]->texture_scales.find(attribute.semantic);
      guarded.texture_scales.push_back(scale == meshes[k]->texture_scales.end() ? 1 : scale->second);
    }
    if (auto found = find_losses(guarded, codings[k], wanted[k], pool)) findings[k] = std::move(*found);
  });
  // What becomes of the grids that groups share, and how many values they have.
  struct SharedGrid {
    std::optional<AttributeCoding> better;
    uint64_t values = 0;
    bool is_kept = false;  // values of a mesh are on it already
  };
  std::map<std::tuple<size_t, std::string, size_t>, SharedGrid> shared;
  const auto visit = [&](const auto& act) {
    for (size_t k = 0; k < meshes.size(); ++k)
      for (size_t i = 0; i < findings[k].size(); ++i) {
        if (has_own_coding(k, i)) continue;
        const Attribute& attribute = meshes[k]->mesh.attributes[i];
        const bool is_joined =
            is_shared(attribute.semantic) && codings[k][i].bits > 0 && !codings[k][i].octahedral;
        act(k, i, attribute,
            is_joined ? &shared[{meshes[k]->group, attribute.semantic, attribute.component_count}] : nullptr);
      }
  };
  visit([&](size_t k, size_t i, const Attribute& attribute, SharedGrid* grid) {
    const PrecisionFinding& finding = findings[k][i];
    if (grid == nullptr) return;
    grid->is_kept |= codings[k][i].exact;
    grid->values += finding.values;
    if (!finding.is_loss || are_given(attribute, options)) return;
    const bool is_exact = finding.better.bits == 0;
    if (!grid->better || is_exact || (grid->better->bits > 0 && finding.better.bits > grid->better->bits))
      grid->better = finding.better;
  });
  std::vector<std::vector<PrecisionNote>> notes(meshes.size());
  visit([&](size_t k, size_t i, const Attribute& attribute, const SharedGrid* grid) {
    const PrecisionFinding& finding = findings[k][i];
    AttributeCoding& coding = codings[k][i];
    const int bits = coding.bits > 0 ? coding.bits : wanted[k][i];
    const bool is_given = are_given(attribute, options) || (grid != nullptr && grid->is_kept);
    if (grid != nullptr && grid->better && !grid->is_kept)
      coding = *grid->better;
    else if (finding.is_loss && !is_given)
      coding = finding.better;
    if (finding.is_loss)
      notes[k].push_back(note_of(attribute.semantic, finding, bits, coding, is_given,
                                 grid != nullptr ? grid->values : finding.values));
  });
  return notes;
}

}  // namespace psplit
