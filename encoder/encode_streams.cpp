#include "encoder/encode_streams.h"

#include <algorithm>
#include <bit>
#include <memory>
#include <numeric>
#include <utility>

#include "encoder/coding/quantization.h"
#include "encoder/libdraco/patch_stream.h"
#include "encoder/stream/encode_stream.h"
#include "encoder/stream/sequential_stream.h"
#include "encoder/stream/smallest_stream.h"
#include "encoder/stream/stream_steps.h"
#include "encoder/verify.h"
#include "src/object_pool.h"
#include "src/shared_values.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

// For each face of the mesh 1 if it is one of `faces`. Empty if there are none.
std::vector<uint8_t> faces_flags(const Mesh& mesh, std::span<const uint32_t> faces) {
  std::vector<uint8_t> flags(faces.empty() ? 0 : mesh.faces.size(), 0);
  for (const uint32_t face : faces) flags[face] = 1;
  return flags;
}

// Cuts the mesh, and encodes the patches and the residue.
Expected<Streams> encode_patches(const WeldedMesh& welded, std::span<const AttributeCoding> codings,
                                 const StreamOptions& options, uint32_t wanted_patches,
                                 const ThreadPool& pool) {
  const Mesh& mesh = *welded.mesh;
  Streams streams;
  const Stopwatch partition_time;
  Cut cut = cut_faces(welded, {wanted_patches, options.refine, options.method, options.distance},
                      options.patch_of_face, pool);
  order_patches(mesh, options.order, cut);
  streams.partition_ms = partition_time.ms();
  const size_t patch_count = cut.patches.size();
  std::vector<uint8_t> is_in_patch(mesh.point_count, 0);
  const std::vector<uint8_t> is_in_residue = faces_flags(mesh, cut.residue_faces);
  constexpr size_t kFacesAtOnce = 1 << 14;
  pool.for_ranges(mesh.faces.size(), kFacesAtOnce, [&](size_t begin, size_t end) {
    for (size_t face = begin; face < end; ++face)
      if (is_in_residue.empty() || is_in_residue[face] == 0)
        for (const uint32_t point : mesh.faces[face]) store_shared(is_in_patch[point], uint8_t{1});
  });
  const bool has_residue = !cut.residue_faces.empty() || std::ranges::find(is_in_patch, 0) != is_in_patch.end();
  // Streams that are alone are verified one by one, by their decoded values.
  const bool standalone = are_alone(options.alone, patch_count, has_residue);

  streams.owned.resize(patch_count);
  streams.decoded.resize(patch_count);
  streams.bytes.resize(patch_count);
  streams.table_bytes.resize(patch_count);
  std::vector<Status> statuses(patch_count);
  ObjectPool<PatchExtractor> extractors;
  const auto make_extractor = [&] { return std::make_unique<PatchExtractor>(mesh); };
  pool.for_each(patch_count, [&](size_t i) {
    if (options.stopped()) {
      statuses[i] = cancelled();
      return;
    }
    const PatchMesh patch =
        ObjectPool<PatchExtractor>::Lease(extractors, make_extractor)->extract(cut.patches[i], cut.neighbours);
    Expected<EncodedPatch> encoded =
        options.by_libdraco ? encode_edgebreaker(welded, patch, codings, options.encode_speed, standalone)
        : options.choose_by_bytes
            ? encode_smallest_stream(welded, patch, codings, standalone, options.in_creation_order)
            : encode_stream(welded, patch, codings, options.encode_speed, standalone);
    if (!encoded) {
      statuses[i] = encoded.status().at({.patch = static_cast<int64_t>(i)});
      return;
    }
    streams.bytes[i] = std::move(encoded->bytes);
    // libdraco does not say what its tables take.
    streams.table_bytes[i] = options.by_libdraco && options.most_split_percent > 0
                                 ? table_bytes_of(streams.bytes[i])
                                 : encoded->table_bytes;
    streams.decoded[i] = std::move(encoded->decoded);
    OwnedStream& owned = streams.owned[i] = {std::move(encoded->patch_point), std::move(encoded->walk)};
    for (uint32_t& point : owned.points) point = patch.points[point];
    if (options.patch_encoded) options.patch_encoded(cut.patches[i].size());
  });
  for (Status& status : statuses)
    if (!status.ok()) return std::move(status);
  cut.neighbours = {};  // the space is freed early
  Status status = append_residue(welded, cut.residue_faces, is_in_patch, codings, options, standalone, streams);
  if (!status.ok()) return status;
  return streams;
}

