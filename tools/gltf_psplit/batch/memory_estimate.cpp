#include "tools/gltf_psplit/batch/memory_estimate.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "gltf_ext/convert/memory_model.h"
#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/json/json.h"
#include "gltf_ext/json/mesh_primitives.h"
#include "mesh_files/asset_format.h"
#include "mesh_files/byte_stream.h"
#include "mesh_files/ply_header.h"
#include "mesh_files/stl.h"
#include "system/files.h"
#include "system/operating_system.h"
#include "tools/gltf_psplit/report/asset_bytes.h"

namespace psplit {
namespace {

// A Draco stream of a whole mesh takes more for each face than arrays do, until it is decoded.
constexpr uint64_t faces_of_draco(uint64_t faces) { return faces + faces / 2; }

// Each pair of positions and indices counts once, however many primitives share it.
AssetCounts counts_of_gltf(const AssetRecords& records) {
  AssetCounts counts;
  std::set<std::pair<int64_t, int64_t>> seen;
  for (const std::vector<PrimitiveRecord>& mesh : records.meshes)
    for (const PrimitiveRecord& primitive : mesh) {
      const int64_t position = primitive.accessor_of("POSITION");
      if (position < 0 || !seen.emplace(position, primitive.indices).second) continue;
      const uint64_t points = records.points_of(primitive), faces = records.faces_of(primitive);
      counts.faces += primitive.stock ? faces_of_draco(faces) : faces;
      for (const AttributeRecord& attribute : primitive.attributes)
        counts.values += points * 4 * records.accessor(attribute.accessor).layout.component_count();
    }
  return counts;
}

// OBJ and STL are read through a table of their points.
constexpr uint64_t kTableBytes = 12, kVectorBytes = 12, kPairBytes = 8;
// Positions of texts are in doubles until their origin is known. Those of an STL are free before its points
// take most memory.
constexpr uint64_t kDoublesBytes = 24;

// The unpacked size of a file. A gzip file ends with it, modulo 2^32.
uint64_t unpacked_bytes(const std::string& path, uint64_t bytes) {
  unsigned char size[4] = {};
  if (lower_extension(path) != ".gz" || bytes < 4) return bytes;
  const OpenFile file(open_file(path, "rb"));
  if (file == nullptr || !seek_to(file.get(), bytes - 4) || std::fread(size, 1, 4, file.get()) != 4)
    return bytes;
  uint64_t low = 0;
  for (size_t i = 4; i-- > 0;) low = low << 8 | size[i];
  return std::max(low, bytes);
}

// The header has the counts. The rest of the file limits them, and tells how many corners the faces have.
AssetCounts counts_of_ply(Scanner& scanner, uint64_t bytes) {
  const Expected<PlyHeader> header = read_ply_header(scanner);
  if (!header) return {};
  const bool is_text = header->encoding == PlyEncoding::kText;
  constexpr uint64_t kLeastText = 2;  // a digit and a space
  AssetCounts counts;
  uint64_t left = bytes - std::min(bytes, scanner.offset());
  for (const PlyElement& element : header->elements) {
    uint64_t stride = 0, index_bytes = 0, numbers = 0;
    for (const PlyProperty& property : element.properties) {
      stride += is_text ? kLeastText : ply_type_bytes(property.is_list ? property.count_type : property.type);
      if (property.is_list) index_bytes = is_text ? kLeastText : ply_type_bytes(property.type);
      numbers += property.is_list ? 0 : 1;
    }
    const uint64_t count = std::min(element.count, left / std::max<uint64_t>(stride, 1));
    left -= count * stride;
    const bool has_doubles = std::ranges::any_of(element.properties, [](const PlyProperty& property) {
      return property.name == "x" && property.type != PlyType::kFloat32;
    });
    if (element.name == "vertex")
      counts.values = count * (4 * std::max<uint64_t>(numbers, 3) + (has_doubles ? kDoublesBytes : 0));
    if (index_bytes == 0) continue;
    // A polygon of n corners becomes n - 2 faces. Text does not tell n: quads are assumed.
    const uint64_t corners = left / index_bytes;
    counts.faces += is_text ? std::min(2 * count, corners) : corners - std::min(corners, 2 * count);
  }
  return counts;
}

// Each corner of a facet may be a point of its own. What these take when they are encoded is more than the
// doubles of a text's positions, which are free by then.
AssetCounts counts_of_stl(Scanner& scanner, uint64_t bytes) {
  constexpr uint64_t kBinaryFacet = 50;
  uint64_t facet_bytes = kBinaryFacet;
  if (!has_size_of_binary_stl(scanner) && is_text_stl(scanner)) {
    const std::string_view head = scanner.peek(Scanner::kMostPeeked);
    uint64_t facets = 1;  // the solid's first line makes up for the last one, which is cut
    for (size_t at = head.find("endfacet"); at != head.npos; at = head.find("endfacet", at + 1)) ++facets;
    facet_bytes = std::max<uint64_t>(head.size() / facets, kBinaryFacet);
  }
  const uint64_t facets = bytes / facet_bytes;
  return {facets, 3 * facets * (2 * kVectorBytes + kTableBytes)};
}

// Reads the counts from the front of a stream: 11 bytes, then for Edgebreaker the kind of traversal, vertices
// and faces, otherwise faces and points. Older streams and streams with metadata begin differently.
AssetCounts counts_of_draco(std::string_view head, uint64_t bytes) {
  constexpr size_t kMethodAt = 8, kFlagsAt = 10, kBodyAt = 11, kMinorAt = 6;
  constexpr uint64_t kAttributes = 2 * kVectorBytes + kPairBytes, kFacesOfByte = 4;
  uint64_t counted[2] = {};
  size_t at = kBodyAt;
  const auto byte = [&](size_t i) { return i < head.size() ? static_cast<unsigned char>(head[i]) : 0u; };
  const bool is_known = byte(kMinorAt) == 2 && byte(kFlagsAt) < 0x80;
  const bool is_edgebreaker = byte(kMethodAt) == 1;
  if (is_edgebreaker) ++at;
  for (uint64_t& number : counted)
    for (int shift = 0; shift < 35; shift += 7) {
      number |= static_cast<uint64_t>(byte(at) & 0x7f) << shift;
      if ((byte(at++) & 0x80) == 0) break;
    }
  const uint64_t faces = is_known ? counted[is_edgebreaker ? 1 : 0] : kFacesOfByte * bytes;
  const uint64_t points = is_known ? counted[is_edgebreaker ? 0 : 1] : faces / 2;
  return {faces_of_draco(faces), points * kAttributes, bytes};
}

// The keyword tells the attributes of a vertex; two counts follow.
AssetCounts counts_of_off(Scanner& scanner, uint64_t bytes) {
  const std::string keyword(scanner.next_word());
  const auto has = [&](std::string_view part) { return keyword.find(part) != keyword.npos; };
  const uint64_t numbers = 3u + (has("N") ? 3u : 0) + (has("C") ? 4u : 0) + (has("ST") ? 2u : 0);
  uint64_t counts[2] = {};
  for (uint64_t& count : counts) {
    std::string_view word = scanner.next_word();
    for (; word.starts_with('#'); word = scanner.next_word()) scanner.skip_rest_of_line();
    count = std::min(static_cast<uint64_t>(std::max<int64_t>(parse_integer(word).value_or(0), 0)), bytes);
  }
  return {2 * counts[1], counts[0] * (4 * numbers + kDoublesBytes)};  // quads are assumed
}

// A sample of the lines of an OBJ.
class ObjLines {
 public:
  // `window` is a part of the file. The lines at its ends may be cut, and are left out.
  void add(std::string_view window) {
    window = window.substr(0, window.rfind('\n') + 1);
    window.remove_prefix(window.find('\n') + 1);
    bytes_ += window.size();
    points_.clear();
    positions_of_corners_.clear();
    while (!window.empty()) {
      const size_t end = window.find('\n');
      add_line(window.substr(0, end));
      window.remove_prefix(end + 1);
    }
    const uint64_t corners = points_.size(), points = count_distinct(points_);
    const uint64_t positions = count_distinct(positions_of_corners_);
    corners_ += corners;
    splits_ += points - std::min(points, positions);
    could_split_ += corners - positions;
  }

