#include "gltf_ext/convert/encode_job.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "encoder/coding/grid_places.h"

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

}  // namespace

void EncodeJob::free_mesh() {
  freed_faces += std::exchange(mesh.faces, {}).size();
  for (Attribute& attribute : mesh.attributes)
    attribute.values = Array<std::byte>();  // {} would keep the memory
}

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
  report.warnings.insert(report.warnings.end(), warnings.begin(), warnings.end());
  report_precision(report);
}

void EncodeJob::report_precision(PrimitiveReport& report) const {
  for (const PrecisionNote& note : precision)
    if (!report.repeated) (note.is_warning ? report.warnings : report.notes).push_back(note.text);
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

std::vector<uint32_t> patch_counts(std::span<const uint64_t> faces, const EncodeDocumentOptions& options) {
  PatchTarget target = options.patches;
  target.most = options.most_patches();
  return patch_counts(faces, target);
}

std::vector<uint32_t> patch_counts(std::span<const EncodeJob> jobs, const EncodeDocumentOptions& options) {
  std::vector<uint64_t> faces;
  for (const EncodeJob& job : jobs) faces.push_back(job.face_count());
  return patch_counts(faces, options);
}

}  // namespace psplit
