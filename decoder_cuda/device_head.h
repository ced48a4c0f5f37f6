// The head of a container with condensed streams, as kernels read it: one run of bytes on the device.
#pragma once

#include <algorithm>
#include <cstring>
#include <new>

#include "src/container/condensed_head.h"

namespace psplit {

// The run begins with it. Skeletons follow, and then the models' arrays.
struct DeviceHead {
  static constexpr size_t kAlignment = 16;  // of the run

  core::CondensedModels models;

  PSPLIT_HD core::View<const uint8_t> skeleton(uint32_t at, uint32_t bytes) const {
    return {reinterpret_cast<const uint8_t*>(this) + at, bytes};
  }
};

// Where a skeleton is in the run.
inline uint32_t skeleton_place(const CondensedHead& head, size_t skeleton) {
  size_t at = sizeof(DeviceHead);
  for (size_t i = 0; i < skeleton; ++i) at += head.skeletons[i].size();
  return static_cast<uint32_t>(at);  // at most 255 skeletons of 4 KiB
}

// The length of the run.
inline size_t device_head_bytes(const CondensedHead& head) {
  size_t bytes = skeleton_place(head, head.skeletons.size());
  head.models().for_each_array(
      [&]<typename T>(core::View<T>& array) { bytes += core::Arena::bytes<T>(array.size()); });
  return bytes;
}

// Writes the run to `host`, to be copied to `device`.
inline void write_device_head(const CondensedHead& head, uint8_t* host, const uint8_t* device) {
  core::CondensedModels models = head.models();
  uint8_t* skeletons_end = host + sizeof(DeviceHead);
  for (const std::vector<uint8_t>& skeleton : head.skeletons)
    skeletons_end = std::copy(skeleton.begin(), skeleton.end(), skeletons_end);
  core::Arena arena(skeletons_end, static_cast<size_t>(host + device_head_bytes(head) - skeletons_end));
  models.for_each_array([&]<typename T>(core::View<const T>& array) {
    core::View<T> copy;
    (void)arena.take(copy, array.size());
    std::copy(array.data(), array.data() + array.size(), copy.data());
    const uint8_t* const place = reinterpret_cast<const uint8_t*>(copy.data());
    array = {reinterpret_cast<const T*>(device + (place - host)), array.size()};
  });
  new (host) DeviceHead{models};
}

}  // namespace psplit
