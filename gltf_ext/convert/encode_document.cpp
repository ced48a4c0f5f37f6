#include "gltf_ext/convert/encode_document.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "gltf_ext/convert/condense_patches.h"
#include "gltf_ext/convert/drop_attributes.h"
#include "gltf_ext/convert/encode_job.h"
#include "gltf_ext/convert/encode_reports.h"
#include "gltf_ext/convert/read_jobs.h"
#include "gltf_ext/convert/replace_streams.h"
#include "gltf_ext/convert/store_job.h"
#include "gltf_ext/convert/validate.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/primitive/geometry_bytes.h"
#include "src/container/patch_container.h"

namespace psplit {
namespace {

void encode_jobs(const Document& document, std::vector<EncodeJob>& jobs, const ThreadPool& pool,
                 const Progress& progress) {
  size_t faces = 0;
  for (const EncodeJob& job : jobs) faces += job.mesh.faces.size();
  std::atomic<size_t> done = 0;
  if (progress) progress(0, faces);
  pool.for_each(jobs.size(), [&](size_t i) {
    EncodeJob& job = jobs[i];
    if (job.parts) return;
    std::atomic<size_t> done_of_job = 0;
    if (job.options.condense && job.options.patch_count == 1 && !job.drops_attributes)
      job.status = condense_stock(document, job);
    if (progress)
      job.options.patch_encoded = [&](size_t count) {
        done_of_job += count;
        progress(done += count, faces);
      };
    if (job.status.ok() && !job.keeps_stream) {
      Expected<EncodedMesh> encoded = encode_job(job, job.options, pool);
      if (encoded.ok())
        job.encoded = std::move(*encoded);
      else
        job.status = encoded.status();
    }
    job.options.patch_encoded = {};
    // Faces that are dropped or in no patch count as done.
    if (progress) progress(done += job.mesh.faces.size() - done_of_job, faces);
  });
}

// The buffer view of the group's stock Draco, if no other primitive has it.
std::optional<int64_t> own_stock_view(const Document& document, const PrimitiveGroup& group) {
  const auto view_of = [&](PrimitiveId id) -> std::optional<int64_t> {
    const std::optional<DracoRecord>& stock = document.records().primitive(id).stock;
    return stock ? std::optional(stock->view) : std::nullopt;
  };
  const std::optional<int64_t> own = view_of(group.ids.front());
  size_t users = 0;
  for (const PrimitiveId id : all_primitives(document)) users += own && view_of(id) == own ? 1 : 0;
  return users == group.ids.size() ? own : std::nullopt;
}

// Stores a container as the primitive's extension, or each of several and each lone stream as a primitive of
// its own.
Status write_geometry(Document& document, std::vector<EncodeJob>& jobs, const EncodeDocumentOptions& options,
                      const OutOfCoreOptions& limits, const ThreadPool& pool,
                      std::span<const int64_t> freed_accessors, const CondensedPatches& condensed,
                      EncodeReports& reports) {
  std::vector<PrimitiveGroup> groups;
  std::vector<size_t> counts;
  StreamReplacements replacements(condensed.begin(), condensed.end());
  for (EncodeJob& job : jobs) {
    groups.push_back(job.group);
    counts.push_back(job.piece_count());
    if (job.keeps_stream) job.stream_view = own_stock_view(document, job.group);
    if (job.stream_view) replacements[*job.stream_view] = job.encoded.container;
  }
  const auto repeated = repeat_primitives(document, groups, counts);
  PrimitiveEditor editor(document);
  for (size_t i = 0; i < jobs.size(); ++i)
    if (Status status = store_job(document, jobs[i], repeated[i], options, limits, pool, editor); !status.ok())
      return status;
  drop_manifolds(document, jobs, editor, reports);
  for (const int64_t accessor : freed_accessors) editor.release(accessor);
  replace_streams(document, replacements);
  editor.finish();
  return {};
}

// A Draco stream has its attributes until it is encoded again.
Status note_dropped(const Document& document, const DroppedAttributes& dropped, EncodeJobs& read,
                    EncodeReports& reports) {
  const auto is_compressed = [&](PrimitiveId id) {
    return document.records().primitive(id).storage() != PrimitiveStorage::kPlain;
  };
  for (const auto& [id, names] : dropped.of_primitive) {
    const PrimitiveId primitive{id.first, id.second};
    reports[primitive].dropped_attributes = names;
    const auto reason = read.skipped.find(id);
    if (reason != read.skipped.end() && is_compressed(primitive))
      return unsupported(
          names.front() + " cannot be skipped: the primitive is left as it is, " + reason->second,
          place_of(document, primitive));
  }
  for (EncodeJob& job : read.jobs)
    job.drops_attributes = !dropped.of(job.group.ids.front()).empty() && is_compressed(job.group.ids.front());
  return {};
}

// glTF requires the bounds of positions. A .drc file does not state them; they are known after decoding.
void set_position_bounds(Document& document, const EncodeJob& job) {
  const Attribute* position = job.mesh.find("POSITION");
  const PrimitiveId id = job.group.ids.front();
  const auto index = integer_field(primitive_json(document, id)["attributes"], "POSITION");
  if (position == nullptr || !index) return;
  Json& accessor = document.json()["accessors"][static_cast<size_t>(*index)];
  if (field(accessor, "min") != nullptr && field(accessor, "max") != nullptr) return;
  const AccessorData data{position->component_type, position->component_count, position->normalized,
                          job.mesh.point_count, position->values};
  describe_decoded(accessor, data, true);
}

// The bytes of the morph targets that write_geometry stores for the job.
uint64_t morph_bytes(const Document& document, const EncodeJob& job) {
  if (job.morphs.empty()) return 0;
  const PrimitiveId id = job.group.ids.front();
  const std::vector<AttributeRecords>& targets = document.records().primitive(id).targets;
  uint64_t points = 0;
  for (const StreamEntry& entry : job.encoded.entries) points += entry.point_count - entry.reference_count;
  std::set<int64_t> counted;
  uint64_t bytes = 0;
  for (const MorphAttribute& morph : job.morphs) {
    const auto& of_target = targets[morph.target];
    const auto found = std::ranges::find(of_target, morph.semantic, &AttributeRecord::semantic);
    if (!counted.insert(found->accessor).second) continue;
    const uint64_t width = component_bytes(morph.data.component_type) * morph.data.component_count;
    uint64_t moved = 0;
    for (uint64_t i = 0; morph.sparse && i < morph.data.count; ++i) {
      const auto value = std::span(morph.data.values).subspan(i * width, width);
      moved += std::ranges::any_of(value, [](std::byte b) { return b != std::byte{0}; }) ? 1 : 0;
    }
    const uint64_t index_bytes = points > 0x10000 ? 4 : points > 0x100 ? 2 : 1;
    bytes += morph.sparse ? std::min(points * width, moved * (width + index_bytes)) : points * width;
  }
  return bytes;
}

// Geometries that share data, which goes only with all of them.
struct SharingJobs {
  std::vector<EncodeJob*> jobs;
  uint64_t before = 0;     // the bytes that the document would lose with them
  uint64_t after = 0;      // those that it would get
  bool has_users = false;  // other objects keep some of the data

