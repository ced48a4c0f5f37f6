#include "encoder/encode_mesh.h"

#include <utility>

#include "encoder/coding/grid_places.h"
#include "encoder/condensing/condense.h"
#include "encoder/encode_parts.h"
#include "encoder/encode_patch.h"
#include "encoder/encode_streams.h"
#include "encoder/spill.h"
#include "encoder/verify.h"
#include "encoder/welding/reduce.h"
#include "encoder/welding/weld.h"
#include "src/container/patch_container.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

Expected<EncodedMesh> encode_one_way(const Mesh& input, Span<const AttributeCoding> codings,
                                     const StreamOptions& options, const ThreadPool& pool,
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
  Expected<EncodedMesh> encoded = encode_whole(mesh, codings, options, pool);
  if (!encoded) return encoded;
  EncodeStatistics& statistics = encoded->statistics;
  statistics.merged_points = reduced.merged_points;
  statistics.dropped_faces = reduced.dropped_faces;
  statistics.dropped_points = reduced.dropped_points;
  statistics.encode_ms += reduce_ms;
  if (is_as_it_was) return encoded;
  for (EncodedPiece& piece : encoded->pieces)
    for (uint32_t& point : piece.source_point) point = reduced.source_point[point];
  return encoded;
}

// What the streams take condensed, or as they are if that is less.
uint64_t condensed_bytes(const EncodedMesh& encoded, const ThreadPool& pool) {
  const EncodedPiece& piece = encoded.pieces[0];
  const uint64_t plain = piece.bytes.size();
  const Expected<PatchContainer> opened = open_piece(piece);
  if (!opened) return plain;
  const auto condensed = condense_container(*opened, plain, /*smallest=*/true, pool);
  return condensed ? uint64_t{condensed->bytes.size()} : plain;
}

}  // namespace

Expected<EncodedMesh> encode_in_order(const Mesh& mesh, Span<const AttributeCoding> codings,
                                      const StreamOptions& options, const ThreadPool& pool) {
  if (Status invalid = check_mesh(mesh, codings); !invalid.ok()) return invalid;
  if (mesh.faces.empty()) return invalid_input("the mesh has no triangles");
  EncodedMesh encoded;
  const Stopwatch encode_time;
  const WeldedMesh welded = weld(mesh, pool);
  PatchMesh whole = whole_mesh(mesh);
  Expected<std::vector<uint8_t>> bytes = encode_in_order(welded, whole, codings, options);
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
  EncodedPiece& piece = encoded.pieces.emplace_back();
  piece.is_container = false;
  piece.bytes = std::move(*bytes);
  piece.point_count = piece.used_point_count = decoded->point_count;
  piece.face_count = static_cast<uint32_t>(decoded->faces.size());
  piece.entries = {{static_cast<uint32_t>(piece.bytes.size()), piece.face_count, piece.point_count, 0, 0}};
  piece.decoded = std::move(*decoded);
  piece.source_point = std::move(whole.points);
  return encoded;
}

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
  const auto encode = [&](const StreamOptions& chosen) {
    return encode_one_way(input, codings, chosen, pool, extra_point_data, extra_stride);
  };
  if (!options.choose_by_bytes || !options.condense_smallest || options.alone == Alone::kAll)
    return encode(options);
  StreamOptions way = options;
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
    return options.condense ? uint64_t{encoded.pieces[0].bytes.size()} : condensed_bytes(encoded, pool);
  };
  // Stock Draco that becomes a container changes the JSON. If that does not pay, it stays as it is.
  constexpr uint64_t kMostJsonBytes = 256;
  const bool is_stock = !by_bytes->is_in_container();
  const uint64_t bytes = bytes_of(*created);
  const bool is_smaller =
      bytes < bytes_of(*by_bytes) && (!is_stock || bytes + kMostJsonBytes < by_bytes->pieces[0].bytes.size());
  EncodeStatistics &first = by_bytes->statistics, &second = created->statistics;
  const double encode_ms = first.encode_ms + second.encode_ms + condense_time.ms(),
               verify_ms = first.verify_ms + second.verify_ms;
  Expected<EncodedMesh>& best = is_smaller ? created : by_bytes;
  best->statistics.encode_ms = encode_ms;
  best->statistics.verify_ms = verify_ms;
  return std::move(best);
}

}  // namespace psplit
