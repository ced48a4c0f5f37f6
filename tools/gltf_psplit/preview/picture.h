// Draws meshes: the colour shows the patch, shading shows the shape, and the background is transparent.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "psplit/base.h"
#include "psplit/parallel.h"
#include "tools/gltf_psplit/preview/camera.h"
#include "tools/gltf_psplit/preview/scene.h"
#include "tools/gltf_psplit/shapes/vec3.h"

namespace psplit {

// Rows from top to bottom. Each pixel is red, green, blue (sRGB, not premultiplied) and alpha.
struct Image {
  ImageSize size;
  std::vector<uint8_t> rgba;
};

Expected<std::vector<uint8_t>> encode_png(const Image& image);

using Color = Vec3;  // linear red, green and blue with the primaries of sRGB, from 0 to 1

// Patch p has the faces [face_base[p], face_base[p + 1]). Patches that share a point are neighbours. `first` is
// the index of patch 0 in the endless series of colours, so that several meshes can continue one series.
// Deterministic.
std::vector<Color> patch_colors(std::span<const std::array<uint32_t, 3>> faces, uint32_t point_count,
                                std::span<const uint32_t> face_base, size_t first = 0);

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