  // Estimates the counts of a file of `bytes` bytes from the sample. Assumes that corners of one position are
  // different points as often as in the sample.
  AssetCounts counts(uint64_t bytes) const {
    if (bytes_ == 0) return {};
    const double scale = static_cast<double>(bytes) / static_cast<double>(bytes_);
    const double share =
        could_split_ == 0 ? 0 : static_cast<double>(splits_) / static_cast<double>(could_split_);
    const double more = static_cast<double>(corners_) - static_cast<double>(vectors_);
    const double points = static_cast<double>(vectors_) + share * std::max(more, 0.0);
    const uint64_t values = kVectorBytes + (has_colors_ ? kVectorBytes : 0) +
                            (has_normals_ ? kVectorBytes : 0) + (has_pairs_ ? kPairBytes : 0) + kTableBytes +
                            kDoublesBytes;
    return {static_cast<uint64_t>(scale * static_cast<double>(faces_)),
            static_cast<uint64_t>(scale * points) * values};
  }

 private:
  void add_line(std::string_view line) {
    has_normals_ = has_normals_ || line.starts_with("vn ");
    has_pairs_ = has_pairs_ || line.starts_with("vt ");
    if (line.starts_with("v ")) {
      constexpr auto kBlanksWithColors = 6;
      ++vectors_;
      has_colors_ = has_colors_ || std::ranges::count(line, ' ') >= kBlanksWithColors;
    }
    if (!line.starts_with("f ")) return;
    const size_t before = points_.size();
    for (line.remove_prefix(2); !line.empty();) {
      const size_t end = std::min(line.find(' '), line.size());
      if (const std::string_view corner = line.substr(0, end); !corner.empty() && corner != "\r") {
        points_.push_back(std::hash<std::string_view>()(corner));
        positions_of_corners_.push_back(std::hash<std::string_view>()(corner.substr(0, corner.find('/'))));
      }
      line.remove_prefix(std::min(end + 1, line.size()));
    }
    faces_ += std::max<size_t>(points_.size() - before, 2) - 2;
  }

