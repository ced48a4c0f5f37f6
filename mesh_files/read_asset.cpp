#include "mesh_files/read_asset.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

#include "gltf_ext/primitive/accessors.h"
#include "mesh_files/draco_file.h"
#include "mesh_files/obj.h"
#include "mesh_files/off.h"
#include "mesh_files/ply.h"
#include "mesh_files/repair_values.h"
#include "mesh_files/stl.h"
#include "src/catch_exceptions.h"
#include "system/files.h"
#include "system/image_type.h"
#include "system/operating_system.h"
#include "system/uri.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

Expected<std::vector<uint8_t>> read_all(Scanner& scanner) {
  std::vector<uint8_t> bytes;
  if (const std::optional<uint64_t> size = scanner.bytes_left()) bytes.reserve(static_cast<size_t>(*size));
  for (std::string_view block = scanner.peek(size_t{1} << 16); !block.empty();
       block = scanner.peek(size_t{1} << 16)) {
    bytes.insert(bytes.end(), block.begin(), block.end());
    scanner.skip(block.size());
  }
  if (Status status = scanner.failure(); !status.ok()) return status;
  return bytes;
}

Expected<Document> read_whole_file(Scanner& scanner, AssetFormat format, const fs::path& source,
                                   const DescribeStream& describe, const DecodePoints& decode_points,
                                   Losses& losses) {
  Expected<std::vector<uint8_t>> bytes = read_all(scanner);
  if (!bytes) return bytes.status();
  return format == AssetFormat::kDraco ? document_from_draco(*bytes, describe, decode_points, &losses)
                                       : parse_document(std::move(*bytes), source);
}

// Reads them in steps.
uint64_t odd_normals_in(const ValuesView& normals) {
  if (normals.component_type != ComponentType::kFloat32 || normals.component_count != 3) return 0;
  constexpr double kUnit = 0.01;  // more than the error of encoders with few bits
  uint64_t count = 0;
  for_each_step(normals, [&](size_t first, size_t end) {
    for (size_t i = first; i < end; ++i) {
      std::array<float, 3> v;
      std::memcpy(v.data(), normals.at(i), sizeof(v));
      const double square = double{v[0]} * v[0] + double{v[1]} * v[1] + double{v[2]} * v[2];
      count += !(std::fabs(std::sqrt(square) - 1) <= kUnit);
    }
    return true;
  });
  return count;
}

// The number of float normals of plain primitives that are not unit vectors. glTF forbids them; they pass
// through unchanged.
uint64_t count_odd_normals(const Document& document) {
  const AssetRecords& records = document.records();
  std::set<int64_t> accessors;
  for (const PrimitiveId id : all_primitives(document))
    if (const int64_t index = records.primitive(id).accessor_of("NORMAL"); index >= 0) accessors.insert(index);
  uint64_t count = 0;
  for (const int64_t index : accessors) {
    if (!records.accessor(index).has_view()) continue;
    if (const Expected<ValuesView> view = accessor_view(document, index)) {
      count += odd_normals_in(*view);
    } else if (const Expected<AccessorData> data = read_accessor(document, index)) {
      count += odd_normals_in(*data);
    }
  }
  return count;
}

Expected<Asset> asset_of(Expected<Document> document, const Losses& losses = {}) {
  if (!document) return document.status();
  std::vector<std::string> warnings = losses.sentences();
  if (const uint64_t count = count_odd_normals(*document); count > 0)
    warnings.push_back(std::to_string(count) + (count == 1 ? " normal is" : " normals are") +
                       " not of unit length, and kept so");
  return Asset{std::move(*document), std::move(warnings)};
}

Expected<Asset> read_mesh_file(Scanner& scanner, AssetFormat format, const fs::path& source, bool takes_points,
                               const ThreadPool& pool, const OriginChoice& origin) {
  std::vector<fs::path> libraries;
  Expected<MeshFile> file = format == AssetFormat::kPly   ? read_ply(scanner, pool)
                            : format == AssetFormat::kStl ? read_stl(scanner, origin)
                            : format == AssetFormat::kOff
                                ? read_off(scanner)
                                : read_obj(scanner, libraries_beside(source, libraries));
  // A failure of the stream is the reason why the rest of the file is missing.
  if (Status status = scanner.failure(); !status.ok()) return status;
  if (!file) return file.status();
  if (format != AssetFormat::kStl) settle_positions(*file, origin);
  repair_values(*file);
  std::vector<std::string> warnings = file->losses.sentences();
  say_heights(*file, source.parent_path(), warnings);
  Expected<Document> document = document_from_mesh_file(std::move(*file), takes_points);
  if (!document) return document.status();
  document->files = std::move(libraries);
  return Asset{std::move(*document), std::move(warnings), true};
}

// Whether the file has the bytes of the asset: it is neither stdin nor packed.
bool is_plain_file(const fs::path& source) {
  if (source == "-" || !is_disk_file(source)) return false;
  const Expected<std::vector<uint8_t>> head = read_file(source, 3);
  return head && !is_gzip(*head);
}

