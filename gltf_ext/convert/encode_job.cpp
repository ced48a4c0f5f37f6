#include "gltf_ext/convert/encode_job.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>

#include "encoder/coding/grid_places.h"
#include "encoder/coding/position_bits.h"
#include "encoder/condensing/condense.h"
#include "src/container/patch_container.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

// Data that keeps points apart whose attributes are equal: morph targets, and weights before rounding. Returns
// `stride` bytes for each point.
std::vector<std::byte> distinguishing_bytes(const EncodeJob& job, size_t& stride) {
  std::vector<std::pair<const Array<std::byte>*, size_t>> sources;
  for (const MorphAttribute& morph : job.morphs)
    sources.emplace_back(&morph.data.values, morph.data.values.size() / std::max(1u, morph.data.count));
  for (const Attribute& attribute : job.unrounded) sources.emplace_back(&attribute.values, attribute.stride());
  stride = 0;
  for (const auto& [values, width] : sources) stride += width;
  std::vector<std::byte> bytes(stride * job.mesh.point_count);
  size_t offset = 0;
  for (const auto& [values, width] : sources) {
    for (size_t i = 0; i < job.mesh.point_count; ++i)
      std::memcpy(bytes.data() + i * stride + offset, values->data() + i * width, width);
    offset += width;
  }
  return bytes;
}

