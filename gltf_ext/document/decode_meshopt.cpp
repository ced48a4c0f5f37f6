#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
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

// The two filters that round square roots. meshoptimizer estimates their reciprocals, with other results on
// other processors; these are EXT_meshopt_compression's own formulas, whose results are the same everywhere.
template <typename T>
void unfilter_directions(uint8_t* rows, size_t count) {
  for (size_t i = 0; i < count; ++i, rows += 4 * sizeof(T)) {
    T row[4];
    std::memcpy(row, rows, sizeof row);
    // In units of the row's third number, so that all are integers.
    double x = row[0], y = row[1];
    const double z = row[2] - std::fabs(x) - std::fabs(y), below = std::min(z, 0.0);
    x -= std::copysign(below, x);
    y -= std::copysign(below, y);
    const double length = std::sqrt(x * x + y * y + z * z), scale = std::numeric_limits<T>::max();
    const auto rounded = [&](double value) {
      return static_cast<T>(length > 0 ? std::lround(value / length * scale) : 0);
    };
    row[0] = rounded(x), row[1] = rounded(y), row[2] = rounded(z);
    std::memcpy(rows, row, sizeof row);
  }
}

int16_t to_int16(double value) {
  return static_cast<int16_t>(std::clamp(std::lround(value), -0x8000L, 0x7fffL));
}

void unfilter_rotations(uint8_t* rows, size_t count) {
  for (size_t i = 0; i < count; ++i, rows += 4 * sizeof(int16_t)) {
    int16_t row[4];
    std::memcpy(row, rows, sizeof row);
    const int largest = row[3] & 3, one = row[3] | 3;
    const double scale = 32767 * std::sqrt(0.5) / one;
    const double x = row[0], y = row[1], z = row[2];
    const double left = 1 - (x * x + y * y + z * z) / (2.0 * one * one);
    int16_t rotation[4];
    for (int k = 0; k < 3; ++k) rotation[(largest + 1 + k) % 4] = to_int16(row[k] * scale);
    rotation[largest] = to_int16(32767 * std::sqrt(std::max(left, 0.0)));
    std::memcpy(rows, rotation, sizeof rotation);
  }
}

bool decode(const MeshoptRecord& view, std::span<const uint8_t> bytes, uint8_t* to) {
  const uint8_t* from = bytes.data();
  if (view.mode == "TRIANGLES")
    return meshopt_decodeIndexBuffer(to, view.count, view.stride, from, bytes.size()) == 0;
  if (view.mode == "INDICES")
    return meshopt_decodeIndexSequence(to, view.count, view.stride, from, bytes.size()) == 0;
  if (meshopt_decodeVertexBuffer(to, view.count, view.stride, from, bytes.size()) != 0) return false;
  if (view.filter == "OCTAHEDRAL" && view.stride == 4) unfilter_directions<int8_t>(to, view.count);
  if (view.filter == "OCTAHEDRAL" && view.stride == 8) unfilter_directions<int16_t>(to, view.count);
  if (view.filter == "QUATERNION") unfilter_rotations(to, view.count);
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
