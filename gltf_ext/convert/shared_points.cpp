#include "gltf_ext/convert/shared_points.h"

#include <utility>

#include "src/mesh/select_points.h"

namespace psplit {
namespace {

// Drops the points that are not kept; no face uses them.
void keep_points(EncodeJob& job, const std::vector<uint8_t>& keep) {
  std::vector<uint32_t> kept, number(keep.size(), 0);
  for (uint32_t point = 0; point < keep.size(); ++point) {
    if (keep[point] == 0) continue;
    number[point] = static_cast<uint32_t>(kept.size());
    kept.push_back(point);
  }
  Mesh& mesh = job.source.mesh;
  Mesh selected = select_points(mesh, kept);
  selected.faces = std::move(mesh.faces);
  mesh = std::move(selected);
  for (auto& face : mesh.faces)
    for (uint32_t& point : face) point = number[point];
  job.morphs = reorder(job.morphs, kept);
  if (!job.numbers.empty()) job.numbers = select_rows(job.numbers, job.numbers.size() / keep.size(), kept);
}

}  // namespace

void SharedPoints::divide(const Document& document, std::vector<EncodeJob>& jobs) {
  EncodeJob& job = jobs.back();
  const PrimitiveId id = job.group.ids.front();
  const PrimitiveRecord& primitive = document.records().primitive(id);
  if (primitive.storage() != PrimitiveStorage::kPlain) return;
  const auto [found, is_first] =
      sets_.try_emplace({primitive.attributes, primitive.targets}, Set{jobs.size() - 1, {}});
  if (is_first) return;
  std::vector<uint8_t>& used_by_others = found->second.used_by_others;
  const std::vector<uint8_t> used = used_points(job.source.mesh);
  used_by_others.resize(used.size(), 0);
  for (size_t i = 0; i < used.size(); ++i) used_by_others[i] |= used[i];
  keep_points(job, used);
}

void SharedPoints::finish(std::vector<EncodeJob>& jobs) const {
  for (const auto& [key, set] : sets_) {
    if (set.used_by_others.empty()) continue;
    std::vector<uint8_t> keep = used_points(jobs[set.first].source.mesh);
    for (size_t i = 0; i < keep.size(); ++i)
      if (set.used_by_others[i] == 0) keep[i] = 1;
    keep_points(jobs[set.first], keep);
  }
}

}  // namespace psplit
