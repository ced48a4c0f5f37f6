#include "encoder/encode_mesh.h"

#include "encoder/coding/quantization.h"
#include "encoder/condensing/condense_container.h"
#include "encoder/cut_faces.h"
#include "encoder/draco/draco_backend.h"
#include "encoder/draco/patch_stream.h"
#include "encoder/stitching/build_stitching.h"
#include "encoder/verify.h"
#include "encoder/welding/reduce.h"
#include "encoder/welding/weld.h"
#include "src/container/patch_container.h"
#include "src/cpu/cpu_backend.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

Status check_input(const Mesh& mesh, std::span<const AttributeCoding> codings, std::span<const std::byte> extra,
                   size_t extra_stride) {
  if (mesh.find("POSITION") == nullptr) return invalid_input("the mesh has no POSITION");
  if (mesh.faces.empty()) return invalid_input("the mesh has no triangles");
  if (codings.size() != mesh.attributes.size()) return invalid_input("one coding is needed per attribute");
  if (extra.size() != extra_stride * mesh.point_count) return invalid_input("extra data of the wrong size");
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

// Everything that goes into a container.
struct Streams {
  std::vector<OwnedStream> owned;
  std::vector<std::vector<uint8_t>> bytes;
  bool has_residue = false;
};

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

Status encode_residue(const WeldedMesh& welded, const Cut& cut, std::span<const AttributeCoding> codings,
                      const EncodeOptions& options, Streams& streams, EncodeStatistics& statistics) {
  Residue residue = extract_residue(*welded.mesh, cut, options.standalone_residue);
  statistics.residue_faces = residue.face_count;
  statistics.residue_points = residue.owned_count;
  if (residue.patch.points.empty()) return {};
  Expected<std::vector<uint8_t>> bytes =
      encode_sequential(welded, residue.patch, codings, options.encode_speed);
  if (!bytes) return bytes.status();
  streams.has_residue = true;
  streams.bytes.push_back(std::move(*bytes));
  residue.patch.faces.resize(residue.face_count);
  streams.owned.push_back({std::move(residue.patch.faces), std::move(residue.patch.points), true});
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

Expected<std::vector<uint8_t>> join_streams(const Streams& streams, const Stitching& stitching,
                                            const EncodeOptions& options, const ThreadPool& pool) {
  const Expected<std::vector<StreamEntry>> entries = make_entries(streams, stitching);
  if (!entries) return entries.status();
  std::vector<uint8_t> container =
      write_container(*entries, streams.has_residue, stitching.maps, streams.bytes);
  if (!options.condense) return container;
  // A single stream can also be stored without a container.
  const size_t most_bytes = entries->size() == 1 ? entries->front().stream_bytes : container.size();
  auto condensed = condense_container(*entries, streams.has_residue, stitching.maps, streams.bytes,
                                      options.condense_smallest, pool);
  return condensed && condensed->size() < most_bytes ? std::move(*condensed) : std::move(container);
}

}  // namespace

Expected<EncodedMesh> encode_mesh(const Mesh& input, std::span<const AttributeCoding> codings,
                                  const EncodeOptions& options, const ThreadPool& pool,
                                  std::span<const std::byte> extra_point_data, size_t extra_stride) {
  if (Status status = check_input(input, codings, extra_point_data, extra_stride); !status.ok()) return status;
  EncodedMesh encoded;
  EncodeStatistics& statistics = encoded.statistics;
  const Stopwatch encode_time;
  const ReducedMesh reduced =
      reduce(input, {options.keep_duplicates, options.drop_degenerate, options.drop_unused}, extra_point_data,
             extra_stride);
  statistics.merged_points = reduced.merged_points;
  statistics.dropped_faces = reduced.dropped_faces;
  statistics.dropped_points = reduced.dropped_points;
  const Mesh& mesh = reduced.mesh;
  if (mesh.faces.empty()) return unsupported("no triangles but degenerate ones");
  if (!options.patch_of_face.empty() && options.patch_of_face.size() != mesh.faces.size())
    return Status(StatusCode::kUsage, "a partition of another number of faces");
  WeldedMesh welded = weld(mesh, pool);
  separate_flat_faces(welded);

  const Stopwatch partition_time;
  const Cut cut = cut_faces(welded, {options.patch_count, options.refine, options.method, options.distance},
                            options.patch_of_face, pool);
  statistics.partition_ms = partition_time.ms();
  statistics.patch_count = static_cast<uint32_t>(cut.patches.size());
  Streams streams;
  if (Status status = encode_patches(welded, cut, codings, options, pool, streams); !status.ok()) return status;
  if (Status status = encode_residue(welded, cut, codings, options, streams, statistics); !status.ok())
    return status;
  Stitching stitching = build_stitching(streams.owned, mesh.point_count, pool);
  Expected<std::vector<uint8_t>> container = join_streams(streams, stitching, options, pool);
  if (!container) return container.status();
  encoded.container = std::move(*container);
  encoded.requests = stream_requests(mesh);
  Expected<PatchContainer> opened = open_container(encoded.container);
  if (!opened) return runtime_failure("verification: " + opened.status().to_string());
  encoded.opened = std::make_shared<const PatchContainer>(std::move(*opened));
  statistics.encode_ms = encode_time.ms();

  if (options.verify) {
    const Stopwatch verify_time;
    // Condensed streams were already expanded to those of libdraco. The core decodes them without expanding.
    const DecodeBackend backend = encoded.opened->condensed_count() > 0 ? cpu_backend() : draco_backend();
    Expected<Mesh> decoded = backend.decode(*encoded.opened, encoded.requests, pool);
    if (!decoded) return runtime_failure("verification: " + decoded.status().to_string());
    if (Status status = verify_decoded(mesh, codings, *decoded, stitching.source_point); !status.ok())
      return status;
    encoded.decoded = std::move(*decoded);
    statistics.verify_ms = verify_time.ms();
  }
  encoded.source_point = std::move(stitching.source_point);
  for (uint32_t& point : encoded.source_point) point = reduced.source_point[point];
  return encoded;
}

}  // namespace psplit
