#include <algorithm>
#include <atomic>
#include <iterator>
#include <utility>

#include "encoder/coding/position_bits.h"
#include "encoder/coding/quantization.h"
#include "gltf_ext/convert/coarse_primitives.h"
#include "gltf_ext/convert/compress_rest.h"
#include "gltf_ext/convert/condense_document.h"
#include "gltf_ext/convert/drop_attributes.h"
#include "gltf_ext/convert/encode_job.h"
#include "gltf_ext/convert/encode_large_mesh.h"
#include "gltf_ext/convert/join_points.h"
#include "gltf_ext/convert/json_growth.h"
#include "gltf_ext/convert/plain_neighbours.h"
#include "gltf_ext/convert/read_jobs.h"
#include "gltf_ext/convert/sparse_targets.h"
#include "gltf_ext/convert/store_job.h"
#include "gltf_ext/convert/validate.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/primitive/geometry_bytes.h"
#include "psplit/document.h"
#include "psplit/gltf.h"
#include "src/container/patch_container.h"

namespace psplit {
namespace {

// keeps_meshes: the meshes are needed afterwards; for .drc files set_position_bounds needs them.
void encode_jobs(std::vector<EncodeJob>& jobs, const EncodeOptions& options, bool keeps_meshes,
                 const ThreadPool& pool, const Progress& progress) {
  size_t faces = 0;
  for (const EncodeJob& job : jobs) faces += job.face_count;
  std::atomic<size_t> done = 0;
  if (progress) progress(0, faces);
  pool.for_each(jobs.size(), [&](size_t i) {
    EncodeJob& job = jobs[i];
    Watch watch;
    std::atomic<size_t> done_of_job = 0;
    if (progress)
      watch.progress = [&](size_t now, size_t) {
        // Calls from several threads may come out of order.
        for (size_t before = done_of_job; now > before;)
          if (done_of_job.compare_exchange_weak(before, now)) {
            progress(done += now - before, faces);
            break;
          }
      };
    Expected<EncodedMesh> encoded = keeps_meshes ? encode(job.source, options, pool, watch)
                                                 : encode(std::move(job.source), options, pool, watch);
    if (encoded.ok()) {
      job.encoded = std::move(*encoded);
      job.add_equal_targets();
    } else
      job.status = encoded.status();
    if (progress && done_of_job < job.face_count) progress(done += job.face_count - done_of_job, faces);
  });
}

// Stores a container as the primitive's extension, or each of several and each lone stream as a primitive of
// its own.
Status write_geometry(Document& document, std::vector<EncodeJob>& jobs, const EncodeDocumentOptions& options,
                      const OutOfCoreOptions& limits, const ThreadPool& pool,
                      std::span<const int64_t> freed_accessors, EncodeReports& reports) {
  std::vector<PrimitiveGroup> groups;
  std::vector<size_t> counts;
  for (const EncodeJob& job : jobs) {
    groups.push_back(job.group);
    counts.push_back(job.piece_count());
  }
  const auto repeated = repeat_primitives(document, groups, counts);
  PrimitiveEditor editor(document);
  for (size_t i = 0; i < jobs.size(); ++i)
    if (Status status = store_job(document, jobs[i], repeated[i], options, limits, pool, editor); !status.ok())
      return status;
  list_stored(document, jobs, repeated);
  drop_manifolds(document, jobs, editor, reports);
  for (const int64_t accessor : freed_accessors) editor.release(accessor);
  editor.finish();
  return {};
}

// The primitives of the input in the order in which write_geometry stores them: each as often as it has pieces.
std::vector<PrimitiveId> origins_of_output(const Document& input, std::span<const EncodeJob> jobs) {
  std::map<PrimitiveId, size_t> piece_counts;
  for (const EncodeJob& job : jobs)
    for (const PrimitiveId id : job.group.ids) piece_counts[id] = job.piece_count();
  std::vector<PrimitiveId> origins;
  for (const PrimitiveId id : all_primitives(input)) {
    const auto found = piece_counts.find(id);
    origins.insert(origins.end(), found == piece_counts.end() ? 1 : found->second, id);
  }
  return origins;
}

// What the report says of a primitive whose streams may have been condensed.
void report_condensed(const Document& output, PrimitiveId id, const CondensedView& view,
                      PrimitiveReport& report) {
  const bool is_kept = report.stored_as == StoredAs::kAsItWas;
  if (view.bytes == 0) {
    if (is_kept && output.records().primitive(id).patches)
      report.skipped = view.was_condensed ? "already in condensed patches"
                                          : "already in patches, which condensing does not make smaller";
    return;
  }
  report.skipped.clear();
  report.stored_as = StoredAs::kPatches;
  report.bytes = view.bytes;
  report.streams = view.entries;
  report.has_residue = view.has_residue;
  report.head_bytes = view.head_bytes;
  report.statistics.encode_ms += view.condense_ms;
  report.statistics.verify_ms += view.verify_ms;
  if (!is_kept) return;
  report.keeps_streams = true;
  report.repeated = id != view.ids.front();
  report.faces = view.face_count;
  report.points = view.point_count;
  report.statistics.patch_count = static_cast<uint32_t>(view.entries.size()) - (view.has_residue ? 1 : 0);
}

// Condenses the streams that write_geometry stored, and the input's streams that it left. Parts are condensed
// already, and streams that cannot be read stay.
Status condense_output(Document& output, std::span<const PrimitiveId> origins, std::span<const EncodeJob> jobs,
                       const EncodeDocumentOptions& options, const ThreadPool& pool, EncodeReports& reports) {
  std::set<PrimitiveId> in_parts;
  std::map<PrimitiveId, const Mesh*> decoded;  // of jobs with one piece, by primitive of the input
  for (const EncodeJob& job : jobs) {
    if (job.is_in_parts()) in_parts.insert(job.group.ids.begin(), job.group.ids.end());
    for (const PrimitiveId id : job.group.ids)
      if (job.piece_count() == 1) decoded[id] = &job.encoded.pieces.front().decoded;
  }
  const std::vector<PrimitiveId> all = all_primitives(output);
  std::map<PrimitiveId, PrimitiveId> origin_of;
  std::vector<PrimitiveId> ids;
  for (size_t i = 0; i < all.size(); ++i) {
    const PrimitiveId origin = origin_of[all[i]] = origins[i];
    const bool was_read = reports[origin].faces > 0;
    if (in_parts.contains(origin)) continue;
    if (output.records().primitive(all[i]).storage() == PrimitiveStorage::kStockDraco && !was_read) continue;
    ids.push_back(all[i]);
  }
  const CondenseOptions condensing{options.condense == Condense::kSmallest, options.verify,
                                   [&](PrimitiveId id) {
                                     const auto found = decoded.find(origin_of.at(id));
                                     return found == decoded.end() ? nullptr : found->second;
                                   }};
  const auto views = condense_document(output, ids, condensing, pool);
  if (!views) return views.status();
  for (const CondensedView& view : *views)
    for (const PrimitiveId id : view.ids) report_condensed(output, id, view, reports[origin_of.at(id)]);
  return {};
}

// Joins points of jobs that stay whole.
Status join_points(const Document& document, const EncodeDocumentOptions& options, std::vector<EncodeJob>& jobs,
                   const ThreadPool& pool) {
  pool.for_each(jobs.size(), [&](size_t i) {
    EncodeJob& job = jobs[i];
    if (job.stored_as == StoredAs::kDraco && !job.is_in_parts())
      job.status = join_repeated_points(job, options, pool);
  });
  for (EncodeJob& job : jobs)
    if (!job.status.ok()) return std::move(job.status).at(job.place(document));
  return {};
}

// A Draco stream has its attributes until it is encoded again.
Status note_dropped(Document& document, DroppedAttributes& dropped, const SkippedPrimitives& skipped,
                    std::vector<EncodeJob>& jobs, EncodeReports& reports) {
  const auto is_compressed = [&](PrimitiveId id) {
    return document.records().primitive(id).storage() != PrimitiveStorage::kPlain;
  };
  std::erase_if(dropped.before, [&](const auto& entry) {
    return !skipped.contains(entry.first) || !is_compressed(entry.first);
  });
  for (auto& [id, json] : dropped.before) {
    primitive_json(document, id) = std::move(json);
    dropped.of_primitive.erase(id);
  }
  for (const auto& [id, names] : dropped.of_primitive) {
    reports[id].dropped_attributes = names;
    const auto reason = skipped.find(id);
    if (reason != skipped.end() && is_compressed(id))
      return unsupported(
          names.front() + " cannot be skipped: the primitive is left as it is, " + reason->second,
          place_of(document, id));
  }
  for (auto& [id, names] : dropped.unused) reports[id].unused_attributes = std::move(names);
  for (EncodeJob& job : jobs)
    job.drops_attributes = !dropped.of(job.group.ids.front()).empty() && is_compressed(job.group.ids.front());
  return {};
}

// glTF requires the bounds of positions. A .drc file does not state them; they are known after decoding.
void set_position_bounds(Document& document, const EncodeJob& job) {
  const Attribute* position = job.source.mesh.find("POSITION");
  const PrimitiveId id = job.group.ids.front();
  const auto index = integer_field(primitive_json(document, id)["attributes"], "POSITION");
  if (position == nullptr || !index) return;
  Json& accessor = document.json()["accessors"][static_cast<size_t>(*index)];
  if (field(accessor, "min") != nullptr && field(accessor, "max") != nullptr) return;
  const AccessorData data{position->component_type, position->component_count, position->normalized,
                          job.source.mesh.point_count, position->values};
  describe_decoded(accessor, data, true);
}

// The bytes of the morph targets that write_geometry stores for the job.
uint64_t morph_bytes(const Document& document, const EncodeJob& job) {
  if (job.morphs.empty()) return 0;
  const PrimitiveId id = job.group.ids.front();
  const std::vector<AttributeRecords>& targets = document.records().primitive(id).targets;
  uint64_t points = 0;
  for (const EncodedPiece& piece : job.encoded.pieces) points += piece.point_count;
  std::set<int64_t> counted;
  uint64_t bytes = 0;
  for (const MorphAttribute& morph : job.morphs) {
    const auto& of_target = targets[morph.target];
    const auto found = std::ranges::find(of_target, morph.semantic, &AttributeRecord::semantic);
    if (!counted.insert(found->accessor).second) continue;
    const uint64_t dense = points * component_bytes(morph.data.component_type) * morph.data.component_count;
    const uint64_t stored =
        morph.sparse
            ? std::min(dense, sparse_bytes(morph.data, elements_that_are_not_zero(morph.data, ZeroSign::kKept)))
            : dense;
    // A view that meshoptimizer compressed will be compressed again.
    const AccessorRecord& accessor = document.records().accessor(found->accessor);
    const uint64_t before = accessor.stored_bytes();
    bytes += before == 0 ? stored : stored * document.records().file_bytes(accessor) / before;
  }
  return bytes;
}

// Whether meshoptimizer compresses morph targets again. What they take in another order is known only then.
bool compresses_again(const Document& document, const EncodeJob& job) {
  const std::vector<AttributeRecords>& targets = document.records().primitive(job.group.ids.front()).targets;
  return std::ranges::any_of(job.morphs, [&](const MorphAttribute& morph) {
    const auto found = std::ranges::find(targets[morph.target], morph.semantic, &AttributeRecord::semantic);
    return document.records().is_meshopt(document.records().accessor(found->accessor));
  });
}

// The bytes of geometries that share data, which goes only with all of them.
struct SharedSizes {
  std::vector<PrimitiveId> ids;             // the first primitive of each
  uint64_t before = 0;                      // the bytes that the document would lose with them
  uint64_t streams = 0, morph_targets = 0;  // the bytes that it would get instead
  int64_t json = 0;                         // by which its JSON would grow
  bool has_users = false;                   // other objects keep some of the data

