#include "gltf_ext/convert/shared_points.h"

#include <cstring>

namespace psplit {
namespace {

std::vector<bool> used_points(const Mesh& mesh) {
  std::vector<bool> used(mesh.point_count, false);
  for (const auto& face : mesh.faces)
    for (const uint32_t point : face) used[point] = true;
  return used;
}

// Drops the points that are not kept; no face uses them.
void keep_points(EncodeJob& job, const std::vector<bool>& keep) {
  std::vector<uint32_t> kept, number(keep.size(), 0);
  for (uint32_t point = 0; point < keep.size(); ++point) {
    if (!keep[point]) continue;
    number[point] = static_cast<uint32_t>(kept.size());
    kept.push_back(point);
  }
  Mesh& mesh = job.source.mesh;
  for (Attribute& attribute : mesh.attributes) {
    const size_t stride = attribute.stride();
    Array<std::byte> values(stride * kept.size());
    for (size_t i = 0; i < kept.size(); ++i)
      std::memcpy(values.data() + i * stride, attribute.values.data() + kept[i] * stride, stride);
    attribute.values = std::move(values);
  }
  for (auto& face : mesh.faces)
    for (uint32_t& point : face) point = number[point];
  mesh.point_count = static_cast<uint32_t>(kept.size());
  job.morphs = reorder(job.morphs, kept);
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
  std::vector<bool>& used_by_others = found->second.used_by_others;
  const std::vector<bool> used = used_points(job.source.mesh);
  used_by_others.resize(used.size(), false);
  for (size_t i = 0; i < used.size(); ++i)
    if (used[i]) used_by_others[i] = true;
  keep_points(job, used);
}

void SharedPoints::finish(std::vector<EncodeJob>& jobs) const {
  for (const auto& [key, set] : sets_) {
    if (set.used_by_others.empty()) continue;
    std::vector<bool> keep = used_points(jobs[set.first].source.mesh);
    for (size_t i = 0; i < keep.size(); ++i) keep[i] = keep[i] || !set.used_by_others[i];
    keep_points(jobs[set.first], keep);
  }
}

}  // namespace psplit
