#include <atomic>
#include <map>
#include <set>

#include "encoder/draco/draco_backend.h"
#include "encoder/draco/stock_stream.h"
#include "gltf_ext/convert/convert.h"
#include "gltf_ext/convert/encode_jobs.h"
#include "gltf_ext/convert/patch_primitives.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/primitive/geometry_bytes.h"

namespace psplit {
namespace {

Json unique_id_map(const Mesh& mesh, const std::vector<uint32_t>& unique_ids) {
  Json map = Json::object();
  for (size_t i = 0; i < mesh.attributes.size(); ++i) map[mesh.attributes[i].semantic] = unique_ids[i];
  return map;
}

std::vector<AttributeRequest> requests_of(const Mesh& mesh, const std::vector<uint32_t>& unique_ids) {
  std::vector<AttributeRequest> requests;
  for (size_t i = 0; i < mesh.attributes.size(); ++i) {
    const Attribute& a = mesh.attributes[i];
    requests.push_back({a.semantic, unique_ids[i], a.component_type, a.component_count, a.normalized});
  }
  return requests;
}

void set_extension(Document& document, const PrimitiveGroup& group, const char* name, const Json& extension) {
  for (const PrimitiveId id : group.ids) {
    Json& primitive = primitive_json(document, id);
    if (Json* extensions = object_field(primitive, "extensions"))
      for (const char* other : {kExtensionName, kStockExtensionName}) extensions->erase(other);
    primitive["extensions"][name] = extension;
  }
}

// The accessors' bounds are those of decoded values: what encode_mesh did not decode to verify it is decoded
// now.
void decode_unverified(std::vector<Job>& jobs, const DecodeBackend& backend, const ThreadPool& pool) {
  std::vector<Job*> left;
  for (Job& job : jobs)
    if (job.status.ok() && !job.encoded.decoded) left.push_back(&job);
  if (left.empty()) return;
  std::vector<std::vector<AttributeRequest>> requests;
  for (const Job* job : left) requests.push_back(requests_of(job->mesh, job->encoded.unique_ids));
  std::vector<DecodeTask> tasks;
  for (size_t i = 0; i < left.size(); ++i) tasks.push_back({left[i]->encoded.container, false, requests[i]});
  std::vector<Expected<Mesh>> meshes = backend.decode(tasks, pool, {});
  for (size_t i = 0; i < left.size(); ++i) {
    left[i]->status = meshes[i].status();
    if (meshes[i]) left[i]->encoded.decoded = std::move(*meshes[i]);
  }
}

void encode_jobs(std::vector<Job>& jobs, const ThreadPool& pool, const Progress& progress) {
  size_t faces = 0;
  for (const Job& job : jobs) faces += job.mesh.faces.size();
  std::atomic<size_t> done = 0;
  if (progress) progress(0, faces);
  pool.for_each(jobs.size(), [&](size_t i) {
    Job& job = jobs[i];
    std::atomic<size_t> done_of_job = 0;
    if (progress)
      job.options.patch_encoded = [&](size_t count) {
        done_of_job += count;
        progress(done += count, faces);
      };
    size_t stride = 0;
    const std::vector<std::byte> extra = distinguishing_bytes(job, stride);
    Expected<EncodedMesh> encoded = encode_mesh(job.mesh, job.codings, job.options, pool, extra, stride);
    if (encoded.ok())
      job.encoded = std::move(*encoded);
    else
      job.status = encoded.status();
    job.options.patch_encoded = {};
    // Faces that are dropped or in no patch are done as well.
    if (progress) progress(done += job.mesh.faces.size() - done_of_job, faces);
  });
}

// What became of every primitive, in their order.
class Reports {
 public:
  Reports(const Document& input, const Jobs& read) {
    for (const auto& [id, bytes] : geometry_bytes(input)) {
      PrimitiveReport& report = reports_[id];
      report.id = {id.first, id.second};
      report.input_bytes = report.bytes = bytes;
    }
    for (const auto& [id, reason] : read.skipped) reports_.at(id).skipped = reason;
    for (const Job& job : read.jobs)
      for (size_t i = 0; i < job.group.ids.size(); ++i) {
        PrimitiveReport& report = (*this)[job.group.ids[i]];
        report.repeated = i > 0;
        report.faces = job.mesh.faces.size();
        report.points = job.mesh.point_count;
      }
  }