ReduceOptions reduce_options(const EncodeJob& job) {
  return {job.options.keep_duplicates, job.options.drop_degenerate, job.options.drop_unused};
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

void EncodeJob::note_storage() {
  const bool is_alone = parts ? options.alone == Alone::kAll : !encoded.lone_streams.empty();
  stored_as = !is_alone            ? StoredAs::kPatches
              : piece_count() == 1 ? StoredAs::kDraco
                                   : StoredAs::kPatchPrimitives;
  stored_bytes = encoded.container.size();
  for (const LoneStream& stream : encoded.lone_streams) stored_bytes += stream.bytes.size();
  if (!parts) return;
  for (const PartsContainer& container : parts->containers) stored_bytes += container.bytes->size();
}

void EncodeJob::report(PrimitiveReport& report) {
  report.stored_as = stored_as;
  report.bytes = stored_bytes;
  report.streams = encoded.entries;
  report.has_residue = encoded.statistics.patch_count < encoded.entries.size();
  report.head_bytes = encoded.head_bytes;
  if (const AttributeCoding* coding = position_coding(); coding != nullptr) report.position_coding = *coding;
  report.statistics = encoded.statistics;
}

Expected<int> chosen_position_bits(const AttributeCoding& coding, const EncodeDocumentOptions& options,
                                   double step) {
  return options.position_bits_by_edges ? position_bits_for_step(coding, step)
                                        : position_bits_for_error(coding, options.max_position_error);
}

EncodeOptions options_of_streams(const EncodeDocumentOptions& options) {
  EncodeOptions result;
  result.refine = options.refine;
  result.method = options.method;
  result.distance = options.distance;
  result.order = options.order;
  result.boxes = options.boxes;
  result.encode_speed = options.encode_speed;
  result.choose_by_bytes = options.choose_by_bytes;
  result.by_libdraco = options.by_libdraco;
  result.keep_duplicates = options.keep_duplicates;
  result.drop_degenerate = !options.keep_degenerate;
  // A patch of its own cannot store unused points.
  result.drop_unused = !options.keep_unused || options.compat == Compat::kKhr;
  result.alone = options.compat == Compat::kKhr                                    ? Alone::kAll
                 : options.patches.always || options.fallback == Fallback::kCoarse ? Alone::kNone
                                                                                   : Alone::kWhole;
  result.condense_smallest = options.condense_smallest;
  result.verify = options.verify;
  return result;
}

ReducedMesh reduce_job(const EncodeJob& job, const ThreadPool& pool) {
  size_t stride = 0;
  const std::vector<std::byte> extra = distinguishing_bytes(job, stride);
  ReduceOptions options = reduce_options(job);
  options.compared = places_on_grids(job.mesh, job.codings);
  return reduce(job.mesh, options, pool, extra, stride);
}

std::vector<uint8_t> stored_points_of(const EncodeJob& job) {
  size_t stride = 0;
  const std::vector<std::byte> extra = distinguishing_bytes(job, stride);
  return stored_points(job.mesh, reduce_options(job), extra, stride);
}

Expected<EncodedMesh> encode_job(const EncodeJob& job, const EncodeOptions& options, const ThreadPool& pool) {
  size_t stride = 0;
  const std::vector<std::byte> extra = distinguishing_bytes(job, stride);
  return encode_mesh(job.mesh, job.codings, options, pool, extra, stride);
}

Expected<EncodedMesh> encode_job(const EncodeJob& job, const ThreadPool& pool) {
  Expected<EncodedMesh> by_bytes = encode_job(job, job.options, pool);
  const EncodeOptions& chosen = job.options;
  if (!by_bytes || !chosen.choose_by_bytes || !chosen.condense_smallest || chosen.alone == Alone::kAll)
    return by_bytes;
  EncodeOptions options = chosen;
  options.in_creation_order = true;
  options.patch_encoded = {};
  Expected<EncodedMesh> created = encode_job(job, options, pool);
  if (!created) return created;
  const Stopwatch condense_time;
  // Stock Draco that becomes a container changes the JSON. If that does not pay, it stays as it is.
  constexpr uint64_t kMostJsonBytes = 256;
  const bool is_stock = !by_bytes->lone_streams.empty();
  const uint64_t bytes = condensed_bytes(*created, pool);
  const bool is_smaller = bytes < condensed_bytes(*by_bytes, pool) &&
                          (!is_stock || bytes + kMostJsonBytes < by_bytes->lone_streams[0].bytes.size());
  EncodeStatistics &first = by_bytes->statistics, &second = created->statistics;
  const double encode_ms = first.encode_ms + second.encode_ms + condense_time.ms(),
               verify_ms = first.verify_ms + second.verify_ms;
  Expected<EncodedMesh>& best = is_smaller ? created : by_bytes;
  best->statistics.encode_ms = encode_ms;
  best->statistics.verify_ms = verify_ms;
  return std::move(best);
}

std::vector<MorphAttribute> reorder(const std::vector<MorphAttribute>& morphs,
                                    const std::vector<uint32_t>& source_point) {
  std::vector<MorphAttribute> ordered;
  for (const MorphAttribute& morph : morphs) {
    MorphAttribute& copy = ordered.emplace_back(MorphAttribute{morph.target, morph.semantic, {}, morph.sparse});
    copy.data = {morph.data.component_type,
                 morph.data.component_count,
                 morph.data.normalized,
                 static_cast<uint32_t>(source_point.size()),
                 {}};
    const size_t width = component_bytes(morph.data.component_type) * morph.data.component_count;
    copy.data.values.resize(width * source_point.size());
    for (size_t i = 0; i < source_point.size(); ++i)
      std::memcpy(copy.data.values.data() + i * width, morph.data.values.data() + source_point[i] * width,
                  width);
  }
  return ordered;
}

uint64_t default_patch_count(uint64_t faces, uint64_t min_faces) {
  constexpr double kPatchFaces = 30000;
  if (faces < min_faces) return 1;
  const double patches = static_cast<double>(faces) / kPatchFaces;
  if (patches < 24)
    return std::clamp<uint64_t>(std::bit_ceil(static_cast<uint64_t>(patches / std::sqrt(2.0)) + 1), 2, 16);
  return 16 * static_cast<uint64_t>(std::lround(patches / 16));
}

std::vector<uint32_t> patch_counts(std::span<const uint64_t> faces, const EncodeDocumentOptions& options) {
  const PatchTarget& target = options.patches;
  std::vector<uint32_t> distributed;
  if (target.count > 0) {
    const uint64_t total = std::accumulate(faces.begin(), faces.end(), uint64_t{0});
    const uint64_t most = std::max<uint64_t>(1, total / std::max<uint64_t>(1, target.least_faces));
    distributed = distribute_patches(faces, std::min(target.count, most));
  }
  const auto count_of = [&](size_t i) -> uint64_t {
    if (faces[i] < target.min_faces) return 1;
    if (target.count > 0) return distributed[i];
    if (target.faces > 0) return std::max<uint64_t>(1, (faces[i] + target.faces / 2) / target.faces);
    return std::min(options.most_patches(),
                    default_patch_count(faces[i], target.min_faces > 0 ? target.min_faces : kMinFaces));
  };
  std::vector<uint32_t> counts;
  for (size_t i = 0; i < faces.size(); ++i) counts.push_back(static_cast<uint32_t>(count_of(i)));
  return counts;
}

std::vector<uint32_t> patch_counts(std::span<const EncodeJob> jobs, const EncodeDocumentOptions& options) {
  std::vector<uint64_t> faces;
  for (const EncodeJob& job : jobs) faces.push_back(job.face_count());
  return patch_counts(faces, options);
}

}  // namespace psplit
