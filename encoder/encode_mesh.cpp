#include "encoder/encode_mesh.h"

#include <optional>
#include <utility>

#include "encoder/coding/grid_places.h"
#include "encoder/condensing/condense.h"
#include "encoder/encode_parts.h"
#include "encoder/encode_streams.h"
#include "encoder/spill.h"
#include "encoder/stream/cloud_stream.h"
#include "encoder/stream/encode_stream.h"
#include "encoder/verify.h"
#include "encoder/welding/reduce.h"
#include "encoder/welding/weld.h"
#include "src/container/patch_container.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

// What the streams take condensed, or as they are if that is less.
uint64_t condensed_bytes(const EncodedMesh& encoded, const ThreadPool& pool) {
  const EncodedPiece& piece = encoded.pieces[0];
  const uint64_t plain = piece.bytes.size();
  const Expected<PatchContainer> opened = open_piece(piece);
  if (!opened) return plain;
  const auto condensed = condense_container(*opened, plain, /*smallest=*/true, pool);
  return condensed ? uint64_t{condensed->bytes.size()} : plain;
}

// Whether the mesh whose POSITION is predicted in order of creation takes fewer bytes than the other, both
// condensed.
bool is_worth_order_of_creation(const EncodedMesh& created, const EncodedMesh& by_bytes,
                                const StreamOptions& options, const ThreadPool& pool) {
  const auto bytes_of = [&](const EncodedMesh& encoded) {
    return options.condense ? uint64_t{encoded.pieces[0].bytes.size()} : condensed_bytes(encoded, pool);
  };
  // Stock Draco that becomes a container changes the JSON. If that does not pay, it stays as it is.
  constexpr uint64_t kMostJsonBytes = 256;
  const bool is_stock = !by_bytes.is_in_container();
  const uint64_t bytes = bytes_of(created);
  return bytes < bytes_of(by_bytes) && (!is_stock || bytes + kMostJsonBytes < by_bytes.pieces[0].bytes.size());
}

EncodedPiece lone_stream(std::vector<uint8_t> bytes, Mesh decoded, std::vector<uint32_t> source_point) {
  EncodedPiece piece;
  piece.is_container = false;
  piece.bytes = std::move(bytes);
  piece.point_count = piece.used_point_count = decoded.point_count;
  piece.face_count = static_cast<uint32_t>(decoded.faces.size());
  piece.entries = {{static_cast<uint32_t>(piece.bytes.size()), piece.face_count, piece.point_count, 0, 0}};
  piece.decoded = std::move(decoded);
  piece.source_point = std::move(source_point);
  return piece;
}

// The mesh as one sequential stream, which keeps all faces and points, and their order.
Expected<EncodedMesh> encode_in_order(const Mesh& mesh, Span<const AttributeCoding> codings,
                                      const StreamOptions& options, const ThreadPool& pool) {
  EncodedMesh encoded;
  const Stopwatch encode_time;
  const WeldedMesh welded = weld(mesh, pool);
  PatchMesh whole = whole_mesh(mesh);
  Expected<std::vector<uint8_t>> bytes = encode_sequentially(welded, whole, codings, options);
  if (!bytes) return bytes.status();
  encoded.statistics.encode_ms = encode_time.ms();
  encoded.requests = stream_requests(mesh);
  const Stopwatch verify_time;
  Expected<Mesh> decoded = decode_stream(mesh, *bytes);
  if (!decoded) return decoded.status();
  Status status = options.verify ? verify_mesh(mesh, codings, *decoded, whole.points, 0, false, pool,
                                               encoded.statistics.position_error)
                                 : Status();
  if (!status.ok()) return status;
  encoded.statistics.verify_ms = verify_time.ms();
  encoded.pieces.push_back(lone_stream(std::move(*bytes), std::move(*decoded), std::move(whole.points)));
  return encoded;
}

