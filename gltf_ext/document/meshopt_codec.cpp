#include "gltf_ext/document/meshopt_codec.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace psplit {
namespace {

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

}  // namespace

const char* why_meshopt_is_unreadable() { return "is compressed by a newer meshoptimizer"; }

bool is_legal_meshopt(const MeshoptRecord& view) {
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
bool is_readable_meshopt(const MeshoptRecord& view, std::span<const uint8_t> bytes) {
  if (view.filter == "COLOR") return false;
  if (bytes.empty()) return true;
  const int codec = bytes[0] >> 4, version = bytes[0] & 15;
  if (view.mode == "ATTRIBUTES") return codec != 0xa || version == 0;
  return codec != (view.mode == "TRIANGLES" ? 0xe : 0xd) || version <= 1;
}

bool decode_meshopt_rows(const MeshoptRecord& view, std::span<const uint8_t> bytes, uint8_t* rows) {
  const uint8_t* from = bytes.data();
  if (view.mode == "TRIANGLES")
    return meshopt_decodeIndexBuffer(rows, view.count, view.stride, from, bytes.size()) == 0;
  if (view.mode == "INDICES")
    return meshopt_decodeIndexSequence(rows, view.count, view.stride, from, bytes.size()) == 0;
  return meshopt_decodeVertexBuffer(rows, view.count, view.stride, from, bytes.size()) == 0;
}

void undo_meshopt_filter(const MeshoptRecord& view, uint8_t* rows) {
  if (view.filter == "OCTAHEDRAL" && view.stride == 4) unfilter_directions<int8_t>(rows, view.count);
  if (view.filter == "OCTAHEDRAL" && view.stride == 8) unfilter_directions<int16_t>(rows, view.count);
  if (view.filter == "QUATERNION") unfilter_rotations(rows, view.count);
  if (view.filter == "EXPONENTIAL") meshopt_decodeFilterExp(rows, view.count, view.stride);
}

Status check_meshopt_encoder() { return {}; }

std::vector<uint8_t> encode_meshopt_rows(const MeshoptRecord& view, std::span<const uint8_t> rows) {
  std::vector<uint8_t> bytes;
  const auto take = [&](size_t bound, auto&& encode) {
    bytes.resize(bound);
    bytes.resize(encode(bytes.data(), bytes.size()));
  };
  if (view.mode == "ATTRIBUTES") {
    take(meshopt_encodeVertexBufferBound(view.count, view.stride), [&](uint8_t* to, size_t size) {
#if MESHOPTIMIZER_VERSION >= 230
      return meshopt_encodeVertexBufferLevel(to, size, rows.data(), view.count, view.stride, 2, 0);
#else
      return meshopt_encodeVertexBuffer(to, size, rows.data(), view.count, view.stride);
#endif
    });
  } else {
    std::vector<unsigned int> indices(view.count);
    for (size_t i = 0; i < view.count; ++i)
      std::memcpy(&indices[i], rows.data() + i * view.stride, view.stride);  // little-endian, as glTF
    const size_t points = indices.empty() ? 0 : size_t{std::ranges::max(indices)} + 1;
    const bool is_list = view.mode == "TRIANGLES";
    take(is_list ? meshopt_encodeIndexBufferBound(view.count, points)
                 : meshopt_encodeIndexSequenceBound(view.count, points),
         [&](uint8_t* to, size_t size) {
           return is_list ? meshopt_encodeIndexBuffer(to, size, indices.data(), view.count)
                          : meshopt_encodeIndexSequence(to, size, indices.data(), view.count);
         });
  }
  // Lists of triangles come back with other corners first, where the codec likes these more.
  std::vector<uint8_t> decoded(rows.size());
  const bool is_exact = is_readable_meshopt(view, bytes) && decode_meshopt_rows(view, bytes, decoded.data()) &&
                        std::ranges::equal(decoded, rows);
  return is_exact ? bytes : std::vector<uint8_t>();
}

}  // namespace psplit
