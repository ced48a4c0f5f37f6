#include "gltf_ext/convert/encode_document_stock.h"

#include "encoder/stock_stream.h"
#include "gltf_ext/convert/drop_attributes.h"
#include "gltf_ext/convert/encode_reports.h"
#include "gltf_ext/convert/read_jobs.h"
#include "src/cpu/cpu_backend.h"

namespace psplit {

Expected<std::vector<PrimitiveReport>> encode_document_stock(Document& document,
                                                             const EncodeDocumentOptions& options,
                                                             const ThreadPool& pool,
                                                             const StatedGrids& stated) {
  EncodeDocumentOptions unmerged = options;  // Draco keeps equal points apart
  unmerged.keep_duplicates = true;
  Expected<EncodeJobs> read = read_jobs(document, unmerged, cpu_backend(), pool, {}, {}, {}, stated);
  if (!read) return read.status();
  EncodeReports reports(document, *read);
  std::vector<EncodeJob>& jobs = read->jobs;
  std::vector<StockStream> streams(jobs.size());
  pool.for_each(jobs.size(), [&](size_t i) {
    // Draco would drop the same faces and points, but would fit its grids to them.
    const ReducedMesh stored = reduce_job(jobs[i], pool);
    Expected<StockStream> stream = encode_stock_stream(stored.mesh, jobs[i].codings, options.encode_speed,
                                                       options.by_libdraco, options.choose_by_bytes);
    if (!stream) {
      jobs[i].status = stream.status();
      return;
    }
    jobs[i].encoded.statistics.dropped_faces = stored.dropped_faces;
    jobs[i].encoded.statistics.dropped_points = stored.dropped_points;
    const size_t faces = stream->decoded.faces.size();
    if (faces != stored.mesh.faces.size())
      jobs[i].status = runtime_failure("verification: faces: " + std::to_string(faces) + ", not " +
                                       std::to_string(stored.mesh.faces.size()));
    for (uint32_t& point : stream->source_point) point = stored.source_point[point];
    streams[i] = std::move(*stream);
  });

  PrimitiveEditor editor(document);
  for (size_t i = 0; i < jobs.size(); ++i) {
    if (!jobs[i].status.ok()) return std::move(jobs[i].status).at(jobs[i].place(document));
    const int64_t view = append_buffer_view(document, streams[i].bytes);
    editor.set_geometry(jobs[i].group, streams[i].decoded, reorder(jobs[i].morphs, streams[i].source_point),
                        GeometryData::kStoredElsewhere);
    set_draco_extension(document, jobs[i].group, kStockExtensionName, view, streams[i].requests);
    for (const PrimitiveId id : jobs[i].group.ids) {
      reports[id].stored_as = StoredAs::kDraco;
      reports[id].bytes = streams[i].bytes.size();
      reports[id].statistics = jobs[i].encoded.statistics;
      jobs[i].report_precision(reports[id]);
    }
  }
  if (!jobs.empty()) list_extension(document, kStockExtensionName, true);
  drop_manifolds(document, jobs, editor, reports);
  editor.finish();
  return std::move(reports).list();
}

}  // namespace psplit
