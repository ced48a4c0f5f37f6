#include "encoder/encode_mesh.h"

#include <utility>

#include "encoder/coding/grid_places.h"
#include "encoder/condensing/condense.h"
#include "encoder/encode_parts.h"
#include "encoder/encode_streams.h"
#include "encoder/welding/reduce.h"
#include "src/container/patch_container.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

Expected<std::vector<uint8_t>> read_all(StoredBytes& bytes) {
  std::vector<uint8_t> read(static_cast<size_t>(bytes.size()));
  if (Status status = bytes.read(0, read); !status.ok()) return status;
  return read;
}

Expected<EncodedMesh> encode_one_way(const Mesh& input, Span<const AttributeCoding> codings,
                                     const EncodeOptions& options, const ThreadPool& pool,
                                     Span<const std::byte> extra_point_data, size_t extra_stride) {
  if (Status invalid = check_mesh(input, codings); !invalid.ok()) return invalid;
  if (input.faces.empty()) return invalid_input("the mesh has no triangles");
  if (extra_point_data.size() != extra_stride * input.point_count)
    return invalid_input("extra data of the wrong size");
  const Stopwatch encode_time;
  ReducedMesh reduced = reduce(
      input,
      {options.keep_duplicates, options.drop_degenerate, options.drop_unused, places_on_grids(input, codings)},
      pool, extra_point_data, extra_stride);
  // Often nothing is merged or dropped. Then there is one mesh in memory, not two.
  const bool is_as_it_was = reduced.merged_points + reduced.dropped_faces + reduced.dropped_points == 0;
  if (is_as_it_was)
    reduced = ReducedMesh();
  else if (options.free_input)
    options.free_input();
  const Mesh& mesh = is_as_it_was ? input : reduced.mesh;
  const double reduce_ms = encode_time.ms();
  if (mesh.faces.empty()) return unsupported("no triangles but degenerate ones");
  if (!options.patch_of_face.empty() && options.patch_of_face.size() != mesh.faces.size())
    return Status(StatusCode::kUsage, "a partition of another number of faces");
  Expected<EncodedParts> parts = encode_whole(mesh, codings, options, pool);
  if (!parts) return parts.status();

  EncodedMesh encoded;
  encoded.requests = std::move(parts->requests);
  EncodeStatistics& statistics = encoded.statistics = parts->statistics;
  statistics.merged_points = reduced.merged_points;
  statistics.dropped_faces = reduced.dropped_faces;
  statistics.dropped_points = reduced.dropped_points;
  statistics.encode_ms += reduce_ms;
  for (PartsContainer& stored : parts->containers) {
    Expected<std::vector<uint8_t>> bytes = read_all(*stored.bytes);
    if (!bytes) return bytes.status();
    if (!is_as_it_was)
      for (uint32_t& point : stored.source_point) point = reduced.source_point[point];
    encoded.entries.insert(encoded.entries.end(), stored.entries.begin(), stored.entries.end());
    if (stored.is_alone) {
      encoded.lone_streams.push_back(
          {std::move(*bytes), std::move(stored.decoded), std::move(stored.source_point)});
      continue;
    }
    encoded.container = std::move(*bytes);
    encoded.head_bytes = stored.head_bytes;
    encoded.decoded = std::move(stored.decoded);
    encoded.source_point = std::move(stored.source_point);
    const Expected<PatchContainer> opened = open_container(encoded.container);
    if (!opened || opened->entries != encoded.entries)
      return runtime_failure("verification: " + (opened ? "another directory" : opened.status().to_string()));
  }
  return encoded;
}

// What the streams take condensed, or as they are if that is less.
uint64_t condensed_bytes(const EncodedMesh& encoded, const ThreadPool& pool) {
  const auto fewest = [&](const PatchContainer& opened, uint64_t plain) {
    const auto condensed = condense_container(opened, plain, /*smallest=*/true, pool);
    return condensed ? uint64_t{condensed->bytes.size()} : plain;
  };
  if (encoded.lone_streams.empty()) {
    const Expected<PatchContainer> opened = open_container(encoded.container);
    return opened ? fewest(*opened, encoded.container.size()) : encoded.container.size();
  }
  const LoneStream& lone = encoded.lone_streams[0];
  PatchContainer stream = open_stream(lone.bytes, lone.decoded.point_count);
  if (!stream.refusal.ok()) return lone.bytes.size();
  stream.expect_points(lone.decoded.point_count);
  return fewest(stream, lone.bytes.size());
}

}  // namespace

Expected<EncodedMesh> encode_mesh(const Mesh& input, Span<const AttributeCoding> codings,
                                  const EncodeOptions& options, const ThreadPool& pool,
                                  Span<const std::byte> extra_point_data, size_t extra_stride) {
  const auto encode = [&](const EncodeOptions& chosen) {
    return encode_one_way(input, codings, chosen, pool, extra_point_data, extra_stride);
  };
  if (!options.choose_by_bytes || !options.condense_smallest || options.alone == Alone::kAll)
    return encode(options);
  EncodeOptions way = options;
  way.free_input = {};
  Expected<EncodedMesh> by_bytes = encode(way);
  if (!by_bytes) return by_bytes;
  way.free_input = options.free_input;
  way.in_creation_order = true;
  way.patch_encoded = {};
  Expected<EncodedMesh> created = encode(way);
  if (!created) return created;
  const Stopwatch condense_time;
  const auto bytes_of = [&](const EncodedMesh& encoded) {
    return options.condense ? encoded.container.size() : condensed_bytes(encoded, pool);
  };
  // Stock Draco that becomes a container changes the JSON. If that does not pay, it stays as it is.
  constexpr uint64_t kMostJsonBytes = 256;
  const bool is_stock = !by_bytes->lone_streams.empty();
  const uint64_t bytes = bytes_of(*created);
  const bool is_smaller = bytes < bytes_of(*by_bytes) &&
                          (!is_stock || bytes + kMostJsonBytes < by_bytes->lone_streams[0].bytes.size());
  EncodeStatistics &first = by_bytes->statistics, &second = created->statistics;
  const double encode_ms = first.encode_ms + second.encode_ms + condense_time.ms(),
               verify_ms = first.verify_ms + second.verify_ms;
  Expected<EncodedMesh>& best = is_smaller ? created : by_bytes;
  best->statistics.encode_ms = encode_ms;
  best->statistics.verify_ms = verify_ms;
  return std::move(best);
}

}  // namespace psplit
