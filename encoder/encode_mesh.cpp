#include "encoder/encode_mesh.h"

#include "encoder/coding/grid_places.h"
#include "encoder/condensing/condense_container.h"
#include "encoder/draco/draco_backend.h"
#include "encoder/draco/patch_stream.h"
#include "encoder/encode_streams.h"
#include "encoder/verify.h"
#include "encoder/welding/reduce.h"
#include "encoder/welding/weld.h"
#include "src/container/patch_container.h"
#include "src/cpu/cpu_backend.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

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
  if (Status status = check_mesh(input, codings); !status.ok()) return status;
  if (extra_point_data.size() != extra_stride * input.point_count)
    return invalid_input("extra data of the wrong size");
  EncodedMesh encoded;
  EncodeStatistics& statistics = encoded.statistics;
  const Stopwatch encode_time;
  const ReducedMesh reduced = reduce(
      input,
      {options.keep_duplicates, options.drop_degenerate, options.drop_unused, places_on_grids(input, codings)},
      extra_point_data, extra_stride);
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
  std::vector<PointOwner> owners(mesh.point_count);
  Stitching stitching = build_stitching(streams.owned, 0, owners, pool);
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
    statistics.position_error = largest_distance(mesh, *decoded, stitching.source_point);
    encoded.decoded = std::move(*decoded);
    statistics.verify_ms = verify_time.ms();
  }
  encoded.source_point = std::move(stitching.source_point);
  for (uint32_t& point : encoded.source_point) point = reduced.source_point[point];
  return encoded;
}

}  // namespace psplit
