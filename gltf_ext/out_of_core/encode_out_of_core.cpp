#include "gltf_ext/out_of_core/encode_out_of_core.h"

#include <algorithm>
#include <new>
#include <stdexcept>

#include "gltf_ext/convert/drop_attributes.h"
#include "gltf_ext/convert/read_jobs.h"
#include "gltf_ext/files/io_error.h"
#include "gltf_ext/mesh_files/mesh_file.h"
#include "gltf_ext/mesh_files/read_asset.h"
#include "gltf_ext/out_of_core/encode_spool.h"
#include "gltf_ext/out_of_core/read_spool.h"
#include "gltf_ext/out_of_core/spooled_mesh.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// A document with one mesh of small primitives, so that its JSON comes from the same code as always. Their
// geometry is replaced then.
Expected<Document> begin_document(const MeshSpool& spool, const fs::path& source, const ObjHead& head,
                                  std::vector<Mesh> meshes) {
  MeshFile file = head.file;
  if (file.objects.empty()) file.objects.push_back({spool.name(), {}});
  for (Mesh& mesh : meshes) file.objects[0].parts.push_back({std::move(mesh), head.material});
  Expected<Document> document = document_from_mesh_file(std::move(file));
  if (!document) return document;
  document->source = source;
  if (source != "-") document->files.push_back(source);
  return document;
}

// A texture may read coordinates that are skipped.
Status check_skipped(const MeshSpool& spool, const EncodeDocumentOptions& options, const ObjHead& head) {
  if (spool.skipped_attributes().empty() || head.material < 0) return {};
  Mesh small;
  small.point_count = 1;
  small.faces.push_back({0, 0, 0});
  small.attributes.push_back(
      {"POSITION", ComponentType::kFloat32, 3, false, Array<std::byte>(3 * sizeof(float))});
  MeshFile file = head.file;
  file.objects[0].parts.push_back({std::move(small), head.material});
  Expected<Document> document = document_from_mesh_file(std::move(file));
  if (!document) return document.status();
  Json& primitive = primitive_json(*document, {0, 0});
  for (const std::string& semantic : spool.skipped_attributes()) primitive["attributes"][semantic] = 0;
  return drop_attributes(*document, options, all_primitives(*document)).status();
}

// The mesh as it is.
Expected<OutOfCoreResult> keep(const MeshSpool& spool, const fs::path& source, const ObjHead& head,
                               const fs::path& folder, std::vector<std::string> warnings) {
  Mesh small;
  small.point_count = 1;
  small.faces.push_back({0, 0, 0});
  for (const Attribute& attribute : spool.attributes()) {
    small.attributes.push_back(attribute);
    small.attributes.back().values.assign(attribute.stride(), std::byte{0});
  }
  std::vector<Mesh> meshes;
  meshes.push_back(std::move(small));
  Expected<Document> document = begin_document(spool, source, head, std::move(meshes));
  if (!document) return document.status();
  const Expected<SpooledMesh> mesh = lay_out_spool(spool, folder);
  if (!mesh) return mesh.status();
  const size_t buffer = document->buffers.size();
  document->json["buffers"].push_back({{"byteLength", mesh->memory.bytes().size()}});
  document->buffers.push_back(mesh->memory.view());
  PrimitiveEditor editor(*document);
  editor.set_placed_geometry({{{0, 0}}}, {mesh->laid_out.view, buffer, mesh->laid_out.offsets});
  editor.finish();
  PrimitiveReport report;
  report.skipped = kOnlyDegenerate;
  report.dropped_attributes = spool.skipped_attributes();
  report.input_bytes = report.bytes = mesh->memory.bytes().size();
  return OutOfCoreResult{std::move(*document), {report}, std::move(warnings)};
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
  if (!mesh.has_proper_face()) return keep(mesh, source, obj.head, limits.temporary, losses.sentences());
  Status status = check_space_of_parts(
      {mesh.point_count(), mesh.face_count(), mesh.record_bytes(), mesh.is_soup()}, limits.temporary);
  if (!status.ok()) return status;
  Expected<EncodedSpool> encoded = encode_spool(**spool, options, limits, losses, pool, progress);
  if (!encoded) return encoded.status();

  std::vector<PrimitiveGroup> groups;
  std::vector<Mesh> meshes;
  for (const PartsContainer& container : encoded->encoded.containers) {
    groups.push_back({{{0, groups.size()}}});
    meshes.push_back(mesh_of_bounds(container, encoded->attributes));
  }
  Expected<Document> document = begin_document(mesh, source, obj.head, std::move(meshes));
  if (!document) return document.status();
  document->files.insert(document->files.begin(), libraries.begin(), libraries.end());
  status = store_containers(*document, groups, *encoded, limits.temporary);
  if (!status.ok()) return status;
  if (format == AssetFormat::kObj) {
    // Equal points of an OBJ are mostly corners that were met again: they are not duplicates of the input.
    PrimitiveReport& first = encoded->reports.front();
    first.points -= first.statistics.merged_points;
    first.input_bytes -= first.statistics.merged_points * mesh.record_bytes();
    first.statistics.merged_points = 0;
  }
  for (PrimitiveReport& report : encoded->reports) report.dropped_attributes = mesh.skipped_attributes();
  std::vector<std::string> warnings = losses.sentences();
  say_heights(obj.head.file, source.parent_path(), warnings);
  return OutOfCoreResult{std::move(*document), std::move(encoded->reports), std::move(warnings)};
}

}  // namespace

Status check_out_of_core(const EncodeDocumentOptions& options) {
  const auto refuse = [](const std::string& option) {
    return Status(StatusCode::kUsage,
                  option + " does not work with --memory: the mesh is encoded part by part");
  };
  if (std::ranges::find(options.skip, "POSITION") != options.skip.end())
    return {StatusCode::kUsage, "POSITION cannot be skipped: a mesh needs positions"};
  if (options.keep_degenerate) return refuse("--keep-degenerate");
  if (options.keep_unused) return refuse("--keep-unused");
  if (options.keep_duplicates) return refuse("--keep-duplicates");
  if (options.fallback != Fallback::kNone) return refuse("--fallback uncompressed");
  if (options.compat != Compat::kNone) return refuse("--compat khr");
  if (options.condense) return refuse("--condense");
  return {};
}

Expected<OutOfCoreResult> encode_out_of_core(Scanner& scanner, AssetFormat format, const fs::path& source,
                                             const EncodeDocumentOptions& options,
                                             const OutOfCoreOptions& limits, const ThreadPool& pool,
                                             const Progress& progress) {
  if (Status status = check_out_of_core(options); !status.ok()) return status;
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
