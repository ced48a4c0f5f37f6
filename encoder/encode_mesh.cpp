#include "encoder/encode_mesh.h"

#include "encoder/coding/grid_places.h"
#include "encoder/condensing/condense_container.h"
#include "encoder/draco/draco_backend.h"
#include "encoder/draco/patch_stream.h"
#include "encoder/encode_streams.h"
#include "encoder/welding/reduce.h"
#include "src/container/patch_container.h"
#include "src/cpu/cpu_backend.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

uint64_t sum_of_sizes(std::span<const std::vector<uint8_t>> pieces) {
  uint64_t sum = 0;
  for (const std::vector<uint8_t>& piece : pieces) sum += piece.size();
  return sum;
}

// The container of the streams. Nothing if it is to be condensed, and if that does not make it smaller than the
// stream that could be alone.
Expected<std::optional<std::vector<uint8_t>>> join_streams(const Streams& streams, const Stitching& stitching,
                                                           const EncodeOptions& options,
                                                           const ThreadPool& pool) {
  const Expected<std::vector<StreamEntry>> entries = make_entries(streams, stitching);
  if (!entries) return entries.status();
  if (options.condense) {
    // A single stream can also be stored without a container.
    const uint64_t most_bytes = entries->size() == 1
                                    ? entries->front().stream_bytes
                                    : write_container(*entries, streams.has_residue, {}, {}).size() +
                                          sum_of_sizes(stitching.maps) + sum_of_sizes(streams.bytes);
    std::vector<uint8_t> condensed = condense_container(*entries, streams.has_residue, stitching.maps,
                                                        streams.bytes, options.condense_smallest, pool);
    if (condensed.size() < most_bytes) return std::optional(std::move(condensed));
  }
  if (streams.may_be_alone(options.alone)) return std::optional<std::vector<uint8_t>>();
  return std::optional(write_container(*entries, streams.has_residue, stitching.maps, streams.bytes));
}

}  // namespace

Expected<EncodedMesh> encode_mesh(const Mesh& input, std::span<const AttributeCoding> codings,
                                  const EncodeOptions& options, const ThreadPool& pool,
                                  std::span<const std::byte> extra_point_data, size_t extra_stride) {
  if (Status invalid = check_mesh(input, codings); !invalid.ok()) return invalid;
  if (input.faces.empty()) return invalid_input("the mesh has no triangles");
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
  Expected<Streams> streams = encode_streams(mesh, codings, options, options.patch_count, pool, statistics);
  if (!streams) return streams.status();
  encoded.requests = stream_requests(mesh);
  if (!streams->may_be_alone(options.alone) || (options.condense && options.alone != Alone::kAll)) {
    std::vector<PointOwner> owners(mesh.point_count);
    Stitching stitching = build_stitching(streams->owned, 0, owners, pool);
    Expected<std::optional<std::vector<uint8_t>>> container = join_streams(*streams, stitching, options, pool);
    if (!container) return container.status();
    if (*container) {
      encoded.container = std::move(**container);
      encoded.source_point = std::move(stitching.source_point);
    }
  }
  Status status;
  if (encoded.container.empty()) {
    Expected<std::vector<StreamEntry>> entries =
        make_lone_entries(*streams, std::vector<uint8_t>(mesh.point_count, 0));
    if (!entries) return entries.status();
    encoded.entries = std::move(*entries);
    statistics.encode_ms = encode_time.ms();
    if (options.verify) {
      const ScopedStopwatch verify_time(statistics.verify_ms);
      status = verify_alone(mesh, codings, *streams, statistics);
    }
    for (size_t i = 0; i < streams->owned.size(); ++i)
      encoded.lone_streams.push_back(
          {std::move(streams->bytes[i]), std::move(streams->decoded[i]), std::move(streams->owned[i].points)});
  } else {
    streams = Streams();
    Expected<PatchContainer> opened = open_container(encoded.container);
    if (!opened) return runtime_failure("verification: " + opened.status().to_string());
    encoded.entries = opened->entries;
    encoded.head_bytes = opened->head_bytes;
    statistics.encode_ms = encode_time.ms();
    const Stopwatch verify_time;
    // libdraco is the reference. Condensed streams were already expanded to those of libdraco; the core decodes
    // them without expanding.
    const DecodeBackend backend = opened->condensed_count() > 0 ? cpu_backend() : draco_backend();
    Expected<Mesh> decoded = backend.decode(*opened, encoded.requests, pool);
    if (!decoded) return runtime_failure("verification: " + decoded.status().to_string());
    encoded.decoded = std::move(*decoded);
    if (options.verify)
      status = verify_mesh(mesh, codings, encoded.decoded, encoded.source_point, 0, false, statistics);
    if (options.verify) statistics.verify_ms = verify_time.ms();
  }
  if (!status.ok()) return status;
  for (uint32_t& point : encoded.source_point) point = reduced.source_point[point];
  for (LoneStream& stream : encoded.lone_streams)
    for (uint32_t& point : stream.source_point) point = reduced.source_point[point];
  return encoded;
}

}  // namespace psplit