  static uint64_t count_distinct(std::vector<size_t>& hashes) {
    std::ranges::sort(hashes);
    return static_cast<uint64_t>(std::unique(hashes.begin(), hashes.end()) - hashes.begin());
  }

  uint64_t bytes_ = 0, vectors_ = 0, faces_ = 0, corners_ = 0, splits_ = 0, could_split_ = 0;
  bool has_colors_ = false, has_normals_ = false, has_pairs_ = false;
  std::vector<size_t> points_, positions_of_corners_;  // hashes, of one window
};

// Reads windows at even distances. A packed file can only be read whole.
AssetCounts counts_of_obj(Scanner& scanner, const std::string& path, uint64_t bytes, bool is_packed) {
  constexpr uint64_t kWindow = uint64_t{1} << 14, kWindows = 32, kPackedStep = 4;
  ObjLines lines;
  if (is_packed) {
    uint64_t count = 0, read = 0;
    for (std::string_view window = scanner.peek(kWindow); !window.empty(); window = scanner.peek(kWindow)) {
      if (count++ % kPackedStep == 0) lines.add(window);
      read += window.size();
      scanner.skip(window.size());
    }
    return lines.counts(read);
  }
  const OpenFile file(open_file(path, "rb"));
  if (file == nullptr) return {};
  std::vector<char> window(kWindow);
  const uint64_t windows = std::min(kWindows, bytes / kWindow + 1);
  for (uint64_t i = 0; i < windows; ++i) {
    const uint64_t last = bytes - std::min(bytes, kWindow);
    if (!seek_to(file.get(), windows == 1 ? 0 : i * last / (windows - 1))) break;
    lines.add({window.data(), std::fread(window.data(), 1, kWindow, file.get())});
  }
  return lines.counts(bytes);
}

AssetCounts counts_of_mesh_file(const std::string& path, const std::string& name, uint64_t file_bytes) {
  Expected<std::unique_ptr<ByteStream>> stream = open_byte_stream(path);
  if (!stream) return {};
  std::vector<uint8_t> front(4);
  front.resize((*stream)->read(front));
  const bool is_packed = is_gzip(front);
  Expected<Scanner> opened = open_scanner(join_streams(front, std::move(*stream)));
  if (!opened) return {};
  Scanner& scanner = *opened;
  const uint64_t bytes = is_packed ? unpacked_bytes(path, file_bytes) : file_bytes;
  const std::optional<AssetFormat> format = format_of(scanner, name);
  constexpr size_t kHead = 64;
  if (format == AssetFormat::kPly) return counts_of_ply(scanner, bytes);
  if (format == AssetFormat::kDraco) return counts_of_draco(scanner.peek(kHead), bytes);
  if (format == AssetFormat::kStl) return counts_of_stl(scanner, bytes);
  if (format == AssetFormat::kOff) return counts_of_off(scanner, bytes);
  if (format == AssetFormat::kObj) return counts_of_obj(scanner, path, bytes, is_packed);
  // A packed GLB, for example.
  constexpr uint64_t kFace = 12;
  return {bytes / kFace, bytes, bytes};
}

MemoryUse use_of(BatchVerb verb, bool with_coarse) {
  switch (verb) {
    case BatchVerb::kEncode: return with_coarse ? MemoryUse::kEncodeWithCoarse : MemoryUse::kEncode;
    case BatchVerb::kDecode: return MemoryUse::kDecode;
    case BatchVerb::kValidate: return MemoryUse::kValidate;
    case BatchVerb::kDiff: break;
  }
  return MemoryUse::kDiff;
}

}  // namespace

uint64_t estimate_memory(const std::string& path, BatchVerb verb, const std::string& name, bool with_coarse,
                         uint64_t known_bytes) {
  Expected<Json> json = read_asset_json(path);
  if (json) static_cast<void>(exchange_primitives(*json));  // an error is the reader's to report
  const uint64_t bytes = known_bytes != 0 ? known_bytes : bytes_on_disk(path, json).files;
  const Expected<AssetRecords> records = json ? read_records(*json) : json.status();
  AssetCounts counts;
  if (records)
    counts = counts_of_gltf(*records);
  else if (!json)
    counts = counts_of_mesh_file(path, name.empty() ? path : name, bytes);
  if (json) counts.bytes = bytes;
  return bytes_in_memory(use_of(verb, with_coarse), counts);
}

uint64_t estimate_memory(const Document& document, BatchVerb verb, bool with_coarse) {
  AssetCounts counts = counts_of_gltf(document.records());
  counts.bytes = bytes_on_disk(document).files;
  return bytes_in_memory(use_of(verb, with_coarse), counts);
}

}  // namespace psplit
