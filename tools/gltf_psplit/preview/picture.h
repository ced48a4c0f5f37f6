// Meshes as a picture: colour by patch, shape by light, nothing behind them.
#pragma once

#include <span>

#include "src/parallel.h"
#include "tools/gltf_psplit/preview/patch_colors.h"
#include "tools/gltf_psplit/preview/png.h"
#include "tools/gltf_psplit/preview/scene.h"

namespace psplit {

// What of a mesh a picture shows: its primitives one after the other.
struct PictureMesh {
  std::vector<std::array<float, 3>> positions, normals;  // by point; normals as light sees them, of any length
  std::vector<std::array<uint32_t, 3>> faces;
  std::vector<uint32_t> patch_end;  // number of the face that follows the patch's last; ascending
  std::vector<Color> patch_color;
};

// The same bytes for any number of threads. Faces that are not finite are left out; kUnsupported where nothing
// is left to see.
Expected<Image> draw_picture(std::span<const PictureMesh> meshes, std::span<const MeshInstance> instances,
                             ImageSize size, const ThreadPool& pool);

}  // namespace psplit
