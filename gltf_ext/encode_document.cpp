#include <atomic>
#include <map>
#include <set>

#include "encoder/draco/draco_backend.h"
#include "encoder/draco/stock_stream.h"
#include "gltf_ext/convert.h"
#include "gltf_ext/encode_jobs.h"
#include "gltf_ext/json_fields.h"
#include "gltf_ext/patch_primitives.h"

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
  std::atomic<size_t> done = 0;
  pool.for_each(jobs.size(), [&](size_t i) {
    Job& job = jobs[i];
    size_t stride = 0;
    const std::vector<std::byte> extra = distinguishing_bytes(job, stride);
    Expected<EncodedMesh> encoded = encode_mesh(job.mesh, job.codings, job.options, pool, extra, stride);
    if (encoded.ok())
      job.encoded = std::move(*encoded);
    else
      job.status = encoded.status();
    if (progress) progress(++done, jobs.size());
  });
}

// What became of every primitive, in their order.
class Reports {
 public:
  explicit Reports(const Jobs& read) {
    for (const auto& [id, reason] : read.skipped) {
      PrimitiveReport& report = add({id.first, id.second});
      report.skipped = reason;
    }
    for (const Job& job : read.jobs)
      for (const PrimitiveId id : job.group.ids) {
        PrimitiveReport& report = add(id);
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
  PrimitiveReport& add(PrimitiveId id) {
    PrimitiveReport& report = reports_[{id.mesh, id.primitive}];
    report.id = id;
    return report;
  }

  std::map<std::pair<size_t, size_t>, PrimitiveReport> reports_;
};

Status report_containers(const std::vector<Job>& jobs, Compat compat, Reports& reports) {
  for (const Job& job : jobs) {
    Expected<Container> container = parse_container(job.encoded.container);
    if (!container) return container.status();
    if (compat == Compat::kKhr)
      for (StreamEntry& entry : container->entries) entry.stitch_bytes = 0;
    for (const PrimitiveId id : job.group.ids) {
      PrimitiveReport& report = reports[id];
      report.bytes = compat == Compat::kKhr ? container->stream_bytes() : job.encoded.container.size();
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

// Each geometry as one container in PSPLIT_mesh_draco_patches.
void write_patches(Document& document, std::vector<Job>& jobs, GeometryData data, PrimitiveEditor& editor) {
  for (Job& job : jobs) {
    const int64_t view = append_buffer_view(document, job.encoded.container);
    const Json extension = {{"bufferView", view},
                            {"attributes", unique_id_map(job.mesh, job.encoded.unique_ids)}};
    editor.set_geometry(job.group, *job.encoded.decoded, reorder(job.morphs, job.encoded.source_point), data);
    set_extension(document, job.group, kExtensionName, extension);
  }
}

// Each patch as a primitive of its own in KHR_draco_mesh_compression.
void write_patch_primitives(Document& document, std::vector<Job>& jobs,
                            const std::vector<std::vector<PatchPrimitive>>& patches, GeometryData data,
                            Reports& reports) {
  std::vector<PrimitiveGroup> groups;
  std::vector<size_t> counts;
  for (size_t i = 0; i < jobs.size(); ++i) {
    groups.push_back(jobs[i].group);
    counts.push_back(patches[i].size());
  }
  const auto repeated = repeat_primitives(document, groups, counts);
  PrimitiveEditor editor(document);
  for (size_t i = 0; i < jobs.size(); ++i)
    for (size_t k = 0; k < patches[i].size(); ++k) {
      const PatchPrimitive& patch = patches[i][k];
      const int64_t view = append_buffer_view(document, patch.stream);
      editor.set_geometry(repeated[i][k], patch.mesh, reorder(jobs[i].morphs, patch.source_point), data);
      set_extension(
          document, repeated[i][k], kStockExtensionName,
          {{"bufferView", view}, {"attributes", unique_id_map(jobs[i].mesh, jobs[i].encoded.unique_ids)}});
    }
  drop_manifolds(document, jobs, editor, reports);
  editor.finish();
}

}  // namespace

Expected<std::vector<PrimitiveReport>> encode_document(Document& document, const EncodeDocumentOptions& options,
                                                       const DecodeBackend& backend, const ThreadPool& pool,
                                                       const Progress& progress) {
  Expected<Jobs> read = read_jobs(document, options, backend, pool);
  if (!read) return read.status();
  Reports reports(*read);
  std::vector<Job>& jobs = read->jobs;
  // A patch of its own has no place for points that nothing uses.
  std::vector<uint32_t> unused(jobs.size(), 0);
  if (options.compat == Compat::kKhr)
    for (size_t i = 0; i < jobs.size(); ++i) unused[i] = drop_unused_points(jobs[i]);
  choose_patch_counts(jobs, options);
  encode_jobs(jobs, pool, progress);
  decode_unverified(jobs, backend, pool);
  for (size_t i = 0; i < jobs.size(); ++i) {
    if (!jobs[i].status.ok()) return std::move(jobs[i].status).at(jobs[i].place(document));
    jobs[i].encoded.statistics.dropped_points += unused[i];
  }
  if (Status status = report_containers(jobs, options.compat, reports); !status.ok()) return status;

  const bool with_fallback = options.fallback == Fallback::kUncompressed;
  const GeometryData data = with_fallback ? GeometryData::kInBufferViews : GeometryData::kStoredElsewhere;
  if (options.compat == Compat::kKhr) {
    std::vector<std::vector<PatchPrimitive>> patches;
    for (const Job& job : jobs) {
      auto primitives =
          patch_primitives(job.encoded, requests_of(job.mesh, job.encoded.unique_ids), backend, pool);
      if (!primitives) return primitives.status().at(job.place(document));
      patches.push_back(std::move(*primitives));
    }
    write_patch_primitives(document, jobs, patches, data, reports);
    if (!jobs.empty()) list_extension(document, kStockExtensionName, !with_fallback);
  } else {
    PrimitiveEditor editor(document);
    write_patches(document, jobs, data, editor);
    if (!jobs.empty()) list_extension(document, kExtensionName, !with_fallback);
    drop_manifolds(document, jobs, editor, reports);
    editor.finish();
  }
  return std::move(reports).list();
}

Expected<std::vector<PrimitiveReport>> encode_document_stock(Document& document,
                                                             const EncodeDocumentOptions& options,
                                                             const ThreadPool& pool) {
  const DecodeBackend backend = draco_backend();
  Expected<Jobs> read = read_jobs(document, options, backend, pool);
  if (!read) return read.status();
  Reports reports(*read);
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
    for (const PrimitiveId id : jobs[i].group.ids) reports[id].bytes = streams[i].bytes.size();
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