  uint64_t after() const { return streams + morph_targets; }
  // The bytes that the document would lose in total.
  int64_t gain() const { return static_cast<int64_t>(before) - static_cast<int64_t>(after()) - json; }
  std::string text() const {
    const std::string of_json = json == 0 ? ""
                                          : " and " + std::to_string(json < 0 ? -json : json) + " bytes " +
                                                (json < 0 ? "less" : "more") + " of JSON";
    return std::to_string(after()) + " bytes instead of " + std::to_string(before) + of_json +
           (ids.size() > 1 ? ", together with the primitives that share its data" : "") +
           (has_users ? "; what other objects use would stay" : "");
  }
};
struct SharingJobs {
  std::vector<EncodeJob*> jobs;
  SharedSizes sizes;

  std::vector<const EncodeJob*> jobs_to_read() const { return {jobs.begin(), jobs.end()}; }
};

std::vector<SharingJobs> sharing_jobs(const Document& document, std::vector<EncodeJob>& jobs) {
  const GeometryOwners owners(document);
  std::vector<EncodeJob*> encoded;
  std::vector<const PrimitiveGroup*> groups;
  for (EncodeJob& job : jobs) {
    if (!job.status.ok() || job.is_in_parts()) continue;  // parts are never left as they were
    encoded.push_back(&job);
    groups.push_back(&job.group);
  }
  std::vector<SharingJobs> result;
  for (const std::vector<size_t>& set : owners.sharing_sets(groups)) {
    SharingJobs& sharing = result.emplace_back();
    SharedSizes& sizes = sharing.sizes;
    std::vector<const PrimitiveGroup*> of_set;
    for (const size_t i : set) {
      sharing.jobs.push_back(encoded[i]);
      sizes.streams += encoded[i]->stored_bytes;
      sizes.morph_targets += morph_bytes(document, *encoded[i]);
      of_set.push_back(groups[i]);
      sizes.ids.push_back(groups[i]->ids.front());
    }
    sizes.before = owners.bytes_of(of_set);
    sizes.json = json_growth(document, owners, sharing.jobs_to_read());
    sizes.has_users = sizes.before < geometry_bytes(document, sizes.ids);
  }
  return result;
}

// Why the geometries stay as they are; empty if they do not. `may_shrink`: they are to be condensed, so that
// patches of stock Draco may take what patches may cost.
std::string reason_to_leave(const Document& document, const SharingJobs& sharing, bool may_shrink) {
  const SharedSizes& sizes = sharing.sizes;
  bool is_stock = true, is_split = true;
  for (const EncodeJob* job : sharing.jobs) {
    is_stock &= document.records().primitive(job->group.ids.front()).storage() == PrimitiveStorage::kStockDraco;
    is_split &= job->encoded.statistics.patch_count > 1;
  }
  // A few digits less in the bounds are no reason to encode a stream again.
  if (sizes.gain() > 0 && (!is_stock || sizes.after() < sizes.before)) return "";
  if (!is_stock) return "Draco would take " + sizes.text();
  if (!is_split) return "stock Draco that would take " + sizes.text();
  if (may_shrink && sizes.after() * 100 <= sizes.before * (100 + kMostSplitPercent)) return "";
  return "stock Draco that would take " + sizes.text() +
         " in patches; --patches and --patch-faces split it all the same";
}

constexpr const char* kTooSmallForCoarse = "so few faces that a coarse form would have them all";
// Whether plain geometry would be stored twice if it was encoded.
bool is_too_small_for_coarse(const Document& document, const EncodeDocumentOptions& options,
                             const SharingJobs& sharing) {
  return options.fallback == Fallback::kCoarse && !options.patches.always &&
         std::ranges::all_of(sharing.jobs, [&](const EncodeJob* job) {
           return job->face_count <= kLeastCoarseFaces && !job->drops_attributes &&
                  document.records().primitive(job->group.ids.front()).storage() == PrimitiveStorage::kPlain;
         });
}

// What the asset would lose if all that is not left is encoded.
struct ExpectedGain {
  int64_t bytes = 0;
  size_t geometries = 0;
  bool are_wanted = false;   // some are encoded whatever they take
  bool are_guesses = false;  // of some, morph targets are to be compressed again

