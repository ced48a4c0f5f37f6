#include "tools/gltf_psplit/sameness/large_asset.h"

#include <algorithm>

#include "gltf_ext/convert/decode_to_file.h"
#include "gltf_ext/files/files.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/mesh_files/asset_format.h"
#include "gltf_ext/mesh_files/read_asset.h"
#include "gltf_ext/mesh_files/spool_bytes.h"
#include "gltf_ext/out_of_core/read_spool.h"
#include "gltf_ext/out_of_core/spooled_mesh.h"
#include "gltf_ext/primitive/view_in_place.h"
#include "src/container/claims.h"
#include "tools/gltf_psplit/files/read_input.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

Expected<LargeAsset> read_mesh_file(Scanner& scanner, AssetFormat format, const fs::path& folder) {
  Losses losses;
  SpoolOptions options;
  options.folder = folder;
  options.most_zero_normals = uint64_t{1} << 20;
  const Expected<std::unique_ptr<MeshSpool>> spool = read_spool(scanner, format, std::move(options), losses);
  if (!spool) return spool.status();
  const Expected<SpooledMesh> mesh = lay_out_spool(**spool, folder);
  if (!mesh) return mesh.status();
  LargePrimitive primitive;
  primitive.view = mesh->laid_out.view;
  primitive.memory = mesh->memory;
  LargeAsset asset;
  asset.mesh_count = 1;
  asset.primitives.push_back(std::move(primitive));
  return asset;
}

// The rest of a stream that was looked into.
Expected<Document> read_pipe(Scanner& scanner, const std::string& path, const BackendChoice& backend,
                             const fs::path& folder) {
  const Expected<SpooledBytes> spooled = spool_bytes(scanner, folder);
  if (!spooled) return spooled.status().at({.file = path});
  Expected<Asset> asset = read_asset(spooled->bytes, path, find_describer(backend.name));
  if (!asset) return asset.status();
  return std::move(asset->document);
}

Status decode_patches(const Document& document, PrimitiveId id, const MemoryLimit& limit,
                      const ThreadPool& pool, LargePrimitive& primitive) {
  const Expected<StoredPrimitive> stored = stored_primitive(document, id, kExtensionName);
  if (!stored) return stored.status();
  const Expected<PatchContainer> container = open_container(stored->bytes);
  if (!container) return container.status();
  const uint32_t points = container->point_count(), faces = container->face_count();
  if (Status claims = check_results(points, faces, stored->requests, container->bytes.size()); !claims.ok())
    return claims;
  if (!std::ranges::all_of(stored->requests, is_written_as_stored) || faces > UINT32_MAX / 3)
    return unsupported("has attributes or counts that only a comparison in memory can take");
  Expected<FileMemory> memory =
      FileMemory::create(limit.folder, lay_out(stored->requests, points, faces, 0, {}).end);
  if (!memory) return memory.status();
  primitive.memory = *memory;
  const LaidOutMesh mesh = lay_out(stored->requests, points, faces, 0, memory->bytes());
  primitive.view = mesh.view;
  return decode_to_file(*container, stored->requests, mesh, limit, pool, {});
}

Status read_primitive_of(const Document& document, PrimitiveId id, const BackendChoice& backend,
                         const MemoryLimit& limit, const ThreadPool& pool, LargePrimitive& primitive) {
  const Expected<PrimitiveKind> kind = primitive_kind(document, id);
  if (!kind) return kind.status();
  if (!kind->triangles) return unsupported("lines and points are compared only in memory: raise --memory");
  const Json& json = document.json["meshes"][id.mesh]["primitives"][id.primitive];
  if (field(json, "targets") != nullptr)
    return unsupported("morph targets are compared only in memory: raise --memory");
  primitive.mesh = id.mesh;
  primitive.material = integer_field_or(json, "material", -1).value_or(-1);
  const std::optional<MeshView> in_place = view_in_place(document, id);
  if (kind->storage == PrimitiveStorage::kPatches) {
    if (Status status = decode_patches(document, id, limit, pool, primitive); !status.ok()) return status;
  } else if (in_place) {
    primitive.view = *in_place;
  } else {
    Expected<Mesh> mesh = read_primitive(document, id, find_backend(backend), pool);
    if (!mesh) return mesh.status();
    primitive.in_memory = std::make_unique<Mesh>(std::move(*mesh));
    primitive.view = view_of(*primitive.in_memory);
  }
  Expected<std::map<std::string, DeclaredGrid>> grids =
      declared_grids(document, id, find_describer(backend.name), pool);
  if (!grids) return grids.status();
  primitive.grids = std::move(*grids);
  const auto position = std::ranges::find(primitive.view.attributes, "POSITION", &MeshView::Values::semantic);
  if (position == primitive.view.attributes.end() ||
      position->values.component_type != ComponentType::kFloat32 || position->values.component_count != 3)
    return unsupported("positions that are not floats are compared only in memory: raise --memory");
  return {};
}

}  // namespace