  std::string sizes() const {
    return std::to_string(after) + " bytes instead of " + std::to_string(before) +
           (jobs.size() > 1 ? ", together with the primitives that share its data" : "") +
           (has_users ? "; what other objects use would stay" : "");
  }
};

std::vector<SharingJobs> sharing_jobs(const Document& document, std::vector<EncodeJob>& jobs) {
  const GeometryOwners owners(document);
  std::vector<EncodeJob*> encoded;
  std::vector<const PrimitiveGroup*> groups;
  for (EncodeJob& job : jobs) {
    if (!job.status.ok() || job.parts) continue;  // parts are never left as they were
    encoded.push_back(&job);
    groups.push_back(&job.group);
  }
  std::vector<SharingJobs> result;
  for (const std::vector<size_t>& set : owners.sharing_sets(groups)) {
    SharingJobs& sharing = result.emplace_back();
    std::vector<const PrimitiveGroup*> of_set;
    std::vector<PrimitiveId> ids;
    for (const size_t i : set) {
      sharing.jobs.push_back(encoded[i]);
      sharing.after += encoded[i]->stored_bytes + morph_bytes(document, *encoded[i]);
      of_set.push_back(groups[i]);
      ids.push_back(groups[i]->ids.front());
    }
    sharing.before = owners.bytes_of(of_set);
    sharing.has_users = sharing.before < geometry_bytes(document, ids);
  }
  return result;
}

// Why the geometries stay as they are; empty if they do not. Parallel decoding is worth a few bytes: patches of
// stock Draco may take 3 % more.
std::string reason_to_leave(const Document& document, const SharingJobs& sharing) {
  if (sharing.after < sharing.before) return "";
  bool is_stock = true, is_split = true;
  for (const EncodeJob* job : sharing.jobs) {
    is_stock &= document.records().primitive(job->group.ids.front()).storage() == PrimitiveStorage::kStockDraco;
    is_split &= job->encoded.statistics.patch_count > 1;
  }
  if (!is_stock) return "Draco would take " + sharing.sizes();
  if (!is_split) return "stock Draco that would take " + sharing.sizes();
  constexpr uint64_t kMostPercent = 103;
  if (sharing.after * 100 <= sharing.before * kMostPercent) return "";
  return "stock Draco that would take " + sharing.sizes() +
         " in patches; --patches and --patch-faces split it all the same";
}

// Removes the jobs whose geometry stays as it is, because it cannot be encoded or would grow, and reports the
// reason. Geometry that grows because the user asks for patches gets a warning.
Status leave_what_would_grow(Document& document, const EncodeDocumentOptions& options,
                             std::vector<EncodeJob>& jobs, EncodeReports& reports) {
  const bool with_fallback = options.fallback != Fallback::kNone;
  for (EncodeJob& job : jobs) {
    if (job.status.ok())
      job.note_storage();
    else if (job.status.code() != StatusCode::kUnsupported || job.drops_attributes)
      return std::move(job.status).at(job.place(document));
    for (const PrimitiveId id : job.group.ids) reports[id].skipped = job.status.message();
  }
  for (const SharingJobs& sharing : sharing_jobs(document, jobs)) {
    const bool is_wanted =
        options.patches.is_given() || with_fallback ||
        std::ranges::any_of(sharing.jobs, [&](const EncodeJob* job) {
          return job->drops_attributes ||
                 document.records().primitive(job->group.ids.front()).storage() == PrimitiveStorage::kPatches;
        });
    const std::string reason = is_wanted ? "" : reason_to_leave(document, sharing);
    for (const EncodeJob* job : sharing.jobs)
      for (const PrimitiveId id : job->group.ids) reports[id].skipped = reason;
    if (is_wanted && !with_fallback && sharing.after > sharing.before)
      reports[sharing.jobs.front()->group.ids.front()].warnings.push_back("grows: " + sharing.sizes());
  }
  std::vector<EncodeJob> kept;
  for (EncodeJob& job : jobs)
    if (reports[job.group.ids.front()].skipped.empty())
      kept.push_back(std::move(job));
    else if (document.from_draco)
      set_position_bounds(document, job);
  jobs = std::move(kept);
  return {};
}

// What the report says of a mesh file, as if its mesh had been in memory.
void report_spooled(const SpooledPoints& points, const EncodeJob& job, PrimitiveReport& report) {
  if (points.are_repeated) report.points -= std::exchange(report.statistics.merged_points, 0);
  report.input_bytes = report.faces * 3 * component_bytes(index_type(static_cast<uint32_t>(report.points)));
  for (const Attribute& attribute : job.mesh.attributes)
    report.input_bytes += report.points * attribute.stride();
}

}  // namespace

Expected<std::vector<PrimitiveReport>> encode_document(Document& document, const EncodeDocumentOptions& wanted,
                                                       const DecodeBackend& backend, const ThreadPool& pool,
                                                       const Progress& progress,
                                                       const OutOfCoreOptions& limits) {
  if (Status status = document.check(); !status.ok()) return status;
  const bool repeats_points = document.spooled && document.spooled->are_repeated;
  EncodeDocumentOptions options = wanted;
  options.keep_duplicates = wanted.keep_duplicates && !repeats_points;
  // With Compat::kKhr, read_jobs decodes and checks primitives in patches.
  if (options.compat == Compat::kNone)
    if (Status status = check_patches(document, backend, pool); !status.ok()) return status;
  const Expected<DroppedAttributes> dropped = drop_attributes(document, options, all_primitives(document));
  if (!dropped) return dropped.status();
  // The temporary files of a mesh file have one primitive. Their space goes as soon as it can.
  const auto forget = [&document] {
    if (!document.spooled) return;
    std::ranges::fill(document.buffers, Buffer());
    document.spooled->numbers = Buffer();
  };
  Expected<EncodeJobs> read = read_jobs(document, options, backend, pool, limits, progress, forget);
  if (!read) return read.status();
  EncodeReports reports(document, *read);
  if (Status status = note_dropped(document, *dropped, *read, reports); !status.ok()) return status;
  std::vector<EncodeJob>& jobs = read->jobs;
  const std::vector<uint32_t> counts = patch_counts(jobs, options);
  for (size_t i = 0; i < jobs.size(); ++i) jobs[i].options.patch_count = counts[i];
  encode_jobs(document, jobs, pool, progress);
  if (Status status = leave_what_would_grow(document, options, jobs, reports); !status.ok()) return status;
  for (EncodeJob& job : jobs)
    for (const PrimitiveId id : job.group.ids) {
      job.report(reports[id]);
      if (document.spooled) report_spooled(*document.spooled, job, reports[id]);
    }
  Expected<CondensedPatches> condensed = CondensedPatches();
  if (options.condense && options.compat == Compat::kNone)
    condensed = condense_patches(document, options, pool, reports);
  if (!condensed) return condensed.status();
  Status status = write_geometry(document, jobs, options, limits, pool, dropped->freed, *condensed, reports);
  if (!status.ok()) return status;
  return std::move(reports).list();
}

}  // namespace psplit
