#include "gltf_ext/convert/store_job.h"

#include <algorithm>
#include <filesystem>
#include <utility>
#include <vector>

#include "encoder/spill.h"
#include "gltf_ext/convert/decode_to_file.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/out_of_core/file_blocks.h"
#include "gltf_ext/primitive/accessors.h"
#include "psplit/decode.h"
#include "src/container/patch_container.h"

namespace psplit {
namespace {

const char* extension_of(const EncodeJob& job) {
  return job.stored_as == StoredAs::kPatches ? kExtensionName : kStockExtensionName;
}

// The bytes of a container as a buffer of their own. Returns the buffer view.
Expected<int64_t> add_container(Document& document, StoredBytes& bytes, const std::filesystem::path& folder) {
  Expected<AppendFile> file = AppendFile::create(folder);
  if (!file) return file.status();
  constexpr uint64_t kWindow = uint64_t{4} << 20;
  std::vector<uint8_t> window;
  for (uint64_t at = 0; at < bytes.size(); at += window.size()) {
    window.resize(static_cast<size_t>(std::min(kWindow, bytes.size() - at)));
    if (Status status = bytes.read(at, window); !status.ok()) return status;
    if (Status status = file->append(window); !status.ok()) return status;
  }
  Expected<MappedFile> mapped = file->map();
  if (!mapped) return mapped.status();
  const size_t buffer = append_buffer(document, buffer_of(*mapped));
  Json& views = document.json()["bufferViews"];
  views.push_back({{"buffer", buffer}, {"byteOffset", 0}, {"byteLength", bytes.size()}});
  return static_cast<int64_t>(views.size()) - 1;
}

// The accessors describe a mesh whose values are stored elsewhere.
void describe(const PrimitiveGroup& group, const EncodedPiece& container, std::span<const Attribute> attributes,
              PrimitiveEditor& editor) {
  MeshView mesh;
  mesh.point_count = container.point_count;
  mesh.indices = {index_type(mesh.point_count), 1, false, container.face_count * 3, {}, 0};
  std::vector<PrimitiveEditor::Bounds> bounds;
  for (size_t k = 0; k < attributes.size(); ++k) {
    const Attribute& a = attributes[k];
    mesh.attributes.push_back(
        {a.semantic, {a.component_type, a.component_count, a.normalized, mesh.point_count, {}, 0}});
    bounds.push_back({bound_json(container.bounds[k].least, a.component_type),
                      bound_json(container.bounds[k].most, a.component_type)});
  }
  bounds.push_back({Json::array({0}), Json::array({container.used_point_count - 1})});
  editor.describe_geometry(group, mesh, bounds);
}

// The mesh that the container or the lone stream decodes to.
Expected<MeshInFile> decode_fallback(std::span<const uint8_t> bytes, const EncodedPiece& container,
                                     std::span<const AttributeRequest> requests, bool is_alone,
                                     const OutOfCoreOptions& limits, const ThreadPool& pool) {
  if (!is_alone) {
    const Expected<PatchContainer> opened = open_container(bytes);
    if (!opened) return opened.status();
    return decode_to_file(*opened, requests, {limits.memory, limits.temporary}, pool);
  }
  Expected<MeshInFile> mesh =
      lay_out_in_file(requests, container.point_count, container.face_count, limits.temporary);
  if (!mesh) return mesh;
  const PatchContainer stream = open_stream(bytes, container.point_count);
  const DecodeTask task{&stream, requests};
  const auto buffers = [&](size_t, uint32_t, uint32_t) {
    return Expected<PrimitiveBuffers>(mesh->laid_out.buffers);
  };
  Status status = cpu_backend().decode_into({&task, 1}, buffers, pool, {}).front();
  if (!status.ok()) return status;
  return mesh;
}

// Stores the pieces of a job that is in memory.
void store_in_memory(Document& document, const EncodeJob& job, std::span<const PrimitiveGroup> groups,
                     const char* extension, GeometryData data, PrimitiveEditor& editor) {
  for (size_t k = 0; k < groups.size(); ++k) {
    const EncodedPiece& piece = job.encoded.pieces[k];
    const int64_t view = append_buffer_view(document, piece.bytes);
    editor.set_geometry(groups[k], piece.decoded, reorder(job.morphs, piece.source_point), data);
    set_draco_extension(document, groups[k], extension, view, job.encoded.requests);
  }
}

Status store_parts(Document& document, EncodeJob& job, std::span<const PrimitiveGroup> groups,
                   const char* extension, bool with_fallback, const OutOfCoreOptions& limits,
                   const ThreadPool& pool, PrimitiveEditor& editor) {
  const std::vector<AttributeRequest>& requests = job.encoded.requests;
  for (size_t k = 0; k < groups.size(); ++k) {
    EncodedPiece& container = job.encoded.pieces[k];
    const Expected<int64_t> view = add_container(document, *container.stored, limits.temporary);
    if (!view) return view.status();
    container.stored.reset();
    if (with_fallback) {
      const Expected<MeshInFile> mesh = decode_fallback(document.buffers.back(), container, requests,
                                                        job.stored_as != StoredAs::kPatches, limits, pool);
      if (!mesh) return mesh.status();
      editor.set_geometry_in_file(groups[k], *mesh);
    } else {
      describe(groups[k], container, job.source.mesh.attributes, editor);
    }
    set_draco_extension(document, groups[k], extension, *view, requests);
  }
  return {};
}

}  // namespace

Status store_job(Document& document, EncodeJob& job, std::span<const PrimitiveGroup> groups,
                 const EncodeDocumentOptions& options, const OutOfCoreOptions& limits, const ThreadPool& pool,
                 PrimitiveEditor& editor) {
  const char* const extension = extension_of(job);
  const bool with_fallback = options.fallback == Fallback::kUncompressed;
  if (job.is_in_parts())
    return store_parts(document, job, groups, extension, with_fallback, limits, pool, editor);
  store_in_memory(document, job, groups, extension,
                  with_fallback ? GeometryData::kInBufferViews : GeometryData::kStoredElsewhere, editor);
  return {};
}

void list_stored(Document& document, std::span<const EncodeJob> jobs,
                 std::span<const std::vector<PrimitiveGroup>> groups) {
  std::vector<bool> is_required;
  for (const std::vector<PrimitiveGroup>& of_job : groups)
    is_required.push_back(std::ranges::any_of(
        of_job, [&](const PrimitiveGroup& group) { return !all_have_fallbacks(document, group.ids); }));
  for (size_t i = 0; i < jobs.size(); ++i) list_extension(document, extension_of(jobs[i]), is_required[i]);
}

}  // namespace psplit
