#include "tools/gltf_psplit/diff/compared_asset.h"

#include <algorithm>

#include "gltf_ext/convert/decode_to_file.h"
#include "gltf_ext/convert/memory_model.h"
#include "gltf_ext/out_of_core/read_spool.h"
#include "gltf_ext/primitive/view_in_place.h"
#include "mesh_files/asset_format.h"
#include "mesh_files/read_asset.h"
#include "system/files.h"
#include "system/operating_system.h"
#include "tools/gltf_psplit/files/read_input.h"
#include "tools/gltf_psplit/report/progress.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// Decodes patches into a temporary file, unless their attributes or counts need a mesh in memory.
Expected<bool> decode_patches(const Document& document, const MemoryLimit& limit, const ThreadPool& pool,
                              AssetPrimitive& primitive) {
  const Expected<StoredPrimitive> stored = stored_primitive(document, primitive.id);
  if (!stored) return stored.status();
  const Expected<PatchContainer> container = open_container(stored->bytes);
  if (!container) return container.status();
  if (!std::ranges::all_of(stored->requests, is_written_as_stored) || container->face_count() > UINT32_MAX / 3)
    return false;
  const Expected<MeshInFile> mesh = decode_to_file(*container, stored->requests, limit, pool);
  if (!mesh) return mesh.status();
  primitive.owned.push_back(std::make_shared<const FileMemory>(mesh->memory));
  primitive.view = mesh->laid_out.view;
  return true;
}

Expected<bool> view_primitive(const Document& document, const MemoryLimit& limit, const ThreadPool& pool,
                              AssetPrimitive& primitive) {
  if (document.records().primitive(primitive.id).storage() == PrimitiveStorage::kPatches)
    return decode_patches(document, limit, pool, primitive);
  const std::optional<MeshView> in_place = valid_view_in_place(document, primitive.id);
  if (!in_place) return false;
  primitive.view = *in_place;
  return true;
}

// Reads a file or a pipe of any size.
Expected<Asset> open_large(const std::string& path, const BackendChoice& backend, const MemoryLimit& limit,
                           const Session& session, const OriginChoice& origin) {
  Expected<std::unique_ptr<ByteStream>> stream = open_byte_stream(path);
  if (!stream) return stream.status().at({.file = path});
  Expected<Scanner> scanner = open_scanner(std::move(*stream));
  if (!scanner) return scanner.status().at({.file = path});
  const std::optional<AssetFormat> format = format_of(*scanner, path);
  if (format && can_be_spooled(*format) && *format != AssetFormat::kObj) {
    constexpr uint64_t kMostZeroNormals = uint64_t{1} << 20;
    return read_spool(*scanner, *format, path, {limit.folder, kMostZeroNormals, false, origin});
  }
  if (path != "-" && is_disk_file(path))
    return read_input_asset(path, session, backend.name, FileAccess::kMap, {}, {}, PointClouds::kRefuse,
                            origin);
  // A pipe can be read only once: this is the rest of what was looked into.
  const Expected<SpooledBytes> spooled = spool_bytes(*scanner, limit.folder);
  if (!spooled) return spooled.status().at({.file = path});
  return read_asset(spooled->bytes, path, find_describer(backend.name), {}, session.pool, origin);
}

}  // namespace

uint64_t estimate_mesh_bytes(const std::string& path, const MemoryLimit& limit) {
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
    return size / kLeastBytesOfAFace * kComparedFace;
  }
  const Expected<Document> document = read_document(path, FileAccess::kMap);
  if (!document) return 0;
  uint64_t faces = 0;
  for (const PrimitiveId id : all_primitives(*document)) {
    const PrimitiveRecord& primitive = document->records().primitive(id);
    const int64_t counted = primitive.indices >= 0 ? primitive.indices : primitive.accessor_of("POSITION");
    if (counted >= 0) faces += document->records().accessor(counted).count / 3;
  }
  return faces * kComparedFace;
}

Expected<ComparedAsset> read_compared(const std::string& path, const BackendChoice& backend,
                                      const MemoryLimit* limit, const Session& session,
                                      const OriginChoice& origin) {
  ProgressBar bar("reading", session.log);
  Expected<Asset> read = limit != nullptr ? open_large(path, backend, *limit, session, origin)
                                          : read_input_asset(path, session, backend.name, FileAccess::kMap, {},
                                                             {}, PointClouds::kRefuse, origin);
  if (!read) return read.status();
  ComparedAsset asset{std::move(read->document), {}, read->is_mesh_file, std::move(read->warnings), {}};
  asset.origins = mesh_origins(asset.document);
  ViewPrimitive view;
  if (limit != nullptr)
    view = [&](AssetPrimitive& primitive) {
      return view_primitive(asset.document, *limit, session.pool, primitive);
    };
  Expected<AssetMeshes> meshes = read_asset_meshes(
      asset.document, find_backend(backend), find_describer(backend.name), session.pool, bar.callback(), view);
  if (!meshes) return meshes.status().at({.file = path});
  asset.meshes = std::move(*meshes);
  return asset;
}

}  // namespace psplit
