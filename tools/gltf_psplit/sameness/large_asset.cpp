#include "tools/gltf_psplit/sameness/large_asset.h"

#include <algorithm>
#include <cstring>

#include "gltf_ext/convert/decode_to_file.h"
#include "gltf_ext/files/files.h"
#include "gltf_ext/files/operating_system.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/mesh_files/asset_format.h"
#include "gltf_ext/mesh_files/ply.h"
#include "gltf_ext/mesh_files/ply_header.h"
#include "gltf_ext/mesh_files/stl.h"
#include "gltf_ext/out_of_core/mesh_spool.h"
#include "src/container/claims.h"
#include "tools/gltf_psplit/files/read_input.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// The points and faces of a spool in one temporary file: records, then three indices for each face.
Expected<LargePrimitive> primitive_of(const MeshSpool& spool, const fs::path& folder) {
  LargePrimitive primitive;
  const uint64_t record = spool.record_bytes();
  const uint64_t points = spool.point_count(), faces = spool.face_count();
  if (points >= UINT32_MAX || 3 * faces > UINT32_MAX)
    return unsupported("has more points or indices than a comparison can number");
  const uint64_t index_offset = (points * record + 3) / 4 * 4;
  Expected<FileMemory> memory = FileMemory::create(folder, index_offset + faces * sizeof(Face));
  if (!memory) return memory.status();
  primitive.memory = *memory;
  const std::span<uint8_t> bytes = memory->bytes();
  const std::span<uint8_t> index_bytes = bytes.subspan(static_cast<size_t>(index_offset));
  uint8_t* to = bytes.data();
  Status status = spool.for_each_point([&](uint64_t, std::span<const uint8_t> records) -> Status {
    std::memcpy(to, records.data(), records.size());
    release_mapped({to, records.size()});
    to += records.size();
    return {};
  });
  if (!status.ok()) return status;
  size_t written = 0;
  const auto write = [&](const Face& face) {
    std::memcpy(index_bytes.data() + written * sizeof(Face), face.data(), sizeof(Face));
    if (++written % (kReleaseStep / sizeof(Face)) == 0)
      release_mapped(index_bytes.first(written * sizeof(Face)));
  };
  if (spool.is_soup()) {
    for (uint32_t i = 0; i < faces; ++i) write({3 * i, 3 * i + 1, 3 * i + 2});
  } else {
    status = spool.for_each_face([&](std::span<const Face> block) -> Status {
      for (const Face& face : block) write(face);
      return {};
    });
    if (!status.ok()) return status;
  }
  release_mapped(bytes);
  primitive.view.point_count = static_cast<uint32_t>(points);
  size_t offset = 0;
  for (const Attribute& attribute : spool.attributes()) {
    primitive.view.attributes.push_back(
        {attribute.semantic,
         {attribute.component_type, attribute.component_count, attribute.normalized,
          static_cast<uint32_t>(points), std::as_bytes(bytes.subspan(offset)), static_cast<size_t>(record)}});
    offset += attribute.stride();
  }
  primitive.view.indices = {ComponentType::kUint32, 1, false, static_cast<uint32_t>(3 * faces),
                            std::as_bytes(index_bytes)};
  return primitive;
}

Expected<LargeAsset> read_mesh_file(Scanner& scanner, AssetFormat format, const fs::path& folder) {
  Losses losses;
  SpoolOptions options;
  options.folder = folder;
  options.most_zero_normals = uint64_t{1} << 20;
  Expected<std::unique_ptr<MeshSpool>> spool = MeshSpool::create(std::move(options), losses);
  if (!spool) return spool.status();
  Status status;
  if (format == AssetFormat::kPly) {
    skip_byte_order_mark(scanner);
    const Expected<PlyHeader> header = read_ply_header(scanner);
    if (!header) return header.status();
    status = read_ply(scanner, *header, **spool, losses);
  } else {
    status = read_stl(scanner, **spool, losses);
  }
  if (Status failure = scanner.failure(); !failure.ok()) return failure;
  if (status.ok()) status = (*spool)->finish();
  if (!status.ok()) return status;
  Expected<LargePrimitive> primitive = primitive_of(**spool, folder);
  if (!primitive) return primitive.status();
  LargeAsset asset;
  asset.mesh_count = 1;
  asset.primitives.push_back(std::move(*primitive));
  return asset;
}

// The accessors of a primitive as they are, or nothing if they must be read into memory.
std::optional<MeshView> view_in_place(const Document& document, PrimitiveId id) {
  const Json& primitive = document.json["meshes"][id.mesh]["primitives"][id.primitive];
  const Json* attributes = object_field(primitive, "attributes");
  const auto indices = integer_field(primitive, "indices");
  if (attributes == nullptr || !indices || integer_field_or(primitive, "mode", 4) != 4) return std::nullopt;
  MeshView view;
  for (const auto& [semantic, index] : attributes->items()) {
    const Expected<ValuesView> values = accessor_view(document, integer_value(index).value_or(-1));
    if (!values) return std::nullopt;
    view.point_count = values->count;
    view.attributes.push_back({semantic, *values});
  }
  const Expected<ValuesView> values = accessor_view(document, *indices);
  const bool is_same_count = std::ranges::all_of(
      view.attributes, [&](const auto& found) { return found.values.count == view.point_count; });
  if (!values || !is_same_count || values->component_count != 1 || values->value_bytes() > 4 ||
      values->component_type == ComponentType::kFloat32 || values->count % 3 != 0)
    return std::nullopt;
  view.indices = *values;
  return view;
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
  const std::optional<MeshView> in_place =
      kind->storage == PrimitiveStorage::kPlain ? view_in_place(document, id) : std::nullopt;
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
    const Json* accessor =
        top_level_object(document->json, "accessors", integer_field(json, "indices").value_or(-1));
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
  if (format == AssetFormat::kPly || format == AssetFormat::kStl) {
    Expected<LargeAsset> asset = read_mesh_file(*scanner, *format, limit.folder);
    return asset ? std::move(asset) : asset.status().at({.file = path});
  }
  Expected<Document> document = read_input(path, session.log, backend.name);
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
