// meshoptimizer's index and vertex codecs, alone and with what the web sends on top of them: zstd or brotli.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "psplit/base.h"
#include "psplit/encode.h"
#include "psplit/mesh.h"

namespace psplit {

// Which form is stored and decoded.
enum class MeshoptForm { kPlain, kZstd, kBrotli };
// The forms that this build can make: brotli is optional.
std::span<const MeshoptForm> meshopt_forms();

// How values are stored, beside plain integers on a grid.
enum class MeshoptFilter { kNone, kOctahedral, kColor };

// One attribute as meshoptimizer's codec stores it.
struct MeshoptStream {
  size_t stride = 0;  // a multiple of 4
  MeshoptFilter filter = MeshoptFilter::kNone;
  size_t encoded_bytes = 0;
};

struct MeshoptMesh {
  size_t index_count = 0;
  size_t point_count = 0;
  size_t index_bytes = 0;  // encoded
  std::vector<MeshoptStream> streams;
  std::vector<uint8_t> packed;       // indices, then streams
  std::vector<uint8_t> with_zstd;    // `packed` in one zstd frame
  std::vector<uint8_t> with_brotli;  // `packed` in one brotli stream; empty without brotli

  const std::vector<uint8_t>& bytes(MeshoptForm form) const {
    return form == MeshoptForm::kZstd ? with_zstd : form == MeshoptForm::kBrotli ? with_brotli : packed;
  }
};

// Quantizes with as many bits as psplit and stock Draco (`codings`, one for each attribute), on the same grids;
// merges points whose quantized values are equal, orders triangles in strips (which packs smaller than the
// order for vertex caches) and points for vertex fetch, encodes at the highest level and with the newest codec
// of the library, and compresses with zstd at level 19 and brotli at quality 11. Values on a grid are integers
// of 1, 2 or 4 bytes; attributes are padded to a multiple of 4 bytes. Normals and tangents are octahedral
// coordinates of at most 16 bits. Colours without transparency pass the filter for colours if the library has
// it and that makes the stream smaller. Attributes without bits are stored as they are.
Expected<MeshoptMesh> encode_meshopt(const Mesh& mesh, std::span<const AttributeCoding> codings);

// What a viewer would upload: indices and quantized values.
struct MeshoptDecoded {
  std::vector<uint32_t> indices;
  std::vector<std::vector<uint8_t>> streams;
};
Expected<MeshoptDecoded> decode_meshopt(const MeshoptMesh& mesh, MeshoptForm form = MeshoptForm::kZstd);

// Encodes rows of `stride` bytes by meshoptimizer's attribute codec: its newest version, at its highest level.
std::vector<uint8_t> encode_meshopt_points(std::span<const uint8_t> rows, size_t row_count, size_t stride);

// The version of the compiled header, and the newest version of its attribute codec, which encode_meshopt uses.
// The index codec has been at version 1 since 0.15.
std::string meshopt_version();
int meshopt_codec_version();
// The versions of the linked libraries. Of brotli empty if this build has none.
std::string zstd_version();
std::string brotli_version();

}  // namespace psplit
