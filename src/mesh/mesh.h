// One triangle primitive in plain arrays. All parts of psplit exchange meshes in this form.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

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

// An allocator for vectors that are filled right after resize: new elements are not initialized. So memory is
// not zeroed first, and each thread touches only the part that it writes.
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
  std::string semantic;  // glTF's name: POSITION, NORMAL, TEXCOORD_0, _FEATURE_ID_0
  ComponentType component_type = ComponentType::kFloat32;
  uint8_t component_count = 3;  // 1 to 16 (MAT4)
  bool normalized = false;
  Array<std::byte> values;  // point_count * stride() bytes, little-endian

  size_t stride() const { return component_bytes(component_type) * component_count; }
};

struct Mesh {
  uint32_t point_count = 0;
  Array<std::array<uint32_t, 3>> faces;  // point indices, each below point_count; none: a point cloud
  std::vector<Attribute> attributes;     // semantics are unique; POSITION is one of them

  // Null if the mesh has no such attribute.
  const Attribute* find(const std::string& semantic) const {
    for (const Attribute& attribute : attributes)
      if (attribute.semantic == semantic) return &attribute;
    return nullptr;
  }
};

}  // namespace psplit