// Patches take more bytes than one stream: points at borders are in several, each stream has tables of its own,
// and a container needs a stitch map. Of most meshes that is 1 or 2 %, and the patches alone tell it. Of
// others, such as thousands of boxes that touch, it is more than all the rest.
struct SplitBytes {
  uint64_t streams = 0, tables = 0, largest_tables = 0;
  uint64_t points = 0;

  explicit SplitBytes(const Streams& of) {
    for (const std::vector<uint8_t>& bytes : of.bytes) streams += bytes.size();
    for (const size_t bytes : of.table_bytes) {
      tables += bytes;
      largest_tables = std::max<uint64_t>(largest_tables, bytes);
    }
    for (const OwnedStream& stream : of.owned) points += stream.points.size();
  }

  // Tables that one stream would not have. Its own may be larger than the largest here.
  uint64_t repeated_tables() const { return tables - largest_tables; }
};

// The bytes of an entry of the directory.
constexpr uint64_t kEntryBytes = 8;

uint64_t stitch_map_bytes(const Mesh& mesh, const Streams& streams, const ThreadPool& pool) {
  std::vector<PointOwner> owners(mesh.point_count);
  const Stitching stitching = build_stitching(streams.owned, 0, owners, pool);
  return std::accumulate(stitching.maps.begin(), stitching.maps.end(), uint64_t{0},
                         [](uint64_t sum, const std::vector<uint8_t>& map) { return sum + map.size(); });
}

// Whether nearly all points have six faces, as in grids and in surfaces that were made by rule. One stream
// follows the rows of such a mesh, and patches do not: that may cost a tenth, which no border shows. In scanned
// or sculpted meshes, about a third of the points have six faces; in carefully remeshed ones, three quarters.
bool has_rows(const Mesh& mesh) {
  constexpr double kShare = 0.9;
  std::vector<uint8_t> faces_of(mesh.point_count, 0);
  for (const auto& face : mesh.faces)
    for (const uint32_t point : face)
      if (faces_of[point] < 7) ++faces_of[point];
  const auto with_six = std::ranges::count(faces_of, uint8_t{6});
  return static_cast<double>(with_six) > kShare * static_cast<double>(mesh.point_count);
}

// Whether the streams may take over options.most_split_percent more than one stream. This finds all such meshes
// of the corpus. The smallest coding is less even: the size of its one stream is known only once it is encoded.
bool may_exceed_limit(const Mesh& mesh, const Streams& streams, const StreamOptions& options,
                      const ThreadPool& pool) {
  // Bytes of a reference that is stored alone; one that belongs to a run takes a tenth of a byte.
  constexpr double kReferenceBytes = 1.2;
  if (options.choose_by_bytes) return true;
  // The bound is not exact: predictions at borders are worse, too, and one stream may have larger tables. Of
  // many patches these even out, and tables of their own fit them better.
  constexpr size_t kMany = 8;
  const double certain = (streams.bytes.size() < kMany ? 0.85 : 0.93) * options.most_split_percent / 100;
  const SplitBytes bytes(streams);
  const auto references =
      static_cast<double>(bytes.points - std::min<uint64_t>(bytes.points, mesh.point_count));
  const auto values = static_cast<double>(bytes.streams - std::min(bytes.streams, bytes.tables));
  double more = values * references / static_cast<double>(std::max<uint64_t>(1, bytes.points));
  if (!options.shares_tables) more += static_cast<double>(bytes.repeated_tables());
  const auto exceeds = [&](double all) { return all > certain * (static_cast<double>(bytes.streams) - all); };
  if (has_rows(mesh)) return true;
  if (streams.are_alone(options.alone)) return exceeds(more);
  more += static_cast<double>(kEntryBytes * streams.bytes.size());
  if (!exceeds(more + kReferenceBytes * references)) return false;
  // The bound counts each reference as if it was stored alone, and most belong to runs. In few patches, or
  // where tables are shared, the excess stands for worse predictions at borders, which nothing else here
  // counts. Many patches make up for these by tables that fit each, so the true maps decide. To make them takes
  // a hundredth of the time of one stream.
  constexpr size_t kLeastToMakeMaps = 64;
  return options.shares_tables || streams.bytes.size() < kLeastToMakeMaps ||
         exceeds(more + static_cast<double>(stitch_map_bytes(mesh, streams, pool)));
}

