#include "gltf_ext/mesh_files/read_asset.h"

#include <algorithm>
#include <array>
#include <new>
#include <stdexcept>

#include "gltf_ext/convert/draco_file.h"
#include "gltf_ext/files/files.h"
#include "gltf_ext/files/io_error.h"
#include "gltf_ext/files/uri.h"
#include "gltf_ext/json/glb.h"
#include "gltf_ext/mesh_files/obj.h"
#include "gltf_ext/mesh_files/off.h"
#include "gltf_ext/mesh_files/ply.h"
#include "gltf_ext/mesh_files/stl.h"
#include "gltf_ext/primitive/normal_lengths.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

enum class Format { kGltf, kDraco, kPly, kObj, kStl, kOff };

struct Extension {
  std::string_view text;
  Format format;
};
constexpr std::array<Extension, 7> kExtensions = {{{".gltf", Format::kGltf},
                                                   {".glb", Format::kGltf},
                                                   {".drc", Format::kDraco},
                                                   {".ply", Format::kPly},
                                                   {".obj", Format::kObj},
                                                   {".stl", Format::kStl},
                                                   {".off", Format::kOff}}};

fs::path without_gz(const fs::path& path) {
  return lower_extension(path) == ".gz" ? path.parent_path() / path.stem() : path;
}

std::optional<Format> format_of_name(const fs::path& path) {
  const std::string extension = lower_extension(without_gz(path));
  const auto found = std::ranges::find(kExtensions, extension, &Extension::text);
  return found == kExtensions.end() ? std::nullopt : std::optional(found->format);
}

// The first word of the first line in the window that is not a comment.
std::string_view first_word(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n\v\f";
  for (size_t at = 0; at < text.size();) {
    const size_t begin = text.find_first_not_of(kBlanks, at);
    if (begin == std::string_view::npos) return {};
    if (text[begin] != '#') {
      const size_t end = text.find_first_of(kBlanks, begin);
      return text.substr(begin, std::min(end, text.size()) - begin);
    }
    at = std::min(text.find_first_of("\r\n", begin), text.size());
  }
  return {};
}

bool is_obj_keyword(std::string_view word) {
  constexpr std::array<std::string_view, 11> kKeywords = {"v", "vt", "vn", "vp", "f",     "o",
                                                          "g", "s",  "l",  "p",  "usemtl"};
  return word == "mtllib" || std::ranges::find(kKeywords, word) != kKeywords.end();
}

std::optional<Format> format_of_content(Scanner& scanner) {
  if (has_size_of_binary_stl(scanner)) return Format::kStl;
  std::string_view head = scanner.peek(size_t{1} << 16);
  const std::span<const uint8_t> bytes(reinterpret_cast<const uint8_t*>(head.data()), head.size());
  if (is_glb(bytes)) return Format::kGltf;
  if (is_draco(bytes)) return Format::kDraco;
  if (is_text_stl(scanner)) return Format::kStl;
  head = scanner.peek(size_t{1} << 16);
  if (head.starts_with("ply\n") || head.starts_with("ply\r") || head.starts_with("ply ")) return Format::kPly;
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (head.starts_with(kByteOrderMark)) head.remove_prefix(kByteOrderMark.size());
  const std::string_view word = first_word(head);
  if (word.starts_with('{')) return Format::kGltf;
  if (is_off_keyword(word)) return Format::kOff;
  if (is_obj_keyword(word)) return Format::kObj;
  return std::nullopt;
}

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

Expected<Asset> read_whole_file(Scanner& scanner, Format format, const fs::path& source,
                                const DescribeStream& describe) {
  Expected<std::vector<uint8_t>> bytes = read_all(scanner);
  if (!bytes) return bytes.status();
  Expected<Document> document = format == Format::kDraco ? document_from_draco(*bytes, describe)
                                                         : parse_document(std::move(*bytes), source);
  if (!document) return document.status();
  std::vector<std::string> warnings;
  if (const uint64_t count = count_odd_normals(*document); count > 0)
    warnings.push_back(std::to_string(count) + (count == 1 ? " normal is" : " normals are") +
                       " not of unit length, and kept so");
  return Asset{std::move(*document), std::move(warnings)};
}

