#include "gltf_ext/document/decode_meshopt.h"

#include <meshoptimizer.h>

#include <set>

#include "gltf_ext/document/drop_unused.h"
#include "gltf_ext/document/extensions.h"
#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

// The codec for attributes stores sixteen zeros in two bits. The other codecs take at least a byte for a
// triangle or an index.
constexpr uint64_t kMostBytesOfAByte = 64;

// The extension of one view.
struct Compressed {
  std::span<const uint8_t> bytes;
  std::string mode, filter;
  size_t stride = 0, count = 0;

  size_t decoded_bytes() const { return stride * count; }
};

Expected<Compressed> parse(const Document& document, const Json& view) {
  const Json& extension = *meshopt_extension(view);
  const auto buffer = integer_field(extension, "buffer"), length = integer_field(extension, "byteLength"),
             stride = integer_field(extension, "byteStride"), count = integer_field(extension, "count");
  const auto offset = integer_field_or(extension, "byteOffset", 0);
  const std::string* mode = string_field(extension, "mode");
  const std::string* filter = string_field(extension, "filter");
  if (!buffer || !length || !offset || !stride || !count || mode == nullptr || *stride < 1 || *stride > 256 ||
      *count < 0 || *count > 0xffffffffLL)
    return invalid_input("has no valid buffer, byteLength, byteStride, count or mode");
  const std::span<const uint8_t> bytes = document.buffers[static_cast<size_t>(*buffer)];
  if (static_cast<uint64_t>(*offset) > bytes.size() ||
      static_cast<uint64_t>(*length) > bytes.size() - static_cast<uint64_t>(*offset))
    return invalid_input("reaches past its buffer");
  Compressed compressed{bytes.subspan(static_cast<size_t>(*offset), static_cast<size_t>(*length)), *mode,
                        filter == nullptr ? "NONE" : *filter, static_cast<size_t>(*stride),
                        static_cast<size_t>(*count)};
  if (compressed.decoded_bytes() > kMostBytesOfAByte * compressed.bytes.size())
    return invalid_input("has more elements than its bytes can hold");
  if (integer_field(view, "byteLength").value_or(0) > static_cast<int64_t>(compressed.decoded_bytes()))
    return invalid_input("has fewer elements than its buffer view");
  return compressed;
}

// The preconditions of meshoptimizer's decoders, some of which it only asserts.
bool is_legal(const Compressed& view) {
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
bool is_newer(const Compressed& view) {
  if (view.filter == "COLOR") return true;
  if (view.bytes.empty()) return false;
  const int codec = view.bytes[0] >> 4, version = view.bytes[0] & 15;
  if (view.mode == "ATTRIBUTES") return codec == 0xa && version > 0;
  return codec == (view.mode == "TRIANGLES" ? 0xe : 0xd) && version > 1;
}

bool decode(const Compressed& view, uint8_t* to) {
  const uint8_t* from = view.bytes.data();
  if (view.mode == "TRIANGLES")
    return meshopt_decodeIndexBuffer(to, view.count, view.stride, from, view.bytes.size()) == 0;
  if (view.mode == "INDICES")
    return meshopt_decodeIndexSequence(to, view.count, view.stride, from, view.bytes.size()) == 0;
  if (meshopt_decodeVertexBuffer(to, view.count, view.stride, from, view.bytes.size()) != 0) return false;
  if (view.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(to, view.count, view.stride);
  if (view.filter == "QUATERNION") meshopt_decodeFilterQuat(to, view.count, view.stride);
  if (view.filter == "EXPONENTIAL") meshopt_decodeFilterExp(to, view.count, view.stride);
  return true;
}

}  // namespace

Status decode_meshopt_views(Document& document) {
  uint64_t compressed_bytes = 0;
  for (const auto& buffer : document.buffers) compressed_bytes += buffer.size();
  std::vector<uint8_t> decoded;
  const size_t target = document.buffers.size();
  bool any = false;
  for (size_t i = 0; i < array_size(document.json, "bufferViews"); ++i) {
    Json& view = document.json["bufferViews"][i];
    if (meshopt_extension(view) == nullptr) continue;
    const std::string name = "buffer view " + std::to_string(i) + ", compressed by meshoptimizer, ";
    const Expected<Compressed> compressed = parse(document, view);
    if (!compressed) return invalid_input(name + compressed.status().message());
    if (is_newer(*compressed)) continue;
    if (!is_legal(*compressed))
      return invalid_input(name + "has an illegal combination of mode, filter and byteStride");
    const size_t start = (decoded.size() + 7) / 8 * 8;
    // Views may share their bytes, but not so often that a small file becomes huge.
    if (start + compressed->decoded_bytes() > kMostBytesOfAByte * compressed_bytes + 8 * (i + 1))
      return invalid_input(name + "shares its bytes with too many other views");
    decoded.resize(start + compressed->decoded_bytes());
    if (!decode(*compressed, decoded.data() + start)) return invalid_input(name + "cannot be decoded");
    view["buffer"] = target;
    view["byteOffset"] = start;
    erase_meshopt_extension(view);
    any = true;
  }
  if (!any) return {};
  document.json["buffers"].push_back({{"byteLength", decoded.size()}});
  document.buffers.push_back(std::move(decoded));
  drop_unused(document, {});
  // An unknown extension may keep a fallback buffer in its place.
  std::set<int64_t> referred;
  for_each_element(document.json, "bufferViews",
                   [&](const Json& view) { referred.insert(integer_field(view, "buffer").value_or(-1)); });
  for (size_t i = 0; i < document.buffers.size(); ++i) {
    Json& buffer = document.json["buffers"][i];
    if (!is_meshopt_fallback(buffer) || referred.contains(static_cast<int64_t>(i))) continue;
    erase_meshopt_extension(buffer);
    if (document.buffers[i].empty()) buffer["byteLength"] = 0;
  }
  for (const char* name : kMeshoptExtensions) unlist_unused_extension(document, name);
  return {};
}

}  // namespace psplit