// The bytes of the streams as they are stored, less the tables that will be shared.
uint64_t stored_bytes(const Mesh& mesh, const Streams& streams, const StreamOptions& options,
                      const ThreadPool& pool) {
  const SplitBytes bytes(streams);
  const uint64_t values = bytes.streams - (options.shares_tables ? bytes.repeated_tables() : 0);
  if (streams.are_alone(options.alone)) return values;
  return values + kEntryBytes * streams.bytes.size() + stitch_map_bytes(mesh, streams, pool);
}

// The decoded streams, one after the other, with the mesh's point for each of their points.
std::pair<Mesh, std::vector<uint32_t>> concatenate(const Streams& streams) {
  std::pair<Mesh, std::vector<uint32_t>> all;
  auto& [mesh, source_point] = all;
  for (const Attribute& attribute : streams.decoded[0].attributes)
    mesh.attributes.push_back(
        {attribute.semantic, attribute.component_type, attribute.component_count, attribute.normalized, {}});
  for (size_t k = 0; k < streams.decoded.size(); ++k) {
    const Mesh& decoded = streams.decoded[k];
    for (const auto& [a, b, c] : decoded.faces)
      mesh.faces.push_back({mesh.point_count + a, mesh.point_count + b, mesh.point_count + c});
    mesh.point_count += decoded.point_count;
    for (size_t i = 0; i < mesh.attributes.size(); ++i) {
      const Array<std::byte>& values = decoded.attributes[i].values;
      mesh.attributes[i].values.insert(mesh.attributes[i].values.end(), values.begin(), values.end());
    }
    const std::vector<uint32_t>& points = streams.owned[k].points;
    source_point.insert(source_point.end(), points.begin(), points.end());
  }
  return all;
}

}  // namespace

Status check_mesh(const Mesh& mesh, std::span<const AttributeCoding> codings) {
  if (mesh.find("POSITION") == nullptr) return invalid_input("the mesh has no POSITION");
  if (codings.size() != mesh.attributes.size()) return invalid_input("one coding is needed per attribute");
  if (mesh.faces.size() > kMostFacesToCut) return unsupported("more faces than a container can hold");
  for (size_t i = 0; i < codings.size(); ++i) {
    const Attribute& attribute = mesh.attributes[i];
    const AttributeCoding& coding = codings[i];
    const bool is_float = attribute.component_type == ComponentType::kFloat32;
    if (attribute.component_count < 1 || attribute.component_count > 16)
      return unsupported(attribute.semantic + " has " + std::to_string(attribute.component_count) +
                         " components");
    if (attribute.values.size() != attribute.stride() * mesh.point_count)
      return invalid_input(attribute.semantic + " has values for another number of points");
    // glTF allows no vertex attribute of 32-bit integers, and libdraco's encoder, the reference, takes memory
    // by the largest value.
    if (attribute.component_type == ComponentType::kUint32 && !mesh.faces.empty())
      return unsupported(attribute.semantic + " holds 32-bit integers");
    if (coding.bits == 0) continue;
    if (!is_float || coding.bits < (coding.octahedral ? 2 : 1) || coding.bits > kMostGridBits)
      return invalid_input(attribute.semantic + " cannot be quantized to " + std::to_string(coding.bits) +
                           " bits");
    if (coding.octahedral ? attribute.component_count != 3 : coding.origin.size() != attribute.component_count)
      return invalid_input(attribute.semantic + " has no grid of its number of components");
    if (!coding.octahedral && !grid_extremes(coding))
      return invalid_input(attribute.semantic + ": no floats are exactly its grid's range apart; see fit_grid");
  }
  uint32_t largest = 0;
  for (const auto& [a, b, c] : mesh.faces) largest = std::max({largest, a, b, c});
  if (largest < mesh.point_count || mesh.faces.empty()) return {};
  for (const auto& face : mesh.faces)
    for (uint32_t point : face)
      if (point >= mesh.point_count)
        return invalid_input("an index is " + std::to_string(point) + ", but there are " +
                             std::to_string(mesh.point_count) + " points");
  return {};
}

