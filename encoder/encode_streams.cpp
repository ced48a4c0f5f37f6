#include "encoder/encode_streams.h"

#include "encoder/coding/quantization.h"
#include "encoder/draco/patch_stream.h"

namespace psplit {

Status check_mesh(const Mesh& mesh, std::span<const AttributeCoding> codings) {
  if (mesh.find("POSITION") == nullptr) return invalid_input("the mesh has no POSITION");
  if (mesh.faces.empty()) return invalid_input("the mesh has no triangles");
  if (codings.size() != mesh.attributes.size()) return invalid_input("one coding is needed per attribute");
  for (size_t i = 0; i < codings.size(); ++i) {
    const Attribute& attribute = mesh.attributes[i];
    const AttributeCoding& coding = codings[i];
    const bool is_float = attribute.component_type == ComponentType::kFloat32;
    if (attribute.component_count < 1 || attribute.component_count > 16)
      return unsupported(attribute.semantic + " has " + std::to_string(attribute.component_count) +
                         " components");
    if (attribute.values.size() != attribute.stride() * mesh.point_count)
      return invalid_input(attribute.semantic + " has values for another number of points");
    // glTF has none, and libdraco's encoder takes memory by the largest value.
    if (attribute.component_type == ComponentType::kUint32)
      return unsupported(attribute.semantic + " holds 32-bit integers");
    if (coding.bits == 0) continue;
    if (!is_float || coding.bits < (coding.octahedral ? 2 : 1) || coding.bits > 30)
      return invalid_input(attribute.semantic + " cannot be quantized to " + std::to_string(coding.bits) +
                           " bits");
    if (coding.octahedral ? attribute.component_count != 3 : coding.origin.size() != attribute.component_count)
      return invalid_input(attribute.semantic + " has no grid of its number of components");
    if (!coding.octahedral && !grid_extremes(coding))
      return invalid_input(attribute.semantic + ": no floats are exactly its grid's range apart; see fit_grid");
  }
  for (const auto& face : mesh.faces)
    for (uint32_t point : face)
      if (point >= mesh.point_count)
        return invalid_input("an index is " + std::to_string(point) + ", but there are " +
                             std::to_string(mesh.point_count) + " points");
  return {};
}

Status encode_patches(const WeldedMesh& welded, const Cut& cut, std::span<const AttributeCoding> codings,
                      const EncodeOptions& options, const ThreadPool& pool, Streams& streams) {
  const size_t patch_count = cut.patches.size();
  streams.owned.resize(patch_count);
  streams.bytes.resize(patch_count);
  std::vector<Status> statuses(patch_count);
  pool.for_each(patch_count, [&](size_t i) {
    const PatchMesh patch = extract(*welded.mesh, cut.patches[i]);
    Expected<std::vector<uint8_t>> bytes = encode_edgebreaker(welded, patch, codings, options.encode_speed);
    Expected<DecodedOrder> order = edgebreaker_order(welded, patch, options.encode_speed);
    if (!bytes || !order) {
      statuses[i] = (bytes ? order.status() : bytes.status()).at({.patch = static_cast<int64_t>(i)});
      return;
    }
    streams.bytes[i] = std::move(*bytes);
    OwnedStream& owned = streams.owned[i];
    owned.faces = std::move(order->faces);
    owned.points.reserve(order->patch_point.size());
    for (const uint32_t point : order->patch_point) owned.points.push_back(patch.points[point]);
    if (options.patch_encoded) options.patch_encoded(cut.patches[i].size());
  });
  for (Status& status : statuses)
    if (!status.ok()) return std::move(status);
  return {};
}

Expected<std::vector<StreamEntry>> make_entries(const Streams& streams, const Stitching& stitching) {
  std::vector<StreamEntry> entries;
  for (size_t i = 0; i < streams.owned.size(); ++i) {
    if (streams.bytes[i].size() > 0xffffffffu) return unsupported("a patch takes more than 4 GB");
    entries.push_back({static_cast<uint32_t>(streams.bytes[i].size()),
                       static_cast<uint32_t>(streams.owned[i].faces.size()),
                       static_cast<uint32_t>(streams.owned[i].points.size()), stitching.reference_counts[i],
                       static_cast<uint32_t>(stitching.maps[i].size())});
  }
  return entries;
}

}  // namespace psplit