Expected<EncodedMesh> encode_whole_cloud(const Mesh& cloud, Span<const AttributeCoding> codings,
                                         const StreamOptions& options, const ThreadPool& pool) {
  if (!cloud.faces.empty()) return invalid_input("a point cloud has no faces");
  if (options.by_libdraco) return unsupported("libdraco is a reference for meshes, not for point clouds");
  EncodedMesh encoded;
  const Stopwatch encode_time;
  if (options.stopped()) return cancelled();
  const bool is_tree = becomes_tree(cloud, codings, options.encode_speed);
  Expected<EncodedCloud> stream = encode_cloud(cloud, codings, is_tree, options.encode_speed);
  if (!stream) return stream.status();
  if (options.stopped()) return cancelled();
  encoded.statistics.encode_ms = encode_time.ms();
  encoded.requests = stream_requests(cloud);
  const Stopwatch verify_time;
  Expected<Mesh> decoded = decode_cloud(cloud, stream->bytes);
  if (!decoded) return decoded.status();
  if (options.verify)
    if (Status status = verify_mesh(cloud, codings, *decoded, stream->source_point, 0, false, pool,
                                    encoded.statistics.position_error);
        !status.ok())
      return status;
  encoded.statistics.verify_ms = verify_time.ms();
  encoded.pieces.push_back(
      lone_stream(std::move(stream->bytes), std::move(*decoded), std::move(stream->source_point)));
  return encoded;
}

}  // namespace

uint64_t EncodedPiece::size() const { return stored != nullptr ? stored->size() : bytes.size(); }

Expected<PatchContainer> open_piece(const EncodedPiece& piece) {
  if (piece.is_container) return open_container(piece.bytes);
  PatchContainer stream = open_stream(piece.bytes, piece.point_count);
  if (!stream.refusal.ok()) return stream.refusal;
  stream.expect_points(piece.point_count);
  return stream;
}

Expected<EncodedMesh> encode_mesh(const Mesh& input, Span<const AttributeCoding> codings,
                                  const StreamOptions& options, const ThreadPool& pool,
                                  Span<const std::byte> extra_point_data, size_t extra_stride) {
  if (Status invalid = check_mesh(input, codings); !invalid.ok()) return invalid;
  if (options.is_cloud) return encode_whole_cloud(input, codings, options, pool);
  if (input.faces.empty()) return invalid_input("the mesh has no triangles");
  if (options.in_order) return encode_in_order(input, codings, options, pool);
  if (extra_point_data.size() != extra_stride * input.point_count)
    return invalid_input("extra data of the wrong size");
  const Stopwatch reduce_time;
  ReducedMesh reduced = reduce(
      input,
      {options.keep_duplicates, options.drop_degenerate, options.drop_unused, places_on_grids(input, codings),
       /*leaves_unchanged=*/true},
      pool, extra_point_data, extra_stride);
  // Often nothing is merged or dropped. Then there is one mesh in memory, not two.
  const bool is_as_it_was = reduced.is_unchanged();
  if (!is_as_it_was && options.free_input) options.free_input();
  const Mesh& mesh = is_as_it_was ? input : reduced.mesh;
  if (mesh.faces.empty()) return unsupported("no triangles but degenerate ones");
  if (!options.patch_of_face.empty() && options.patch_of_face.size() != mesh.faces.size())
    return wrong_usage("a partition of another number of faces");
  double encode_ms = reduce_time.ms(), verify_ms = 0;

  // For the fewest bytes both kinds of predictions are tried.
  const bool tries_both = options.choose_by_bytes && options.condense_smallest && options.alone != Alone::kAll;
  StreamOptions way = options;
  way.differ_in_positions = reduced.differ_in_positions;
  std::optional<EncodedMesh> best;
  for (const bool in_creation_order : {false, true}) {
    if (in_creation_order && !tries_both) break;
    way.in_creation_order |= in_creation_order;
    const Stopwatch streams_time;
    Expected<Streams> streams = encode_streams(mesh, codings, way, options.patch_count, pool);
    if (!streams) return streams.status();
    encode_ms += streams_time.ms();
    Expected<EncodedMesh> stored = store_whole(mesh, codings, way, std::move(*streams), pool);
    if (!stored) return stored;
    encode_ms += stored->statistics.encode_ms;
    verify_ms += stored->statistics.verify_ms;
    way.patch_encoded = {};  // the faces have been counted
    const Stopwatch condense_time;
    if (!best || is_worth_order_of_creation(*stored, *best, options, pool)) best = std::move(*stored);
    encode_ms += condense_time.ms();
  }
  best->statistics.encode_ms = encode_ms;
  best->statistics.verify_ms = verify_ms;
  if (is_as_it_was) return std::move(*best);
  best->statistics.merged_points = reduced.merged_points;
  best->statistics.dropped_faces = reduced.dropped_faces;
  best->statistics.dropped_points = reduced.dropped_points;
  for (EncodedPiece& piece : best->pieces)
    for (uint32_t& point : piece.source_point) point = reduced.source_point[point];
  return std::move(*best);
}

}  // namespace psplit
