// glTF files: what their JSON says about compressed primitives.
#include "bindings/c/mesh.h"
#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/read_steps.h"
#include "gltf_ext/json/glb.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "gltf_ext/json/mesh_primitives.h"

namespace psplit::c {
namespace {

// A file that was read, without the bytes of URIs.
struct GltfFile {
  SourceBytes bytes{};
  AssetRecords records{};
  std::vector<std::optional<std::string>> uris{};  // of the buffers
  std::optional<std::span<const uint8_t>> binary{};
};

}  // namespace
}  // namespace psplit::c

struct psplit_gltf {
  std::shared_ptr<const psplit::c::GltfFile> file{};
  std::vector<std::optional<std::span<const uint8_t>>> buffers{};  // their bytes, if they are known

  const psplit::PrimitiveRecord* find(uint32_t mesh, uint32_t primitive) const {
    const auto& meshes = file->records.meshes;
    return mesh < meshes.size() && primitive < meshes[mesh].size() ? &meshes[mesh][primitive] : nullptr;
  }
};

namespace psplit::c {
namespace {

psplit_kind kind_of(const PrimitiveRecord* primitive) {
  if (primitive == nullptr) return PSPLIT_KIND_NONE;
  switch (primitive->storage()) {
    case PrimitiveStorage::kPlain: break;
    case PrimitiveStorage::kPatches: return PSPLIT_KIND_PATCHES;
    case PrimitiveStorage::kStockDraco: return PSPLIT_KIND_DRACO;
  }
  return PSPLIT_KIND_NONE;
}

Expected<std::unique_ptr<psplit_gltf>> open_gltf(const psplit_gltf_source* from) {
  const Expected<psplit_gltf_source> source = read_struct(from, "psplit_gltf_source");
  if (!source) return source.status();
  if ((source->flags & ~uint32_t{PSPLIT_COPY}) != 0)
    return wrong_usage("a psplit_gltf_source has no flags " + std::to_string(source->flags));
  Expected<SourceBytes> bytes = source_bytes(source->data, source->size, (source->flags & PSPLIT_COPY) != 0);
  if (!bytes) return bytes.status();
  auto file = std::make_shared<GltfFile>();
  file->bytes = std::move(*bytes);
  const std::span<const uint8_t> content(file->bytes.data, file->bytes.size);
  if (!begins_as_gltf(content)) return invalid_input("not glTF: neither a GLB nor JSON");
  std::span<const uint8_t> text = content;
  if (is_glb(content)) {
    const Expected<GlbChunks> chunks = parse_glb(content);
    if (!chunks) return chunks.status();
    text = chunks->json;
    file->binary = chunks->binary;
  }
  Expected<Json> json = parse_json({reinterpret_cast<const char*>(text.data()), text.size()});
  if (!json) return json.status();
  if (Status status = check_members(*json); !status.ok()) return status;
  if (Status status = exchange_primitives(*json); !status.ok()) return status;
  Expected<AssetRecords> records = read_records(*json);
  if (!records) return records.status();
  file->records = std::move(*records);
  for (size_t i = 0; i < array_size(*json, "buffers"); ++i) {
    const std::string* uri = string_field((*json)["buffers"][i], "uri");
    file->uris.push_back(uri == nullptr ? std::nullopt : std::optional(*uri));
  }
  auto gltf = std::make_unique<psplit_gltf>();
  gltf->buffers.resize(file->uris.size());
  // The binary chunk may be longer than the buffer, by its padding.
  if (file->binary && !file->uris.empty() && !file->uris[0]) {
    if (file->binary->size() < file->records.buffers[0].bytes)
      return invalid_input("buffer 0 is longer than the GLB's binary chunk");
    gltf->buffers[0] = file->binary;
  }
  gltf->file = std::move(file);
  return gltf;
}

// The bytes of the extension's buffer view.
Expected<std::span<const uint8_t>> view_bytes(const psplit_gltf& gltf, int64_t index) {
  const ViewRecord& view = gltf.file->records.view(index);
  if (view.meshopt) return unsupported("the extension's buffer view is compressed by meshoptimizer");
  const auto& [buffer, offset, size] = view.range;
  const auto& bytes = gltf.buffers[static_cast<size_t>(buffer)];
  if (!bytes) return wrong_usage("the bytes of buffer " + std::to_string(buffer) + " are not set");
  return bytes->subspan(static_cast<size_t>(offset), static_cast<size_t>(size));
}

Expected<std::unique_ptr<psplit_mesh>> open_record(const psplit_gltf& gltf, const PrimitiveRecord& record) {
  if (!record.status.ok()) return record.status;
  const DracoRecord* const draco = record.draco();
  if (draco == nullptr) return wrong_usage("it has neither of the two extensions");
  if (!draco->status.ok()) return draco->status;
  constexpr int kTriangles = 4, kTriangleStrip = 5;
  const bool is_patches = record.storage() == PrimitiveStorage::kPatches;
  if (record.mode != kTriangles && (is_patches || record.mode != kTriangleStrip))
    return invalid_input("its mode is not that of triangles");
  const AssetRecords& records = gltf.file->records;
  PrimitiveSource source;
  source.compression = is_patches ? Compression::kPatches : Compression::kDraco;
  source.attributes = draco->requests;
  for (const AttributeRequest& request : source.attributes) {
    const uint32_t count = records.accessor(record.accessor_of(request.semantic)).count;
    if (count == 0) return invalid_input("the accessor of " + request.semantic + " is empty");
    if (source.point_count != 0 && count != source.point_count)
      return invalid_input("the accessor of " + request.semantic + " has another count than others");
    source.point_count = count;
  }
  // A strip's accessor may count the strip's indices. Decoding gives lists.
  if (record.indices >= 0 && record.mode == kTriangles)
    source.index_count = records.accessor(record.indices).count;
  const Expected<std::span<const uint8_t>> bytes = view_bytes(gltf, draco->view);
  if (!bytes) return bytes.status();
  source.bytes = *bytes;
  return open_primitive(std::move(source), gltf.file);
}

}  // namespace
}  // namespace psplit::c