// Adds the files that it opens to `files`.
OpenLibrary libraries_beside(const fs::path& source, std::vector<fs::path>& files) {
  return [&source, &files](const std::string& name) -> Expected<std::unique_ptr<ByteStream>> {
    const auto relative = relative_path_of_uri(uri_of_path(name));
    if (!relative) return relative.status();
    const fs::path path = source.parent_path() / *relative;
    // Regular files only: a pipe or a device could block or never end.
    std::error_code error;
    if (source == "-" || !fs::is_regular_file(path, error)) return io_failure("no file " + path.string());
    files.push_back(path);
    return open_byte_stream(path);
  };
}

Expected<Asset> read_mesh_file(Scanner& scanner, Format format, const fs::path& source) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (scanner.peek(kByteOrderMark.size()) == kByteOrderMark && format != Format::kStl)
    scanner.skip(kByteOrderMark.size());
  std::vector<fs::path> libraries;
  Expected<MeshFile> file = format == Format::kPly   ? read_ply(scanner)
                            : format == Format::kStl ? read_stl(scanner)
                            : format == Format::kOff ? read_off(scanner)
                                                     : read_obj(scanner, libraries_beside(source, libraries));
  // A failure of the stream is the reason why the rest of the file is missing.
  if (Status status = scanner.failure(); !status.ok()) return status;
  if (!file) return file.status();
  repair_values(*file);
  std::vector<std::string> warnings = file->losses.sentences();
  Expected<Document> document = document_from_mesh_file(std::move(*file));
  if (!document) return document.status();
  document->files = std::move(libraries);
  return Asset{std::move(*document), std::move(warnings)};
}

Expected<Asset> read_stream(std::unique_ptr<ByteStream> stream, const fs::path& source,
                            const DescribeStream& describe) {
  std::vector<uint8_t> head(3);
  size_t count = 0;
  for (size_t got = 1; got > 0 && count < head.size(); count += got)
    got = stream->read(std::span(head).subspan(count));
  head.resize(count);
  const bool packed = is_gzip(head);
  stream = join_streams(std::move(head), std::move(stream));
  if (packed) stream = unpack_gzip(std::move(stream));

  Scanner scanner(std::move(stream));
  if (scanner.at_end()) return scanner.failure().ok() ? invalid_input("the file is empty") : scanner.failure();
  std::optional<Format> format = format_of_content(scanner);
  if (!format) format = format_of_name(source);
  if (format == Format::kGltf || format == Format::kDraco)
    return read_whole_file(scanner, *format, source, describe);
  if (format) return read_mesh_file(scanner, *format, source);
  if (Status status = scanner.failure(); !status.ok()) return status;
  const std::string text = "no format that is read; " + asset_extensions_text() + " files are";
  return unsupported(text);
}

}  // namespace

Expected<Asset> read_asset(std::unique_ptr<ByteStream> stream, const fs::path& source,
                           const DescribeStream& describe) {
  const Place place{.file = source == "-" ? "stdin" : source.string()};
  try {
    Expected<Asset> asset = read_stream(std::move(stream), source, describe);
    if (!asset) return asset.status().at(place);
    asset->document.source = source;
    std::vector<fs::path>& files = asset->document.files;
    if (source != "-" && std::ranges::find(files, source) == files.end()) files.push_back(source);
    return asset;
  } catch (const std::bad_alloc&) {
    return may_pass("out of memory", place);
  } catch (const std::length_error&) {
    return runtime_failure("out of memory", place);
  }
}

Expected<Asset> read_asset(const fs::path& path, const DescribeStream& describe) {
  Expected<std::unique_ptr<ByteStream>> stream = open_byte_stream(path);
  if (!stream) return stream.status().at({.file = path == "-" ? "stdin" : path.string()});
  return read_asset(std::move(*stream), path, describe);
}

bool is_asset_name(const fs::path& path) { return format_of_name(path).has_value(); }

fs::path without_asset_extensions(const fs::path& path) {
  const fs::path unpacked = is_asset_name(path) ? without_gz(path) : path;
  return unpacked.parent_path() / unpacked.stem();
}

std::string asset_extensions_text() {
  std::string text;
  for (const Extension& extension : kExtensions)
    text += (text.empty() ? "" : ", ") + std::string(extension.text);
  return text;
}

}  // namespace psplit
