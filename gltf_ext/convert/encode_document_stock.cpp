#include "gltf_ext/convert/encode_document_stock.h"

#include <algorithm>

#include "encoder/draco/draco_backend.h"
#include "encoder/draco/stock_stream.h"
#include "gltf_ext/convert/draco_extension.h"
#include "gltf_ext/convert/drop_manifolds.h"
#include "gltf_ext/convert/encode_reports.h"
#include "gltf_ext/convert/read_jobs.h"
#include "src/container/patch_container.h"

namespace psplit {
namespace {

// What one stream does not hold. Every other face and point of the mesh is in it.
Status count_dropped(const Mesh& mesh, const Mesh& decoded, EncodeStatistics& statistics) {
  std::vector<bool> used(mesh.point_count, false);
  for (const auto& face : mesh.faces) {
    const bool is_dropped = repeats_a_point(face);
    statistics.dropped_faces += is_dropped ? 1 : 0;
    for (const uint32_t point : face)
      if (!is_dropped) used[point] = true;
  }
  statistics.dropped_points = static_cast<uint64_t>(std::ranges::count(used, false));
  if (decoded.faces.size() + statistics.dropped_faces == mesh.faces.size()) return {};
  return runtime_failure("verification: faces: " + std::to_string(decoded.faces.size()) + ", not " +
                         std::to_string(mesh.faces.size() - statistics.dropped_faces));
}

}  // namespace

Expected<std::vector<PrimitiveReport>> encode_document_stock(Document& document,
                                                             const EncodeDocumentOptions& options,
                                                             const ThreadPool& pool) {
  const DecodeBackend backend = draco_backend();
  Expected<EncodeJobs> read = read_jobs(document, options, backend, pool);
  if (!read) return read.status();
  EncodeReports reports(document, *read);
  std::vector<EncodeJob>& jobs = read->jobs;
  std::vector<StockStream> streams(jobs.size());
  std::vector<Mesh> decoded(jobs.size());
  pool.for_each(jobs.size(), [&](size_t i) {
    // Morph targets need the source of each point, which Draco does not state.
    Expected<StockStream> stream =
        encode_stock_stream(jobs[i].mesh, jobs[i].codings, options.encode_speed, !jobs[i].morphs.empty());
    if (!stream) {
      jobs[i].status = stream.status();
      return;
    }
    Expected<Mesh> mesh = backend.decode(open_stream(stream->bytes), stream->requests, ThreadPool(1));
    if (!mesh) {
      jobs[i].status = mesh.status();
      return;
    }
    jobs[i].status = count_dropped(jobs[i].mesh, *mesh, jobs[i].encoded.statistics);
    if (!jobs[i].morphs.empty() && stream->source_point.size() != mesh->point_count)
      jobs[i].status = runtime_failure("libdraco decodes another number of points than expected");
    streams[i] = std::move(*stream);
    decoded[i] = std::move(*mesh);
  });

  PrimitiveEditor editor(document);
  for (size_t i = 0; i < jobs.size(); ++i) {
    if (!jobs[i].status.ok()) return std::move(jobs[i].status).at(jobs[i].place(document));
    const int64_t view = append_buffer_view(document, streams[i].bytes);
    editor.set_geometry(jobs[i].group, decoded[i], reorder(jobs[i].morphs, streams[i].source_point),
                        GeometryData::kStoredElsewhere);
    set_draco_extension(document, jobs[i].group, kStockExtensionName, view, streams[i].requests);
    for (const PrimitiveId id : jobs[i].group.ids) {
      reports[id].stored_as = StoredAs::kDraco;
      reports[id].bytes = streams[i].bytes.size();
      reports[id].statistics = jobs[i].encoded.statistics;
    }
  }
  if (!jobs.empty()) list_extension(document, kStockExtensionName, true);
  drop_manifolds(document, jobs, editor, reports);
  editor.finish();
  return std::move(reports).list();
}

}  // namespace psplit
