#include <meshoptimizer.h>

#include <set>

#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/drop_unused.h"
#include "gltf_ext/document/extensions.h"
#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/document/read_steps.h"

namespace psplit {
namespace {

// The codec for attributes stores sixteen zeros in two bits. The other codecs take at least a byte for a
// triangle or an index.
constexpr uint64_t kMostBytesOfAByte = 64;

// The compressed bytes of one view.
Expected<std::span<const uint8_t>> compressed_bytes(const Document& document, const ViewRecord& view) {
  const auto& [buffer, offset, length] = view.meshopt->range;
  const std::span<const uint8_t> bytes = document.buffers[static_cast<size_t>(buffer)];
  if (offset > bytes.size() || length > bytes.size() - offset) return invalid_input("reaches past its buffer");
  const size_t decoded = view.meshopt->decoded_bytes();
  if (decoded > kMostBytesOfAByte * length) return invalid_input("has more elements than its bytes can hold");
  if (view.range.bytes > decoded) return invalid_input("has fewer elements than its buffer view");
  return bytes.subspan(static_cast<size_t>(offset), static_cast<size_t>(length));
}

// The preconditions of meshoptimizer's decoders, some of which it only asserts.
bool is_legal(const MeshoptRecord& view) {
  const size_t stride = view.stride;
  if (view.mode != "ATTRIBUTES") {
    const bool whole = view.mode == "INDICES" || (view.mode == "TRIANGLES" && view.count % 3 == 0);
    return whole && (stride == 2 || stride == 4) && view.filter == "NONE";
  }
  if (stride % 4 != 0) return false;
  if (view.filter == "OCTAHEDRAL") return stride == 4 || stride == 8;
  if (view.filter == "QUATERNION") return stride == 8;
  return view.filter == "NONE" || view.filter == "EXPONENTIAL";
}

// The upper half of the first byte is the codec, the lower half is the version of its bitstream.
bool is_newer(const MeshoptRecord& view, std::span<const uint8_t> bytes) {
  if (view.filter == "COLOR") return true;
  if (bytes.empty()) return false;
  const int codec = bytes[0] >> 4, version = bytes[0] & 15;
  if (view.mode == "ATTRIBUTES") return codec == 0xa && version > 0;
  return codec == (view.mode == "TRIANGLES" ? 0xe : 0xd) && version > 1;
}

bool decode(const MeshoptRecord& view, std::span<const uint8_t> bytes, uint8_t* to) {
  const uint8_t* from = bytes.data();
  if (view.mode == "TRIANGLES")
    return meshopt_decodeIndexBuffer(to, view.count, view.stride, from, bytes.size()) == 0;
  if (view.mode == "INDICES")
    return meshopt_decodeIndexSequence(to, view.count, view.stride, from, bytes.size()) == 0;
  if (meshopt_decodeVertexBuffer(to, view.count, view.stride, from, bytes.size()) != 0) return false;
  if (view.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(to, view.count, view.stride);
  if (view.filter == "QUATERNION") meshopt_decodeFilterQuat(to, view.count, view.stride);
  if (view.filter == "EXPONENTIAL") meshopt_decodeFilterExp(to, view.count, view.stride);
  return true;
}

}  // namespace

Status decode_meshopt_views(Document& document) {
  uint64_t all_bytes = 0;
  for (const auto& buffer : document.buffers) all_bytes += buffer.size();
  std::vector<uint8_t> decoded;
  const size_t target = document.buffers.size();
  bool any = false;
  const std::vector<ViewRecord> views = document.records().views;
  for (size_t i = 0; i < views.size(); ++i) {
    if (!views[i].meshopt) continue;
    const MeshoptRecord& compressed = *views[i].meshopt;
    const std::string name = "buffer view " + std::to_string(i) + ", compressed by meshoptimizer, ";
    const Expected<std::span<const uint8_t>> bytes = compressed_bytes(document, views[i]);
    if (!bytes) return invalid_input(name + bytes.status().message());
    if (is_newer(compressed, *bytes)) continue;
    if (!is_legal(compressed))
      return invalid_input(name + "has an illegal combination of mode, filter and byteStride");
    const size_t start = (decoded.size() + 7) / 8 * 8;
    // Views may share their bytes, but not so often that a small file becomes huge.
    if (start + compressed.decoded_bytes() > kMostBytesOfAByte * all_bytes + 8 * (i + 1))
      return invalid_input(name + "shares its bytes with too many other views");
    decoded.resize(start + compressed.decoded_bytes());
    if (!decode(compressed, *bytes, decoded.data() + start)) return invalid_input(name + "cannot be decoded");
    Json& view = document.json()["bufferViews"][i];
    view["buffer"] = target;
    view["byteOffset"] = start;
    erase_meshopt_extension(view);
    any = true;
  }
  if (!any) return {};
  append_buffer(document, std::move(decoded));
  drop_unused(document, {});
  // An unknown extension may keep a fallback buffer in its place.
  const AssetRecords records = document.records();
  std::set<int64_t> referred;
  for (const ViewRecord& view : records.views) referred.insert(view.range.buffer);
  for (size_t i = 0; i < document.buffers.size(); ++i) {
    if (!records.buffers[i].is_fallback || referred.contains(static_cast<int64_t>(i))) continue;
    Json& buffer = document.json()["buffers"][i];
    erase_meshopt_extension(buffer);
    if (document.buffers[i].empty()) buffer["byteLength"] = 0;
  }
  for (const char* name : kMeshoptExtensions) unlist_unused_extension(document, name);
  return {};
}

}  // namespace psplit