Expected<Streams> encode_streams(const Mesh& mesh, std::span<const AttributeCoding> codings,
                                 const StreamOptions& options, uint32_t patch_count, const ThreadPool& pool) {
  WeldedMesh welded = weld(mesh, pool, options.differ_in_positions);
  separate_flat_faces(welded);
  Expected<Streams> streams = encode_patches(welded, codings, options, patch_count, pool);
  const bool is_limited = options.most_split_percent > 0 && options.patch_of_face.empty();
  if (!streams || !is_limited || streams->patch_count() <= 1 ||
      !may_exceed_limit(mesh, *streams, options, pool))
    return streams;
  StreamOptions quiet = options;
  quiet.patch_encoded = {};  // the faces have been counted
  Expected<Streams> one = encode_patches(welded, codings, quiet, 1, pool);
  if (!one) return one;
  const uint64_t one_bytes = stored_bytes(mesh, *one, options, pool);
  const uint64_t most_bytes = one_bytes + one_bytes * options.most_split_percent / 100;
  double partition_ms = streams->partition_ms + one->partition_ms;
  uint64_t bytes = stored_bytes(mesh, *streams, options, pool);
  // The cost of a cut is about the same for each.
  constexpr int kAttempts = 2;
  for (int attempts = 0; bytes > most_bytes; ++attempts) {
    const uint64_t cuts = (most_bytes - one_bytes) * (streams->patch_count() - 1) / (bytes - one_bytes);
    const uint32_t fewer = std::bit_floor(static_cast<uint32_t>(cuts) + 1);
    *streams = Streams();
    if (attempts == kAttempts || fewer <= 1) {
      streams = std::move(one);
      break;
    }
    streams = encode_patches(welded, codings, quiet, fewer, pool);
    if (!streams) return streams;
    partition_ms += streams->partition_ms;
    bytes = stored_bytes(mesh, *streams, options, pool);
  }
  streams->partition_ms = partition_ms;
  return streams;
}

Status append_residue(const WeldedMesh& welded, std::span<const uint32_t> residue_faces,
                      std::span<const uint8_t> is_in_patch, std::span<const AttributeCoding> codings,
                      const StreamOptions& options, bool standalone, Streams& streams) {
  Residue residue = extract_residue(*welded.mesh, residue_faces, is_in_patch, standalone);
  streams.residue_face_count = residue.face_count;
  streams.residue_point_count = residue.owned_count;
  if (residue.patch.points.empty()) return {};
  Expected<std::vector<uint8_t>> bytes = encode_sequentially(welded, residue.patch, codings, options);
  if (!bytes) return bytes.status();
  Mesh& decoded = streams.decoded.emplace_back();
  if (standalone) {
    Expected<Mesh> mesh = decode_stream(*welded.mesh, *bytes);
    if (!mesh) return mesh.status();
    decoded = std::move(*mesh);
  } else {
    decoded.faces.assign(residue.patch.faces.begin(), residue.patch.faces.end());
  }
  decoded.faces.resize(residue.face_count);
  streams.has_residue = true;
  streams.bytes.push_back(std::move(*bytes));
  streams.owned.push_back({std::move(residue.patch.points), {}});
  return {};
}

Expected<std::vector<uint8_t>> encode_sequentially(const WeldedMesh& welded, const PatchMesh& patch,
                                                   std::span<const AttributeCoding> codings,
                                                   const StreamOptions& options) {
  if (options.by_libdraco) return encode_sequential(welded, patch, codings, options.encode_speed);
  return write_sequential_stream({welded, codings, patch.points_of_values()}, patch.faces,
                                 options.encode_speed);
}

Expected<std::vector<StreamEntry>> make_entries(const Streams& streams, const Stitching& stitching) {
  std::vector<StreamEntry> entries;
  for (size_t i = 0; i < streams.owned.size(); ++i) {
    if (streams.bytes[i].size() > 0xffffffffu) return unsupported("a patch takes more than 4 GB");
    entries.push_back({static_cast<uint32_t>(streams.bytes[i].size()),
                       static_cast<uint32_t>(streams.decoded[i].faces.size()),
                       static_cast<uint32_t>(streams.owned[i].points.size()), stitching.reference_counts[i],
                       static_cast<uint32_t>(stitching.maps[i].size())});
  }
  return entries;
}

Expected<std::vector<StreamEntry>> make_lone_entries(const Streams& streams, std::vector<uint8_t> is_known) {
  Stitching none;
  none.maps.resize(streams.owned.size());
  for (const OwnedStream& stream : streams.owned) {
    uint32_t& references = none.reference_counts.emplace_back(0);
    for (const uint32_t point : stream.points) references += std::exchange(is_known[point], uint8_t{1});
  }
  return make_entries(streams, none);
}

Status verify_alone(const Mesh& mesh, std::span<const AttributeCoding> codings, const Streams& streams,
                    const ThreadPool& pool, std::optional<double>& position_error) {
  if (streams.decoded.size() == 1)
    return verify_mesh(mesh, codings, streams.decoded[0], streams.owned[0].points, 0, true, pool,
                       position_error);
  const auto [decoded, source_point] = concatenate(streams);
  return verify_mesh(mesh, codings, decoded, source_point, 0, true, pool, position_error);
}

}  // namespace psplit
