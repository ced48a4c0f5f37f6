// The lanes of a hardware warp; see src/core/lanes.h. Blocks are one-dimensional and made of whole warps.
#pragma once

#include "src/core/lanes.h"

namespace psplit {

// The host's versions exist only because nvcc compiles templates over lanes for both sides.
class WarpLanes {
 public:
  __device__ WarpLanes() : rank_(threadIdx.x % size()) {}

  PSPLIT_HD static constexpr uint32_t size() { return 32; }
  PSPLIT_HD uint32_t rank() const { return rank_; }
#if defined(__CUDA_ARCH__)
  __device__ uint32_t ballot(bool flag) const { return __ballot_sync(kAll, flag); }
  __device__ uint32_t shuffle(uint32_t word, uint32_t source) const {
    return __shfl_sync(kAll, word, static_cast<int>(source));
  }
  __device__ uint64_t shuffle(uint64_t wide, uint32_t source) const {
    return __shfl_sync(kAll, wide, static_cast<int>(source));
  }
  __device__ void sync() const { __syncwarp(kAll); }
#else
  uint32_t ballot(bool) const { __builtin_trap(); }
  uint32_t shuffle(uint32_t, uint32_t) const { __builtin_trap(); }
  uint64_t shuffle(uint64_t, uint32_t) const { __builtin_trap(); }
  void sync() const { __builtin_trap(); }
#endif

 private:
  static constexpr uint32_t kAll = 0xffffffffu;
  uint32_t rank_;
};

static_assert(core::Lanes<WarpLanes>);

}  // namespace psplit