using namespace psplit;
using namespace psplit::c;

psplit_code psplit_gltf_open(const psplit_gltf_source* source, psplit_gltf** gltf, psplit_error* error) {
  return make_handle(gltf, error, [&] { return open_gltf(source); });
}
void psplit_gltf_free(psplit_gltf* gltf) { delete gltf; }

uint32_t psplit_gltf_buffer_count(const psplit_gltf* gltf) {
  return gltf == nullptr ? 0 : static_cast<uint32_t>(gltf->buffers.size());
}
const char* psplit_gltf_buffer_uri(const psplit_gltf* gltf, uint32_t buffer) {
  if (buffer >= psplit_gltf_buffer_count(gltf)) return nullptr;
  const std::optional<std::string>& uri = gltf->file->uris[buffer];
  return uri ? uri->c_str() : nullptr;
}
psplit_code psplit_gltf_set_buffer(psplit_gltf* gltf, uint32_t buffer, const void* data, size_t size,
                                   psplit_error* error) {
  return guarded(error, [&]() -> Status {
    if (gltf == nullptr) return null_handle();
    if (buffer >= gltf->buffers.size()) return wrong_usage("there is no buffer " + std::to_string(buffer));
    if (data == nullptr && size > 0) return wrong_usage("the bytes are null");
    const uint64_t stated = gltf->file->records.buffers[buffer].bytes;
    if (size < stated)
      return invalid_input("buffer " + std::to_string(buffer) + " holds " + std::to_string(size) +
                           " bytes of " + std::to_string(stated));
    gltf->buffers[buffer] = std::span(static_cast<const uint8_t*>(data), size);
    return {};
  });
}

uint32_t psplit_gltf_mesh_count(const psplit_gltf* gltf) {
  return gltf == nullptr ? 0 : static_cast<uint32_t>(gltf->file->records.meshes.size());
}
uint32_t psplit_gltf_primitive_count(const psplit_gltf* gltf, uint32_t mesh) {
  return mesh < psplit_gltf_mesh_count(gltf) ? static_cast<uint32_t>(gltf->file->records.meshes[mesh].size())
                                             : 0;
}
psplit_kind psplit_gltf_primitive_kind(const psplit_gltf* gltf, uint32_t mesh, uint32_t primitive) {
  return gltf == nullptr ? PSPLIT_KIND_NONE : kind_of(gltf->find(mesh, primitive));
}

psplit_code psplit_gltf_open_primitive(const psplit_gltf* gltf, uint32_t mesh, uint32_t primitive,
                                       psplit_mesh** result, psplit_error* error) {
  return make_handle(result, error, [&]() -> Expected<std::unique_ptr<psplit_mesh>> {
    if (gltf == nullptr) return null_handle();
    const Place place{.mesh = mesh, .primitive = primitive};
    const PrimitiveRecord* const record = gltf->find(mesh, primitive);
    if (record == nullptr) return wrong_usage("there is no such primitive", place);
    Expected<std::unique_ptr<psplit_mesh>> opened = open_record(*gltf, *record);
    if (!opened) return opened.status().at(place);
    (*opened)->place = place;
    return opened;
  });
}
