// Draws meshes: the colour shows the patch, shading shows the shape, and the background is transparent.
#pragma once

#include <span>

#include "src/parallel.h"
#include "tools/gltf_psplit/preview/patch_colors.h"
#include "tools/gltf_psplit/preview/png.h"
#include "tools/gltf_psplit/preview/scene.h"

namespace psplit {

// The drawn parts of a mesh: its primitives, one after the other.
struct PictureMesh {
  std::vector<std::array<float, 3>> positions, normals;  // for each point; normals may have any length
  std::vector<std::array<uint32_t, 3>> faces;
  std::vector<uint32_t> patch_end;  // one past the last face of each patch; ascending
  std::vector<Color> patch_color;
};

// The bytes do not depend on the number of threads. Faces that are not finite are left out. kUnsupported if
// nothing remains to be seen.
Expected<Image> draw_picture(std::span<const PictureMesh> meshes, std::span<const MeshInstance> instances,
                             ImageSize size, const ThreadPool& pool);

}  // namespace psplit
