#include "gltf_ext/json/glb.h"

#include <algorithm>
#include <limits>

namespace psplit {
namespace {

constexpr uint32_t kMagic = 0x46546C67;   // "glTF"
constexpr uint32_t kJson = 0x4E4F534A;    // "JSON"
constexpr uint32_t kBinary = 0x004E4942;  // "BIN"
constexpr size_t kHeaderBytes = 12;
constexpr size_t kChunkHeaderBytes = 8;

uint32_t read_u32(std::span<const uint8_t> bytes, size_t at) {
  return uint32_t{bytes[at]} | uint32_t{bytes[at + 1]} << 8 | uint32_t{bytes[at + 2]} << 16 |
         uint32_t{bytes[at + 3]} << 24;
}

void append_u32(std::vector<uint8_t>& bytes, uint64_t value) {
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<uint8_t>(value >> shift & 0xff));
}

}  // namespace

bool is_glb(std::span<const uint8_t> file) { return file.size() >= 4 && read_u32(file, 0) == kMagic; }

bool begins_as_gltf(std::span<const uint8_t> file) {
  // Before the brace there may be a byte order mark and blanks.
  const auto first =
      std::find_if(file.begin(), file.end(), [](uint8_t byte) { return byte > ' ' && byte < 0x80; });
  return is_glb(file) || (first != file.end() && *first == '{');
}

Expected<GlbChunks> parse_glb(std::span<const uint8_t> file) {
  if (!is_glb(file)) return invalid_input("not a GLB file");
  if (file.size() < kHeaderBytes) return invalid_input("the GLB header ends early");
  const uint32_t version = read_u32(file, 4);
  if (version != 2) return unsupported("GLB version " + std::to_string(version) + "; only 2 is supported");
  const uint32_t length = read_u32(file, 8);
  if (length < kHeaderBytes) return invalid_input("the GLB header states an impossible length");
  if (length > file.size()) {
    return invalid_input("the GLB states " + std::to_string(length) + " bytes, but holds " +
                         std::to_string(file.size()));
  }
  file = file.first(length);

  GlbChunks chunks;
  size_t number = 0;
  for (size_t at = kHeaderBytes; at < file.size();) {
    if (file.size() - at < kChunkHeaderBytes) return invalid_input("a GLB chunk header ends early");
    const uint32_t chunk_bytes = read_u32(file, at);
    const uint32_t type = read_u32(file, at + 4);
    at += kChunkHeaderBytes;
    if (chunk_bytes > file.size() - at) return invalid_input("a GLB chunk reaches past the end of the file");
    const auto content = file.subspan(at, chunk_bytes);
    if (number == 0 && type != kJson) return invalid_input("the first GLB chunk is not JSON");
    if (number == 0) chunks.json = content;
    if (number > 0 && type == kJson) return invalid_input("the GLB holds two JSON chunks");
    if (type == kBinary) {
      if (chunks.binary) return invalid_input("the GLB holds two binary chunks");
      if (number != 1) return invalid_input("the GLB's binary chunk is not its second chunk");
      chunks.binary = content;
    }
    ++number;
    at += chunk_bytes;
    if (chunk_bytes % 4 != 0) return invalid_input("a GLB chunk's length is not a multiple of 4");
  }
  if (number == 0) return invalid_input("the GLB holds no JSON chunk");
  return chunks;
}

Status check_glb_bytes(uint64_t bytes, bool is_least) {
  if (bytes <= std::numeric_limits<uint32_t>::max()) return {};
  return unsupported("a GLB holds at most 4 GB, but this one takes " +
                     std::string(is_least ? "at least " : "") + std::to_string(bytes) +
                     " bytes; write a .gltf");
}

Expected<std::vector<uint8_t>> glb_head(std::string json, uint64_t binary_bytes) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const uint64_t binary_chunk = binary_bytes == 0 ? 0 : kChunkHeaderBytes + binary_bytes;
  const uint64_t total = kHeaderBytes + kChunkHeaderBytes + json.size() + binary_chunk;
  if (Status status = check_glb_bytes(total); !status.ok()) return status;
  std::vector<uint8_t> head;
  head.reserve(kHeaderBytes + 2 * kChunkHeaderBytes + json.size());
  append_u32(head, kMagic);
  append_u32(head, 2);
  append_u32(head, total);
  append_u32(head, json.size());
  append_u32(head, kJson);
  head.insert(head.end(), json.begin(), json.end());
  if (binary_bytes != 0) {
    append_u32(head, binary_bytes);
    append_u32(head, kBinary);
  }
  return head;
}

}  // namespace psplit
