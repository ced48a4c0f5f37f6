#include "gltf_ext/document/meshopt_library.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cstring>

#include "gltf_ext/document/meshopt_codec.h"

namespace psplit {

const char* why_meshopt_is_unreadable() { return "is compressed by a newer meshoptimizer"; }

Status check_meshopt_encoder() { return {}; }

// The upper half of the first byte is the codec, the lower half is the version of its bitstream.
bool library_reads(const MeshoptRecord& view, uint8_t header) {
  const int codec = header >> 4, version = header & 15;
  if (view.mode == "ATTRIBUTES") return codec != 0xa || version == 0;
  return codec != (view.mode == "TRIANGLES" ? 0xe : 0xd) || version <= 1;
}

bool library_decode(const MeshoptRecord& view, std::span<const uint8_t> bytes, uint8_t* rows) {
  const uint8_t* from = bytes.data();
  if (view.mode == "TRIANGLES")
    return meshopt_decodeIndexBuffer(rows, view.count, view.stride, from, bytes.size()) == 0;
  if (view.mode == "INDICES")
    return meshopt_decodeIndexSequence(rows, view.count, view.stride, from, bytes.size()) == 0;
  return meshopt_decodeVertexBuffer(rows, view.count, view.stride, from, bytes.size()) == 0;
}

std::vector<uint8_t> library_encode(const MeshoptRecord& view, std::span<const uint8_t> rows) {
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
  return bytes;
}

}  // namespace psplit
