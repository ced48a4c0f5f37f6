// Texture coordinates that a file states for the corners of faces, not for points.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "mesh_files/mesh_file.h"

namespace psplit {

struct FaceTexcoords {
  static constexpr int32_t kNone = -2, kNoTexture = -1;  // of `textures`

  std::vector<std::array<float, 6>> corners;  // of each face
  std::vector<int32_t> textures;              // of each face: a number, or one of the above

  // Gives the faces up to `count` no coordinates.
  void pad(size_t count) {
    corners.resize(count);
    textures.resize(count, kNone);
  }
};

// Gives the texture coordinates of corners to points: a point whose corners differ becomes several points.
// Faces with the same texture become a part, and faces without coordinates another. `materials` has the
// material of each texture. Texture coordinates of points, and points without a face, are left out and count as
// losses.
std::vector<MeshFilePart> parts_with_texcoords(MeshFilePart whole, const FaceTexcoords& texcoords,
                                               std::span<const int64_t> materials, Losses& losses);

}  // namespace psplit