  // Whether the asset may grow all the same: each geometry may have this much more JSON than was expected.
  bool is_doubtful() const {
    constexpr int64_t kDoubt = 512;
    const bool is_little = bytes < kDoubt * static_cast<int64_t>(geometries + 1);
    return !are_wanted && geometries > 0 && (is_little || are_guesses);
  }
};

// The names of extensions in the lists of an asset may take more than small geometries save.
void leave_what_lists_outweigh(const Document& document, std::span<const SharingJobs> sets, ExpectedGain& gain,
                               EncodeReports& reports) {
  std::set<std::string> names;
  for (const SharingJobs& sharing : sets) {
    gain.bytes += sharing.sizes.gain();
    gain.geometries += sharing.jobs.size();
    for (const EncodeJob* job : sharing.jobs) {
      names.insert(job->stored_as == StoredAs::kPatches ? kExtensionName : kStockExtensionName);
      gain.are_guesses |= compresses_again(document, *job);
    }
  }
  for (const std::string& name : names) gain.bytes -= list_growth(document, name.c_str());
  const bool is_draco = std::ranges::any_of(sets, [&](const SharingJobs& sharing) {
    return document.records().primitive(sharing.sizes.ids.front()).storage() == PrimitiveStorage::kStockDraco;
  });
  if (gain.are_wanted || gain.bytes > 0 || is_draco) return;
  for (const SharingJobs& sharing : sets)
    for (const EncodeJob* job : sharing.jobs)
      for (const PrimitiveId id : job->group.ids)
        reports[id].skipped =
            "Draco would take " + sharing.sizes.text() + ", and its name in the lists of extensions more";
  gain = {};
}

// Removes the jobs whose geometry stays as it is, because it cannot be encoded or would grow, and reports the
// reason. Adds the others that may grow, because the user wants them, to `may_grow`. reason_to_leave describes
// may_shrink.
Status leave_what_would_grow(Document& document, const EncodeDocumentOptions& options, bool may_shrink,
                             std::vector<EncodeJob>& jobs, std::vector<SharedSizes>& may_grow,
                             ExpectedGain& gain, EncodeReports& reports) {
  const bool with_fallback = options.fallback == Fallback::kUncompressed;
  const bool is_stock = options.storage == Storage::kOneStream;
  // Coarse primitives replace all primitives of a mesh, so the whole mesh is in patches.
  const auto is_stored = [&](const EncodeJob* job) {
    const PrimitiveStorage storage = document.records().primitive(job->group.ids.front()).storage();
    return storage == PrimitiveStorage::kPatches ||
           (storage == PrimitiveStorage::kStockDraco && options.fallback == Fallback::kCoarse);
  };
  for (EncodeJob& job : jobs) {
    if (job.status.ok())
      job.note_storage();
    else if (job.status.code() != StatusCode::kUnsupported || job.drops_attributes)
      return std::move(job.status).at(job.place(document));
    for (const PrimitiveId id : job.group.ids) reports[id].skipped = job.status.message();
  }
  std::vector<SharingJobs> by_gain;
  for (SharingJobs& sharing : sharing_jobs(document, jobs)) {
    const bool is_wanted = options.patches.is_given() || with_fallback || is_stock || document.is_retyped ||
                           std::ranges::any_of(sharing.jobs, [&](const EncodeJob* job) {
                             return job->drops_attributes || is_stored(job);
                           });
    std::string reason = is_wanted ? "" : reason_to_leave(document, sharing, may_shrink);
    if (is_too_small_for_coarse(document, options, sharing)) reason = kTooSmallForCoarse;
    for (const EncodeJob* job : sharing.jobs)
      for (const PrimitiveId id : job->group.ids) reports[id].skipped = reason;
    if (is_wanted && !with_fallback && !is_stock) may_grow.push_back(sharing.sizes);
    if (reason.empty() && !is_wanted) by_gain.push_back(std::move(sharing));
    gain.are_wanted |= reason.empty() && is_wanted;
  }
  leave_what_lists_outweigh(document, by_gain, gain, reports);
  std::vector<EncodeJob> kept;
  for (EncodeJob& job : jobs)
    if (reports[job.group.ids.front()].skipped.empty())
      kept.push_back(std::move(job));
    else if (document.from_draco)
      set_position_bounds(document, job);
  jobs = std::move(kept);
  return {};
}

// Geometry that grows because the user asks for patches gets a warning.
void warn_of_growth(std::vector<SharedSizes>& may_grow, EncodeReports& reports) {
  for (SharedSizes& sizes : may_grow) {
    sizes.streams = 0;  // some may be condensed now
    for (const PrimitiveId id : sizes.ids) sizes.streams += reports[id].bytes;
    if (sizes.gain() < 0) reports[sizes.ids.front()].warnings.push_back("grows: " + sizes.text());
  }
}

// What the report says of a mesh file, as if its mesh had been in memory.
void report_spooled(const SpooledPoints& points, const EncodeJob& job, PrimitiveReport& report) {
  if (points.are_repeated) report.points -= std::exchange(report.statistics.merged_points, 0);
  report.input_bytes = report.faces * 3 * component_bytes(index_type(static_cast<uint32_t>(report.points)));
  for (const Attribute& attribute : job.source.mesh.attributes)
    report.input_bytes += report.points * attribute.stride();
}

// The input's bytes of the morph targets that the job's streams will store.
uint64_t bytes_of_targets(const Document& input, const EncodeJob& job) {
  const PrimitiveRecord& primitive = input.records().primitive(job.group.ids.front());
  std::set<int64_t> accessors;
  for (const Attribute& attribute : job.source.mesh.attributes)
    if (target_of(attribute.semantic)) accessors.insert(primitive.accessor_of(attribute.semantic));
  uint64_t bytes = 0;
  for (const int64_t index : accessors) bytes += input.records().file_bytes(input.records().accessor(index));
  return bytes;
}

// Primitives that share grids are to move alike. Warns of primitives whose morph targets stay exact while
// others of their group are rounded.
void warn_of_exact_targets(const Document& document, std::span<const EncodeJob> jobs, const GridGroups& groups,
                           EncodeReports& reports) {
  struct Rounded {
    std::set<PrimitiveId> ids;
    double most = 0;
  };
  std::map<size_t, Rounded> rounded;  // by group
  for (const EncodeJob& job : jobs)
    for (size_t i = 0; i < job.source.codings.size(); ++i) {
      const AttributeCoding& coding = job.source.codings[i];
      const auto group = groups.of_mesh(job.group.ids.front().mesh);
      if (!group || coding.bits == 0 || !target_of(job.source.mesh.attributes[i].semantic)) continue;
      rounded[*group].ids.insert(job.group.ids.begin(), job.group.ids.end());
      rounded[*group].most = std::max(rounded[*group].most, grid_step(coding) / 2);
    }
  std::map<PrimitiveId, const EncodeJob*> job_of;
  for (const EncodeJob& job : jobs)
    for (const PrimitiveId id : job.group.ids) job_of[id] = &job;
  const AssetRecords& records = document.records();
  for (const PrimitiveId id : all_primitives(document)) {
    const auto group = groups.of_mesh(id.mesh);
    const auto found = group ? rounded.find(*group) : rounded.end();
    if (found == rounded.end() || found->second.ids == std::set{id}) continue;
    const PrimitiveRecord& primitive = records.primitive(id);
    const auto job = job_of.find(id);
    bool are_exact = false;
    if (job != job_of.end())
      for (const MorphAttribute& morph : job->second->morphs)
        are_exact |= morph.data.component_type == ComponentType::kFloat32 &&
                     !elements_that_are_not_zero(morph.data, ZeroSign::kIgnored).empty();
    else
      for (const AttributeRecords& target : primitive.targets)
        for (const AttributeRecord& deltas : target)
          are_exact |= !records.accessor(deltas.accessor).views().empty();
    if (!are_exact) continue;
    reports[id].warnings.push_back(
        "its morph targets stay exact, and those of the primitives beside it move by up to " +
        rounded_text(found->second.most) + ": surfaces that touch may come apart when they morph");
  }
}

// `jobs` are encoded in memory, `large` in parts.
EncodeReports reports_of_input(const Document& input, const SkippedPrimitives& skipped,
                               std::span<const EncodeJob> jobs, std::span<const EncodeJob> large) {
  EncodeReports reports;
  for (const auto& [id, bytes] : geometry_bytes(input)) {
    PrimitiveReport& report = reports[id];
    report.id = id;
    report.input_bytes = report.bytes = bytes;
  }
  for (const auto& [id, reason] : skipped) reports.at(id).skipped = reason;
  for (const std::span<const EncodeJob> read : {jobs, large})
    for (const EncodeJob& job : read)
      for (size_t i = 0; i < job.group.ids.size(); ++i) {
        PrimitiveReport& report = reports.at(job.group.ids[i]);
        report.repeated = i > 0;
        const uint64_t targets = bytes_of_targets(input, job);
        report.input_bytes += targets;
        report.bytes += targets;
        report.faces = job.face_count;
        report.points = job.point_count();
      }
  return reports;
}

std::vector<PrimitiveReport> list_of(EncodeReports reports) {
  std::vector<PrimitiveReport> list;
  for (auto& [id, report] : reports) list.push_back(std::move(report));
  return list;
}

// The asset stays as it was, because it would grow.
std::vector<PrimitiveReport> leave_asset(EncodeReports reports, uint64_t before, uint64_t after) {
  std::vector<PrimitiveReport> list = list_of(std::move(reports));
  const std::string reason =
      "the asset would take " + std::to_string(after) + " bytes as a GLB instead of " + std::to_string(before);
  for (PrimitiveReport& report : list)
    if (report.skipped.empty()) report.skipped = reason;
  return list;
}

// PatchTarget::count counts the patches of all primitives. Primitives in parts have theirs already; the others
// share the rest.
void share_patches(const PatchTarget& target, std::span<const EncodeJob> large, std::vector<EncodeJob>& jobs) {
  if (target.count == 0 || large.empty()) return;
  std::vector<uint64_t> faces;
  for (const EncodeJob& job : jobs) faces.push_back(job.face_count);
  for (const EncodeJob& job : large) faces.push_back(job.face_count);
  const std::vector<uint32_t> counts = patch_counts(faces, target);
  for (size_t i = 0; i < jobs.size(); ++i) jobs[i].source.patch_count = counts[i];
}

// The primitives of a document on their way: read and planned, then encoded.
struct Geometry {
  DroppedAttributes dropped;
  std::vector<EncodeJob> jobs;   // in memory
  std::vector<EncodeJob> large;  // in parts, and encoded
  GridGroups groups;
  EncodeReports reports;
};

Expected<Geometry> read_geometry(Document& document, const EncodeDocumentOptions& options,
                                 const DecodeBackend& backend, const OutOfCoreOptions& limits,
                                 const ThreadPool& pool, const Progress& progress) {
  if (Status status = check_patches(document, pool); !status.ok()) return status;
  Expected<DroppedAttributes> dropped = drop_attributes(document, options, all_primitives(document));
  if (!dropped) return dropped.status();
  // The temporary files of a mesh file hold one primitive. Their space is freed early.
  const auto forget = [&document] {
    if (!document.spooled) return;
    std::ranges::fill(document.buffers, Buffer());
    document.spooled->numbers = Buffer();
  };
  Expected<SelectedPrimitives> selected = select_primitives(document, options, limits);
  if (!selected) return selected.status();
  Expected<std::vector<EncodeJob>> large =
      encode_large_primitives(document, options, *selected, limits, pool, progress, forget);
  if (!large) return large.status();
  Expected<std::vector<EncodeJob>> jobs = read_jobs(document, options, *selected, backend, pool);
  if (!jobs) return jobs.status();
  Expected<GridGroups> groups = plan_jobs(document, options, selected->skipped, *jobs, pool);
  if (!groups) return groups.status();
  share_patches(options.of_meshes().patches, *large, *jobs);
  EncodeReports reports = reports_of_input(document, selected->skipped, *jobs, *large);
  if (Status status = note_dropped(document, *dropped, selected->skipped, *jobs, reports); !status.ok())
    return status;
  return Geometry{std::move(*dropped), std::move(*jobs), std::move(*large), std::move(*groups),
                  std::move(reports)};
}

// Stores the encoded geometry, and condenses it. Nothing if the asset would grow with patches that took more
// than they save (may_shrink: because they are condensed afterwards): the document is as it was.
Expected<std::optional<std::vector<PrimitiveReport>>> store_geometry(Document& document,
                                                                     const EncodeDocumentOptions& options,
                                                                     Geometry geometry, bool may_shrink,
                                                                     const OutOfCoreOptions& limits,
                                                                     const ThreadPool& pool) {
  std::vector<EncodeJob>& jobs = geometry.jobs;
  EncodeReports& reports = geometry.reports;
  const EncodeReports as_they_were = reports;
  std::ranges::move(geometry.large, std::back_inserter(jobs));
  std::vector<SharedSizes> may_grow;
  ExpectedGain gain;
  Status status = leave_what_would_grow(document, options, may_shrink, jobs, may_grow, gain, reports);
  if (!status.ok()) return status;
  std::optional<Document> before;
  if (gain.is_doubtful() && geometry.dropped.of_primitive.empty() && !document.spooled && !document.from_draco)
    before = document;
  if (options.condenses()) status = join_points(document, options, jobs, pool);
  if (!status.ok()) return status;
  for (EncodeJob& job : jobs)
    for (const PrimitiveId id : job.group.ids) {
      job.report(reports[id]);
      if (document.spooled) report_spooled(*document.spooled, job, reports[id]);
    }
  warn_of_exact_targets(document, jobs, geometry.groups, reports);
  const std::vector<PrimitiveId> origins = origins_of_output(document, jobs);
  const auto grids = position_grids(jobs, geometry.groups);
  status = write_geometry(document, jobs, options, limits, pool, geometry.dropped.freed, reports);
  if (status.ok())
    status = round_plain_neighbours(document, origins, jobs, geometry.groups, grids, pool, reports);
  if (status.ok() && options.condenses())
    status = condense_output(document, origins, jobs, options, pool, reports);
  if (!status.ok()) return status;
  if (before) {
    const uint64_t bytes_before = glb_bytes(*before), bytes = glb_bytes(document);
    if (bytes > bytes_before) {
      document = std::move(*before);
      if (may_shrink) return std::optional<std::vector<PrimitiveReport>>();
      return std::optional(leave_asset(as_they_were, bytes_before, bytes));
    }
  }
  warn_of_growth(may_grow, reports);
  return std::optional(list_of(std::move(reports)));
}

}  // namespace

Expected<std::vector<PrimitiveReport>> encode_document(Document& document, const EncodeDocumentOptions& wanted,
                                                       const DecodeBackend& backend, const ThreadPool& pool,
                                                       const Progress& progress,
                                                       const OutOfCoreOptions& limits) {
  if (Status status = document.check(); !status.ok()) return status;
  if (wanted.fallback == Fallback::kCoarse && wanted.compat == Compat::kKhr)
    return wrong_usage("coarse primitives are for loaders without patches, and Compat::kKhr writes none");
  if (!(wanted.coarse_share >= 0 && wanted.coarse_share <= 1))
    return wrong_usage("coarse_share is not between 0 and 1");
  if (Status status = check_rest(wanted, limits); !status.ok()) return status;
  EncodeDocumentOptions options = wanted;
  if (document.spooled && document.spooled->are_repeated) options.keep_duplicates = false;

  std::optional<std::vector<PrimitiveReport>> reports;
  for (bool may_shrink = options.condenses(); !reports; may_shrink = false) {
    Expected<Geometry> geometry = read_geometry(document, options, backend, limits, pool, progress);
    if (!geometry) return geometry.status();
    encode_jobs(geometry->jobs, options.of_meshes(), document.from_draco, pool, progress);
    auto stored = store_geometry(document, options, std::move(*geometry), may_shrink, limits, pool);
    if (!stored) return stored.status();
    reports = std::move(*stored);
  }
  join_draco_extensions(document);
  // Loaders of stock Draco would show the coarse primitives.
  if (options.compat == Compat::kKhr) drop_coarse_primitives(document);
  if (options.fallback == Fallback::kCoarse)
    if (Status status = add_coarse_primitives(document, options.coarse_share, backend, pool); !status.ok())
      return status;
  if (options.morph_targets != MorphTargets::kKeep && limits.memory == 0)
    make_targets_sparse(document, options.lossless ? ZeroSign::kKept : ZeroSign::kIgnored);
  if (Status status = compress_rest(document, options, pool); !status.ok()) return status;
  return std::move(*reports);
}

}  // namespace psplit