// `mapped`: the bytes of the stream, or null.
Expected<Asset> read_stream(std::unique_ptr<ByteStream> stream, const fs::path& source,
                            const DescribeStream& describe, FileAccess access, const MappedFile* mapped,
                            const DecodePoints& decode_points, const ThreadPool& pool,
                            const OriginChoice& origin) {
  Expected<Scanner> opened = open_scanner(std::move(stream));
  if (!opened) return opened.status();
  Scanner& scanner = *opened;
  const std::optional<AssetFormat> format = format_of(scanner, source);
  if (format == AssetFormat::kGltf && access == FileAccess::kMap && is_plain_file(source))
    return asset_of(read_document(source, access));
  if (format == AssetFormat::kGltf && mapped != nullptr && !is_gzip(mapped->bytes()))
    return asset_of(parse_document(*mapped, source));
  if (format == AssetFormat::kGltf || format == AssetFormat::kDraco) {
    Losses losses;
    Expected<Document> document = read_whole_file(scanner, *format, source, describe, decode_points, losses);
    return asset_of(std::move(document), losses);
  }
  if (format) return read_mesh_file(scanner, *format, source, decode_points != nullptr, pool, origin);
  if (Status status = scanner.failure(); !status.ok()) return status;
  const std::string text = "a format that is not known; these are read: " + asset_extensions_text();
  return unsupported(text);
}

Expected<Asset> read(std::unique_ptr<ByteStream> stream, const fs::path& source, const DescribeStream& describe,
                     FileAccess access, const MappedFile* mapped, const DecodePoints& decode_points,
                     const ThreadPool& pool, const OriginChoice& origin) {
  const Place place{.file = source == "-" ? "stdin" : source.string()};
  Expected<Asset> asset = catch_exceptions([&]() -> Expected<Asset> {
    return read_stream(std::move(stream), source, describe, access, mapped, decode_points, pool, origin);
  });
  if (!asset) return asset.status().at(place);
  asset->document.source = source;
  std::vector<fs::path>& files = asset->document.files;
  if (source != "-" && std::ranges::find(files, source) == files.end()) files.push_back(source);
  return asset;
}

}  // namespace

OpenLibrary libraries_beside(const fs::path& source, std::vector<fs::path>& files) {
  return [&source, &files](const std::string& name) -> Expected<std::unique_ptr<ByteStream>> {
    const auto relative = relative_path_of_uri(uri_of_path(name), source.parent_path());
    if (!relative) return relative.status();
    const fs::path path = source.parent_path() / *relative;
    // Regular files only: a pipe or a device could block or never end.
    if (source == "-" || !is_disk_file(path)) return io_failure("no file " + path.string());
    files.push_back(path);
    return open_byte_stream(path);
  };
}

void say_heights(const MeshFile& file, const fs::path& folder, std::vector<std::string>& warnings) {
  for (const std::string& uri : file.bump_maps) {
    const fs::path path = folder / path_of_uri(uri, folder);
    if (!is_disk_file(path)) continue;
    const auto head = read_file(path, kImageHeadBytes);
    if (head && is_grey_png(*head))
      warnings.push_back("the bump map " + in_quotes(percent_decode(uri)) +
                         " is grey, so it looks like heights; glTF takes it for normals");
  }
}

Expected<Asset> read_asset(std::unique_ptr<ByteStream> stream, const fs::path& source,
                           const DescribeStream& describe, const OriginChoice& origin) {
  return read(std::move(stream), source, describe, FileAccess::kRead, nullptr, {}, ThreadPool(1), origin);
}

Expected<Asset> read_asset(const MappedFile& file, const fs::path& source, const DescribeStream& describe,
                           const DecodePoints& decode_points, const ThreadPool& pool,
                           const OriginChoice& origin) {
  return read(memory_stream(file.bytes()), source, describe, FileAccess::kRead, &file, decode_points, pool,
              origin);
}

Expected<Asset> read_asset(const fs::path& path, const DescribeStream& describe, FileAccess access,
                           const Progress& progress, const DecodePoints& decode_points, const ThreadPool& pool,
                           const OriginChoice& origin) {
  Expected<std::unique_ptr<ByteStream>> stream = open_byte_stream(path, progress);
  if (!stream) return stream.status().at({.file = path == "-" ? "stdin" : path.string()});
  return read(std::move(*stream), path, describe, access, nullptr, decode_points, pool, origin);
}

Expected<SpooledBytes> spool_bytes(Scanner& scanner, const std::filesystem::path& folder) {
  Expected<UnnamedFile> file = UnnamedFile::create(folder);
  if (!file) return file.status();
  uint64_t written = 0;
  for (std::string_view block = scanner.peek(Scanner::kMostPeeked); !block.empty();
       block = scanner.peek(Scanner::kMostPeeked)) {
    Status status = file->write(written, {reinterpret_cast<const uint8_t*>(block.data()), block.size()});
    if (!status.ok()) return status;
    written += block.size();
    scanner.skip(block.size());
  }
  if (Status status = scanner.failure(); !status.ok()) return status;
  Expected<MappedFile> bytes = MappedFile::open(*file);
  if (!bytes) return bytes.status();
  return SpooledBytes{std::move(*file), std::move(*bytes)};
}

}  // namespace psplit
