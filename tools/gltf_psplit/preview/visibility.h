// Which face is visible at each sample of a picture. Any number of threads can draw triangles at once, in any
// order, with the same result.
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

  // A triangle covers the samples whose centres are inside. If a centre is on an edge that two triangles share,
  // exactly one of them covers it. The nearest face is visible; if two are equally near, the one with the lower
  // number. Triangles may face either way and may extend beyond the picture.
  void draw(const std::array<ScreenPoint, 3>& corners, uint32_t face);

  // kNoFace if nothing is there, or outside the picture.
  uint32_t face_at(int x, int y) const {
    if (x < 0 || y < 0 || x >= size_.width || y >= size_.height) return kNoFace;
    return kNoFace - static_cast<uint32_t>(samples_[index(x, y)].load(std::memory_order_relaxed));
  }

 private:
  size_t index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(size_.width) + static_cast<size_t>(x);
  }

  ImageSize size_;
  // The high half is the nearness, the low half is kNoFace - face. So the largest number wins, and 0 is empty.
  std::vector<std::atomic<uint64_t>> samples_;
};

}  // namespace psplit
