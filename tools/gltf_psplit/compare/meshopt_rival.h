// The rival from the GPU side: meshoptimizer's index and vertex codecs, alone and with zstd on top, as gltfpack
// packs them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "src/mesh/mesh.h"
#include "src/status.h"

namespace psplit {

struct MeshoptBits {
  int position = 14;
  int texcoord = 12;
  bool lossless = false;  // every attribute as it is
};

// One attribute as meshoptimizer's codec sees it.
struct MeshoptStream {
  size_t stride = 0;        // a multiple of 4
  bool octahedral = false;  // unit vectors, as 8-bit octahedral coordinates
  size_t encoded_bytes = 0;
};

struct MeshoptMesh {
  size_t index_count = 0;
  size_t point_count = 0;
  size_t index_bytes = 0;  // encoded
  std::vector<MeshoptStream> streams;
  std::vector<uint8_t> packed;      // indices, then streams
  std::vector<uint8_t> compressed;  // the same in one zstd frame
};

// Merges points whose quantized values are equal, orders triangles in strips, which packs smaller than the
// order for vertex caches, and points for vertex fetch, quantizes (positions to 16-bit integers of
// `bits.position` bits, four of them in 8 bytes; normals and tangents to 8-bit octahedral; texture coordinates
// to two 16-bit integers of `bits.texcoord` bits; colours to bytes; all else as it is), encodes and compresses
// at zstd level 19.
Expected<MeshoptMesh> encode_meshopt(const Mesh& mesh, const MeshoptBits& bits);

// What a viewer uploads: indices and quantized values.
struct MeshoptDecoded {
  std::vector<uint32_t> indices;
  std::vector<std::vector<uint8_t>> streams;
};
// What is stored, and therefore read: `compressed`, or `packed` as it is.
enum class MeshoptForm { kZstd, kPlain };
Expected<MeshoptDecoded> decode_meshopt(const MeshoptMesh& mesh, MeshoptForm form = MeshoptForm::kZstd);

// Of the header that was compiled: its version, and the newest version of its codec for attributes, which
// encode_meshopt takes. Indices have been in version 1 since 0.15.
std::string meshopt_version();
int meshopt_codec_version();
// Of the library that runs.
std::string zstd_version();

}  // namespace psplit
