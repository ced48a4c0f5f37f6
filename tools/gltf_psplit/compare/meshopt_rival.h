// meshoptimizer's index and vertex codecs, alone and with zstd, used as gltfpack uses them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "psplit/base.h"
#include "psplit/encode.h"
#include "psplit/mesh.h"

namespace psplit {

// One attribute as meshoptimizer's codec stores it.
struct MeshoptStream {
  size_t stride = 0;        // a multiple of 4
  bool octahedral = false;  // unit vectors, as octahedral coordinates
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

// Quantizes with as many bits as psplit and stock Draco (`codings`, one for each attribute), on the same grids;
// merges points whose quantized values are equal, orders triangles in strips (which packs smaller than the
// order for vertex caches) and points for vertex fetch, encodes, and compresses at zstd level 19. Values on a
// grid are integers of 1, 2 or 4 bytes; attributes are padded to a multiple of 4 bytes. Normals and tangents
// are octahedral coordinates of at most 16 bits. Attributes without bits are stored as they are.
Expected<MeshoptMesh> encode_meshopt(const Mesh& mesh, std::span<const AttributeCoding> codings);

// What a viewer would upload: indices and quantized values.
struct MeshoptDecoded {
  std::vector<uint32_t> indices;
  std::vector<std::vector<uint8_t>> streams;
};
// Which form is stored and decoded: `compressed`, or `packed`.
enum class MeshoptForm { kZstd, kPlain };
Expected<MeshoptDecoded> decode_meshopt(const MeshoptMesh& mesh, MeshoptForm form = MeshoptForm::kZstd);

// The version of the compiled header, and the newest version of its attribute codec, which encode_meshopt uses.
// The index codec has been at version 1 since 0.15.
std::string meshopt_version();
int meshopt_codec_version();
// The version of the linked library.
std::string zstd_version();

}  // namespace psplit