uint64_t estimate_mesh_bytes(const std::string& path, const MemoryLimit& limit) {
  constexpr uint64_t kBytesOfAFace = 96;  // a mesh and the tables of the matching
  constexpr uint64_t kMostGrowth = 1024;
  std::error_code error;
  const uint64_t size = path == "-" ? 0 : fs::file_size(path, error);
  if (path == "-" || error || (lower_extension(path) != ".gltf" && limit.allows(size * kMostGrowth))) return 0;
  Expected<std::unique_ptr<ByteStream>> stream = open_byte_stream(path);
  if (!stream) return 0;
  Expected<Scanner> scanner = open_scanner(std::move(*stream));
  if (!scanner) return 0;
  const std::optional<AssetFormat> format = format_of(*scanner, path);
  if (!format) return 0;
  if (format != AssetFormat::kGltf) {
    constexpr uint64_t kLeastBytesOfAFace = 19;  // of a binary PLY: a face and half a point
    return size / kLeastBytesOfAFace * kBytesOfAFace;
  }
  const Expected<Document> document = read_document(path, FileAccess::kMap);
  if (!document) return 0;
  uint64_t faces = 0;
  for (const PrimitiveId id : all_primitives(*document)) {
    const Json& json = document->json["meshes"][id.mesh]["primitives"][id.primitive];
    const Json* attributes = object_field(json, "attributes");
    auto counted = integer_field(json, "indices");
    if (!counted && attributes != nullptr) counted = integer_field(*attributes, "POSITION");
    const Json* accessor = top_level_object(document->json, "accessors", counted.value_or(-1));
    if (accessor != nullptr) faces += static_cast<uint64_t>(integer_field(*accessor, "count").value_or(0)) / 3;
  }
  return faces * kBytesOfAFace;
}

Expected<LargeAsset> read_large_asset(const std::string& path, const BackendChoice& backend,
                                      const MemoryLimit& limit, const Session& session) {
  Expected<std::unique_ptr<ByteStream>> stream = open_byte_stream(path);
  if (!stream) return stream.status().at({.file = path});
  Expected<Scanner> scanner = open_scanner(std::move(*stream));
  if (!scanner) return scanner.status().at({.file = path});
  const std::optional<AssetFormat> format = format_of(*scanner, path);
  if (format && can_be_spooled(*format) && *format != AssetFormat::kObj) {
    Expected<LargeAsset> asset = read_mesh_file(*scanner, *format, limit.folder);
    return asset ? std::move(asset) : asset.status().at({.file = path});
  }
  // A pipe can be read only once.
  std::error_code error;
  const bool is_file = path != "-" && fs::is_regular_file(path, error);
  Expected<Document> document =
      is_file ? read_input(path, session.log, backend.name) : read_pipe(*scanner, path, backend, limit.folder);
  if (!document) return document.status();
  LargeAsset asset;
  asset.document = std::move(*document);
  asset.mesh_count = array_size(asset.document.json, "meshes");
  asset.material_count = array_size(asset.document.json, "materials");
  for (const PrimitiveId id : all_primitives(asset.document)) {
    LargePrimitive& primitive = asset.primitives.emplace_back();
    if (Status status = read_primitive_of(asset.document, id, backend, limit, session.pool, primitive);
        !status.ok())
      return std::move(status).at(
          {path, static_cast<int64_t>(id.mesh), static_cast<int64_t>(id.primitive), -1});
  }
  return asset;
}

}  // namespace psplit
