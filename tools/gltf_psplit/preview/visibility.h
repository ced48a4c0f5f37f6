// Which face each sample of a picture sees: triangles drawn by any number of threads at once, in any order, to
// the same result.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <vector>

#include "tools/gltf_psplit/preview/camera.h"

namespace psplit {

inline constexpr uint32_t kNoFace = std::numeric_limits<uint32_t>::max();

class VisibilityBuffer {
 public:
  explicit VisibilityBuffer(ImageSize size)
      : size_(size), samples_(static_cast<size_t>(size.width) * static_cast<size_t>(size.height)) {}

  ImageSize size() const { return size_; }

  // A sample is covered where its centre lies in the triangle; of triangles that share an edge exactly one
  // covers a centre on it. The nearest face stays, the lower-numbered one of two that are equally near.
  // Triangles may face either way, and reach over the picture's edge.
  void draw(const std::array<ScreenPoint, 3>& corners, uint32_t face);

  // kNoFace where nothing is, and outside the picture.
  uint32_t face_at(int x, int y) const {
    if (x < 0 || y < 0 || x >= size_.width || y >= size_.height) return kNoFace;
    return kNoFace - static_cast<uint32_t>(samples_[index(x, y)].load(std::memory_order_relaxed));
  }

 private:
  size_t index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(size_.width) + static_cast<size_t>(x);
  }

  ImageSize size_;
  // Nearness above kNoFace - face, so that the largest number wins and 0 is empty.
  std::vector<std::atomic<uint64_t>> samples_;
};

}  // namespace psplit
