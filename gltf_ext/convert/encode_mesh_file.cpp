#include "gltf_ext/convert/encode_mesh_file.h"

#include <algorithm>
#include <new>
#include <stdexcept>
#include <utility>

#include "gltf_ext/convert/drop_attributes.h"
#include "gltf_ext/convert/encode_spool.h"
#include "gltf_ext/convert/read_jobs.h"
#include "gltf_ext/convert/store_job.h"
#include "gltf_ext/files/io_error.h"
#include "gltf_ext/mesh_files/mesh_file.h"
#include "gltf_ext/mesh_files/read_asset.h"
#include "gltf_ext/out_of_core/read_spool.h"
#include "gltf_ext/out_of_core/spooled_mesh.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// The document of the mesh without its values, so that its JSON comes from the same code as always.
Document begin_document(const MeshSpool& spool, const ObjHead& head) {
  Mesh mesh;
  mesh.attributes = spool.attributes();
  MeshFile file = head.file;
  if (file.objects.empty()) file.objects.push_back({spool.name(), {}});
  file.objects[0].parts.push_back({std::move(mesh), head.material});
  return document_of_objects(std::move(file));
}

// A texture may read coordinates that are skipped.
Status check_skipped(const MeshSpool& spool, const EncodeDocumentOptions& options, const ObjHead& head) {
  if (spool.skipped_attributes().empty() || head.material < 0) return {};
  Document document = begin_document(spool, head);
  Json& primitive = primitive_json(document, {0, 0});
  for (const std::string& semantic : spool.skipped_attributes()) primitive["attributes"][semantic] = 0;
  return drop_attributes(document, options, all_primitives(document)).status();
}

// The mesh as it is.
Expected<OutOfCoreResult> keep(const MeshSpool& spool, Document document, const fs::path& folder,
                               std::vector<std::string> warnings) {
  const Expected<MeshInFile> mesh = lay_out_spool(spool, folder);
  if (!mesh) return mesh.status();
  PrimitiveEditor editor(document);
  editor.set_geometry_in_file({{{0, 0}}}, *mesh);
  editor.finish();
  PrimitiveReport report;
  report.skipped = kOnlyDegenerate;
  report.dropped_attributes = spool.skipped_attributes();
  report.input_bytes = report.bytes = mesh->memory.bytes().size();
  return OutOfCoreResult{std::move(document), std::move(report), std::move(warnings)};
}

Expected<OutOfCoreResult> encode(Scanner& scanner, AssetFormat format, const fs::path& source,
                                 const EncodeDocumentOptions& options, const OutOfCoreOptions& limits,
                                 const ThreadPool& pool, const Progress& progress) {
  Losses losses;
  SpoolOptions spool_options;
  spool_options.folder = limits.temporary;
  spool_options.coding = options.coding();
  spool_options.skip.insert(options.skip.begin(), options.skip.end());
  spool_options.samples_edges = options.position_bits_by_edges;
  spool_options.keep_duplicates = options.keep_duplicates;
  spool_options.most_zero_normals = MemoryPlan(limits, 0).most_zero_normals;
  std::vector<fs::path> libraries;
  ObjSource obj{libraries_beside(source, libraries)};
  Expected<std::unique_ptr<MeshSpool>> spool = read_spool(
      scanner, format, std::move(spool_options), losses,
      [&](const ExpectedSizes& sizes, bool is_certain) {
        return check_temporary_space(sizes, limits.temporary, limits.note, is_certain);
      },
      &obj);
  if (!spool) return spool.status();
  const MeshSpool& mesh = **spool;
  if (Status status = check_skipped(mesh, options, obj.head); !status.ok()) return status;
  Document document = begin_document(mesh, obj.head);
  document.source = source;
  document.files = std::move(libraries);
  if (source != "-") document.files.push_back(source);
  if (!mesh.has_proper_face() && !options.keep_degenerate)
    return keep(mesh, std::move(document), limits.temporary, losses.sentences());
  Status status = check_space_of_parts(
      {mesh.point_count(), mesh.face_count(), mesh.record_bytes(), mesh.is_soup()}, limits.temporary);
  if (!status.ok()) return status;
  Expected<EncodeJob> job = encode_spool(**spool, options, limits, losses, pool, progress);
  if (!job) return job.status();

  job->group = {{{0, 0}}};
  const size_t count = job->piece_count();
  const auto groups = repeat_primitives(document, {&job->group, 1}, {&count, 1});
  PrimitiveEditor editor(document);
  status = store_job(document, *job, groups[0], options, limits, pool, editor);
  if (!status.ok()) return status;
  editor.finish();
  PrimitiveReport report;
  job->report(report);
  report.faces = job->face_count();
  report.points = job->point_count();
  report.dropped_attributes = mesh.skipped_attributes();
  if (format == AssetFormat::kObj)
    // Equal points of an OBJ are mostly corners that were met again: they are not duplicates of the input.
    report.points -= std::exchange(report.statistics.merged_points, 0);
  const bool has_short_indices =
      index_type(static_cast<uint32_t>(job->point_count())) == ComponentType::kUint16;
  report.input_bytes = report.points * mesh.record_bytes() + report.faces * 3 * (has_short_indices ? 2 : 4);
  std::vector<std::string> warnings = losses.sentences();
  say_heights(obj.head.file, source.parent_path(), warnings);
  return OutOfCoreResult{std::move(document), std::move(report), std::move(warnings)};
}

}  // namespace

Expected<OutOfCoreResult> encode_out_of_core(Scanner& scanner, AssetFormat format, const fs::path& source,
                                             const EncodeDocumentOptions& options,
                                             const OutOfCoreOptions& limits, const ThreadPool& pool,
                                             const Progress& progress) {
  if (std::ranges::find(options.skip, "POSITION") != options.skip.end())
    return Status(StatusCode::kUsage, "POSITION cannot be skipped: a mesh needs positions");
  const Place place{.file = source == "-" ? "stdin" : source.string()};
  try {
    Expected<OutOfCoreResult> result = encode(scanner, format, source, options, limits, pool, progress);
    if (!result) return result.status().at(place);
    return result;
  } catch (const std::bad_alloc&) {
    return may_pass("out of memory", place);
  } catch (const std::length_error&) {
    return runtime_failure("out of memory", place);
  }
}

}  // namespace psplit