  PrimitiveReport& operator[](PrimitiveId id) { return reports_.at({id.mesh, id.primitive}); }

  std::vector<PrimitiveReport> list() && {
    std::vector<PrimitiveReport> list;
    for (auto& [id, report] : reports_) list.push_back(std::move(report));
    return list;
  }

 private:
  std::map<std::pair<size_t, size_t>, PrimitiveReport> reports_;
};

Status report_streams(const std::vector<Job>& jobs, Reports& reports) {
  for (const Job& job : jobs) {
    Expected<Container> container = parse_container(job.encoded.container);
    if (!container) return container.status();
    if (job.stored_as != StoredAs::kPatches)
      for (StreamEntry& entry : container->entries) entry.stitch_bytes = 0;
    for (const PrimitiveId id : job.group.ids) {
      PrimitiveReport& report = reports[id];
      report.stored_as = job.stored_as;
      report.bytes = job.stored_bytes;
      report.streams = container->entries;
      report.has_residue = container->has_residue;
      report.statistics = job.encoded.statistics;
    }
  }
  return {};
}

// EXT_mesh_manifold says by indices which points of a mesh are one; they are others now.
void drop_manifolds(Document& document, const std::vector<Job>& jobs, PrimitiveEditor& editor,
                    Reports& reports) {
  constexpr const char* kManifold = "EXT_mesh_manifold";
  std::set<size_t> dropped;
  for (const Job& job : jobs)
    for (const PrimitiveId id : job.group.ids) {
      Json& mesh = document.json["meshes"][id.mesh];
      if (const Json* manifold = extension_field(mesh, kManifold)) {
        for (const char* name : {"mergeIndices", "mergeValues"})
          if (const auto accessor = integer_field(*manifold, name)) editor.release(*accessor);
        if (const Json* primitive = object_field(*manifold, "manifoldPrimitive"))
          if (const auto accessor = integer_field(*primitive, "indices")) editor.release(*accessor);
        mesh["extensions"].erase(kManifold);
        if (mesh["extensions"].empty()) mesh.erase("extensions");
        dropped.insert(id.mesh);
      }
      if (dropped.contains(id.mesh))
        reports[id].warnings.push_back(std::string(kManifold) + " is dropped: its data refer to indices");
    }
  if (!dropped.empty()) unlist_unused_extension(document, kManifold);
}

// One run of bytes, and the geometry that it stands for.
struct StoredPart {
  std::span<const uint8_t> bytes;
  const Mesh& mesh;
  const std::vector<uint32_t>& source_point;
};

// A container as the primitive's extension, or each Draco stream as a primitive of its own: `patches` holds
// those of each job, none where it is a container.
void write_geometry(Document& document, const std::vector<Job>& jobs,
                    const std::vector<std::vector<PatchPrimitive>>& patches, bool with_fallback,
                    Reports& reports) {
  std::vector<PrimitiveGroup> groups;
  std::vector<size_t> counts;
  for (size_t i = 0; i < jobs.size(); ++i) {
    groups.push_back(jobs[i].group);
    counts.push_back(std::max<size_t>(1, patches[i].size()));
  }
  const auto repeated = repeat_primitives(document, groups, counts);
  PrimitiveEditor editor(document);
  for (size_t i = 0; i < jobs.size(); ++i) {
    const Job& job = jobs[i];
    const char* extension = job.stored_as == StoredAs::kPatches ? kExtensionName : kStockExtensionName;
    const auto store = [&](const PrimitiveGroup& group, const StoredPart& part) {
      const int64_t view = append_buffer_view(document, part.bytes);
      editor.set_geometry(group, part.mesh, reorder(job.morphs, part.source_point),
                          with_fallback ? GeometryData::kInBufferViews : GeometryData::kStoredElsewhere);
      set_extension(document, group, extension,
                    {{"bufferView", view}, {"attributes", unique_id_map(job.mesh, job.encoded.unique_ids)}});
    };
    if (job.stored_as == StoredAs::kPatches)
      store(repeated[i][0], {job.encoded.container, *job.encoded.decoded, job.encoded.source_point});
    for (size_t k = 0; k < patches[i].size(); ++k)
      store(repeated[i][k], {patches[i][k].stream, patches[i][k].mesh, patches[i][k].source_point});
    list_extension(document, extension, !with_fallback);
  }
  drop_manifolds(document, jobs, editor, reports);
  editor.finish();
}

void choose_storage(Job& job, const EncodeDocumentOptions& options) {
  const EncodeStatistics& statistics = job.encoded.statistics;
  const bool is_whole =
      statistics.patch_count == 1 && statistics.residue_faces == 0 && statistics.residue_points == 0;
  if (options.compat == Compat::kKhr)
    job.stored_as = is_whole ? StoredAs::kDraco : StoredAs::kPatchPrimitives;
  else
    job.stored_as = is_whole && !options.always_patches ? StoredAs::kDraco : StoredAs::kPatches;
  const Expected<Container> container = parse_container(job.encoded.container);
  job.stored_bytes = job.stored_as == StoredAs::kPatches || !container ? job.encoded.container.size()
                                                                       : container->stream_bytes();
}

// glTF wants the bounds of positions. A .drc file does not say them; they are known once it was decoded.
void set_position_bounds(Document& document, const Job& job) {
  const Attribute* position = job.mesh.find("POSITION");
  const PrimitiveId id = job.group.ids.front();
  const auto index = integer_field(primitive_json(document, id)["attributes"], "POSITION");
  if (position == nullptr || !index) return;
  Json& accessor = document.json["accessors"][static_cast<size_t>(*index)];
  if (field(accessor, "min") != nullptr && field(accessor, "max") != nullptr) return;
  const AccessorData data{position->component_type, position->component_count, position->normalized,
                          job.mesh.point_count, position->values};
  describe_decoded(accessor, data, true);
}

// Takes out the geometry that stays as it is, because it cannot be encoded or would only grow, and says why.
// What grows because the user wants patches gets a warning.
Status leave_what_would_grow(Document& document, const EncodeDocumentOptions& options, std::vector<Job>& jobs,
                             Reports& reports) {
  const bool is_wanted = options.always_patches || options.patches > 0 || options.patch_faces > 0;
  const GeometryOwners owners(document);
  std::vector<Job> kept;
  for (Job& job : jobs) {
    if (!job.status.ok() && job.status.code() != StatusCode::kUnsupported)
      return std::move(job.status).at(job.place(document));
    std::string reason = job.status.ok() ? "" : job.status.message(), warning;
    const std::optional<uint64_t> before = owners.bytes_of(job.group);
    if (job.status.ok()) choose_storage(job, options);
    if (job.status.ok() && before && job.stored_bytes >= *before) {
      const std::string sizes =
          std::to_string(job.stored_bytes) + " bytes instead of " + std::to_string(*before);
      const auto kind = primitive_kind(document, job.group.ids.front());
      const PrimitiveStorage storage = kind ? kind->storage : PrimitiveStorage::kPlain;
      const bool with_fallback = options.fallback != Fallback::kNone;
      if (is_wanted || storage == PrimitiveStorage::kPatches || with_fallback) {
        if (!with_fallback && job.stored_bytes > *before) warning = "grows: " + sizes;
      } else {
        reason = storage == PrimitiveStorage::kStockDraco ? "stock Draco that would take " + sizes
                                                          : "Draco would take " + sizes;
      }
    }
    for (const PrimitiveId id : job.group.ids) {
      reports[id].skipped = reason;
      if (!warning.empty()) reports[id].warnings.push_back(warning);
    }
    if (reason.empty())
      kept.push_back(std::move(job));
    else if (document.from_draco)
      set_position_bounds(document, job);
  }
  jobs = std::move(kept);
  return {};
}

}  // namespace

Expected<std::vector<PrimitiveReport>> encode_document(Document& document, const EncodeDocumentOptions& options,
                                                       const DecodeBackend& backend, const ThreadPool& pool,
                                                       const Progress& progress) {
  Expected<Jobs> read = read_jobs(document, options, backend, pool);
  if (!read) return read.status();
  Reports reports(document, *read);
  std::vector<Job>& jobs = read->jobs;
  choose_patch_counts(jobs, options);
  encode_jobs(jobs, pool, progress);
  decode_unverified(jobs, backend, pool);
  if (Status status = leave_what_would_grow(document, options, jobs, reports); !status.ok()) return status;
  if (Status status = report_streams(jobs, reports); !status.ok()) return status;

  std::vector<std::vector<PatchPrimitive>> patches(jobs.size());
  for (size_t i = 0; i < jobs.size(); ++i) {
    if (jobs[i].stored_as == StoredAs::kPatches) continue;
    auto primitives =
        patch_primitives(jobs[i].encoded, requests_of(jobs[i].mesh, jobs[i].encoded.unique_ids), backend, pool);
    if (!primitives) return primitives.status().at(jobs[i].place(document));
    patches[i] = std::move(*primitives);
  }
  write_geometry(document, jobs, patches, options.fallback == Fallback::kUncompressed, reports);
  return std::move(reports).list();
}

Expected<std::vector<PrimitiveReport>> encode_document_stock(Document& document,
                                                             const EncodeDocumentOptions& options,
                                                             const ThreadPool& pool) {
  const DecodeBackend backend = draco_backend();
  Expected<Jobs> read = read_jobs(document, options, backend, pool);
  if (!read) return read.status();
  Reports reports(document, *read);
  std::vector<Job>& jobs = read->jobs;
  std::vector<StockStream> streams(jobs.size());
  std::vector<Mesh> decoded(jobs.size());
  pool.for_each(jobs.size(), [&](size_t i) {
    // Draco does not say which point became which, and morph targets need to know.
    Expected<StockStream> stream =
        encode_stock_stream(jobs[i].mesh, jobs[i].codings, options.encode_speed, !jobs[i].morphs.empty());
    if (!stream) {
      jobs[i].status = stream.status();
      return;
    }
    Expected<Mesh> mesh = backend.decode_stream(stream->bytes, requests_of(jobs[i].mesh, stream->unique_ids));
    if (!mesh) {
      jobs[i].status = mesh.status();
      return;
    }
    if (!jobs[i].morphs.empty() && stream->source_point.size() != mesh->point_count)
      jobs[i].status = runtime_failure("libdraco decodes other points than it should");
    streams[i] = std::move(*stream);
    decoded[i] = std::move(*mesh);
  });

  PrimitiveEditor editor(document);
  for (size_t i = 0; i < jobs.size(); ++i) {
    if (!jobs[i].status.ok()) return std::move(jobs[i].status).at(jobs[i].place(document));
    const int64_t view = append_buffer_view(document, streams[i].bytes);
    editor.set_geometry(jobs[i].group, decoded[i], reorder(jobs[i].morphs, streams[i].source_point),
                        GeometryData::kStoredElsewhere);
    set_extension(document, jobs[i].group, kStockExtensionName,
                  {{"bufferView", view}, {"attributes", unique_id_map(jobs[i].mesh, streams[i].unique_ids)}});
    for (const PrimitiveId id : jobs[i].group.ids) {
      reports[id].stored_as = StoredAs::kDraco;
      reports[id].bytes = streams[i].bytes.size();
    }
  }
  if (!jobs.empty()) list_extension(document, kStockExtensionName, true);
  drop_manifolds(document, jobs, editor, reports);
  editor.finish();
  return std::move(reports).list();
}

Document document_from_mesh(const Mesh& mesh) {
  Document document = new_document();
  Json attributes = Json::object();
  for (const Attribute& attribute : mesh.attributes) {
    const AccessorData data{attribute.component_type, attribute.component_count, attribute.normalized,
                            mesh.point_count, attribute.values};
    attributes[attribute.semantic] = append_accessor(document, data, 34962, attribute.semantic == "POSITION");
  }
  const Json primitive = {{"attributes", attributes}};
  document.json["meshes"] = Json::array({Json{{"primitives", Json::array({primitive})}}});
  PrimitiveEditor(document).set_geometry({{{0, 0}}}, mesh, {}, GeometryData::kInBufferViews, {"indices only"});
  return document;
}

}  // namespace psplit
