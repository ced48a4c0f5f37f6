// Meshes in plain arrays: owned by psplit, or views of the caller's arrays.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "psplit/base.h"

namespace psplit {

// glTF's component types, with the numbers that glTF gives them.
enum class ComponentType : uint16_t {
  kInt8 = 5120,
  kUint8 = 5121,
  kInt16 = 5122,
  kUint16 = 5123,
  kUint32 = 5125,
  kFloat32 = 5126,
};

constexpr size_t component_bytes(ComponentType type) {
  switch (type) {
    case ComponentType::kInt8:
    case ComponentType::kUint8: return 1;
    case ComponentType::kInt16:
    case ComponentType::kUint16: return 2;
    case ComponentType::kUint32:
    case ComponentType::kFloat32: return 4;
  }
  return 0;
}

// An allocator for vectors that are filled right after resize: new elements are not initialized. This saves
// zeroing, and each thread is the first to touch the memory that it writes.
template <typename T>
struct Unzeroed : std::allocator<T> {
  template <typename U>
  struct rebind {
    using other = Unzeroed<U>;
  };
  template <typename U>
  void construct(U* at) noexcept {
    ::new (static_cast<void*>(at)) U;
  }
  template <typename U, typename... Arguments>
  void construct(U* at, Arguments&&... arguments) {
    ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
  }
};
template <typename T>
using Array = std::vector<T, Unzeroed<T>>;

// One value for each point, tightly packed.
struct Attribute {
  std::string semantic;  // glTF's name: POSITION, NORMAL, TEXCOORD_0, _FEATURE_ID_0; or a name_of_target
  ComponentType component_type = ComponentType::kFloat32;
  uint8_t component_count = 3;  // 1 to 16 (MAT4)
  bool normalized = false;
  Array<std::byte> values;  // point_count * stride() bytes, little-endian

  size_t stride() const { return component_bytes(component_type) * component_count; }
};

// The deltas of a morph target are attributes of the mesh: the first target's POSITION deltas have the name
// "targets/0/POSITION", which no attribute of glTF has.
struct MorphTarget {
  size_t number = 0;
  std::string semantic;  // POSITION, NORMAL, TANGENT, ...
};
inline std::string name_of_target(size_t number, const std::string& semantic) {
  return "targets/" + std::to_string(number) + "/" + semantic;
}
// Empty if the name is not a target's.
inline std::optional<MorphTarget> target_of(const std::string& name) {
  constexpr size_t kPrefix = sizeof("targets/") - 1, kMostDigits = 9;
  if (name.compare(0, kPrefix, "targets/") != 0) return std::nullopt;
  MorphTarget target;
  size_t at = kPrefix;
  for (; at < name.size() && name[at] >= '0' && name[at] <= '9'; ++at)
    target.number = 10 * target.number + static_cast<size_t>(name[at] - '0');
  if (at == kPrefix || at - kPrefix > kMostDigits || at + 1 >= name.size() || name[at] != '/')
    return std::nullopt;
  target.semantic = name.substr(at + 1);
  return target;
}

// One triangle primitive. All parts of psplit exchange meshes in this form.
struct Mesh {
  uint32_t point_count = 0;
  Array<std::array<uint32_t, 3>> faces;  // point indices, each below point_count; empty: a point cloud
  std::vector<Attribute> attributes;     // semantics are unique; POSITION must be present

  // Null if the mesh has no such attribute.
  const Attribute* find(const std::string& semantic) const {
    for (const Attribute& attribute : attributes)
      if (attribute.semantic == semantic) return &attribute;
    return nullptr;
  }
};

// A view of values or indices. Bytes may have any alignment.
struct ValuesView {
  ComponentType component_type = ComponentType::kFloat32;
  uint8_t component_count = 1;
  bool normalized = false;
  uint32_t count = 0;
  Span<const std::byte> bytes{};
  size_t stride = 0;  // from one value to the next; 0: tightly packed

  size_t value_bytes() const { return component_bytes(component_type) * component_count; }
  size_t step() const { return stride == 0 ? value_bytes() : stride; }
  const std::byte* at(size_t index) const { return bytes.data() + index * step(); }
};

// A view of a mesh in the caller's arrays.
struct MeshView {
  struct Values {
    std::string semantic;
    ValuesView values;
  };
  uint32_t point_count = 0;
  std::vector<Values> attributes{};
  ValuesView indices{};  // unsigned, three for each face; without bytes they are 0, 1, 2 and so on

  // Null if the mesh has no such attribute.
  const ValuesView* find(const std::string& semantic) const {
    for (const Values& attribute : attributes)
      if (attribute.semantic == semantic) return &attribute.values;
    return nullptr;
  }
  uint32_t index(size_t number) const {
    if (indices.bytes.empty()) return static_cast<uint32_t>(number);
    uint32_t index = 0;
    std::memcpy(&index, indices.at(number), indices.value_bytes());  // little-endian, as glTF
    return index;
  }
};

// The bounds of an attribute's values, as the accessors of glTF state them: the least and the largest finite
// value of each component. Until finish(), a component without finite values has a least value above its
// largest.
struct ValueBounds {
  std::vector<double> least, most;

  // Adds values that are `stride` bytes apart. All calls must have the same type and number of components.
  void add(ComponentType type, size_t component_count, const std::byte* values, size_t count, size_t stride) {
    if (least.empty()) {
      least.assign(component_count, std::numeric_limits<double>::infinity());
      most.assign(component_count, -std::numeric_limits<double>::infinity());
    }
    switch (type) {
      case ComponentType::kInt8: return add_as<int8_t>(values, count, stride);
      case ComponentType::kUint8: return add_as<uint8_t>(values, count, stride);
      case ComponentType::kInt16: return add_as<int16_t>(values, count, stride);
      case ComponentType::kUint16: return add_as<uint16_t>(values, count, stride);
      case ComponentType::kUint32: return add_as<uint32_t>(values, count, stride);
      case ComponentType::kFloat32: return add_as<float>(values, count, stride);
    }
  }
  // Sets both bounds of components without finite values to 0.
  void finish() {
    for (size_t c = 0; c < least.size(); ++c)
      if (least[c] > most[c]) least[c] = most[c] = 0;
  }

 private:
  template <typename T>
  void add_as(const std::byte* values, size_t count, size_t stride) {
    size_t c = 0;
    for (; c + 3 <= least.size(); c += 3) add_components<T, 3>(c, values, count, stride);
    for (; c < least.size(); ++c) add_components<T, 1>(c, values, count, stride);
  }
  // Components c to c + kCount - 1. Each result depends on the component's previous one, so several components
  // are interleaved.
  template <typename T, size_t kCount>
  void add_components(size_t c, const std::byte* values, size_t count, size_t stride) {
    std::array<T, kCount> low, high;
    low.fill(std::numeric_limits<T>::max());
    high.fill(std::numeric_limits<T>::lowest());
    for (size_t i = 0; i < count; ++i)
      for (size_t k = 0; k < kCount; ++k) {
        T value;
        std::memcpy(&value, values + i * stride + (c + k) * sizeof(T), sizeof(T));
        bool is_finite = true;
        if constexpr (std::is_floating_point_v<T>) is_finite = std::isfinite(value);
        low[k] = is_finite && value < low[k] ? value : low[k];
        high[k] = is_finite && high[k] < value ? value : high[k];
      }
    for (size_t k = 0; k < kCount; ++k) {
      if (low[k] > high[k]) continue;
      least[c + k] = std::min(least[c + k], static_cast<double>(low[k]));
      most[c + k] = std::max(most[c + k], static_cast<double>(high[k]));
    }
  }
};

}  // namespace psplit
