#include "bindings/c/unity/plugin.h"

#include <algorithm>
#include <cstring>
#include <memory>

#include "bindings/c/no_throw.h"
#include "bindings/c/unity/flip.h"
#include "psplit/decode.h"

namespace {

using psplit::DataType;
using psplit::DracoGeometry;
using psplit::GeometryAttribute;
using psplit::c::without_exceptions;

const DracoGeometry& geometry_of(const DracoMesh& mesh) {
  return *static_cast<const DracoGeometry*>(mesh.privateMesh);
}

template <typename T>
bool give(T** place, T value) {
  *place = new T(value);
  return true;
}

// The first attribute that `is_wanted` takes.
template <typename IsWanted>
bool find_attribute(const DracoMesh* mesh, DracoAttribute** attribute, IsWanted is_wanted) {
  if (mesh == nullptr || attribute == nullptr || *attribute != nullptr) return false;
  const auto& attributes = geometry_of(*mesh).attributes;
  const auto found = std::find_if(attributes.begin(), attributes.end(), is_wanted);
  if (found == attributes.end()) return false;
  const psplit::StreamAttribute& description = found->description;
  return give(attribute, {static_cast<int32_t>(description.semantic), static_cast<int32_t>(description.type),
                          description.components, static_cast<int32_t>(description.unique_id), &*found});
}

template <typename T>
std::unique_ptr<char[]> copy_values(const GeometryAttribute& attribute, uint32_t point_count, uint32_t stride,
                                    bool flip) {
  const uint32_t components = attribute.description.components, bytes = components * sizeof(T);
  auto values = std::make_unique<char[]>(std::max<size_t>(size_t{point_count} * stride * sizeof(T), 1));
  for (uint32_t point = 0; point < point_count; ++point) {
    T value[4];
    std::memcpy(value, attribute.values.data() + size_t{point} * bytes, bytes);
    if (flip) psplit::unity::flip_value(value, components);
    std::memcpy(values.get() + size_t{point} * stride * sizeof(T), value, bytes);
  }
  return values;
}

// Null for a type that the plugin does not give.
std::unique_ptr<char[]> copy_values_of_any_type(const GeometryAttribute& attribute, uint32_t point_count,
                                                uint32_t stride, bool flip) {
  switch (attribute.description.type) {
    case DataType::kInt8: return copy_values<int8_t>(attribute, point_count, stride, flip);
    case DataType::kUint8: return copy_values<uint8_t>(attribute, point_count, stride, flip);
    case DataType::kInt16: return copy_values<int16_t>(attribute, point_count, stride, flip);
    case DataType::kUint16: return copy_values<uint16_t>(attribute, point_count, stride, flip);
    // In unsigned numbers, so that the least number may be negated.
    case DataType::kInt32:
    case DataType::kUint32: return copy_values<uint32_t>(attribute, point_count, stride, flip);
    case DataType::kFloat32: return copy_values<float>(attribute, point_count, stride, flip);
    default: return nullptr;
  }
}

template <typename T>
void write_indices(const DracoGeometry& geometry, T* out, bool flip) {
  for (const auto& [a, b, c] : geometry.faces)
    for (const uint32_t point : {a, flip ? c : b, flip ? b : c}) *out++ = static_cast<T>(point);
}

}  // namespace

int32_t DecodeDracoMeshStep1(const char* data, uint32_t length, DracoMesh** mesh, void** decoder,
                             void** buffer) {
  constexpr int32_t kBadArguments = -1, kBadStream = -4;
  if (data == nullptr || mesh == nullptr || *mesh != nullptr || decoder == nullptr || buffer == nullptr)
    return kBadArguments;
  return without_exceptions(kBadStream, [&] {
    psplit::Expected<DracoGeometry> decoded =
        psplit::decode_geometry({reinterpret_cast<const uint8_t*>(data), length});
    if (!decoded) return kBadStream;
    auto geometry = std::make_unique<DracoGeometry>(std::move(*decoded));
    *decoder = *buffer = geometry.get();
    give(mesh, {static_cast<int32_t>(geometry->faces.size()), static_cast<int32_t>(geometry->point_count),
                static_cast<int32_t>(geometry->attributes.size()), psplit::is_cloud(geometry->coding),
                geometry.get()});
    geometry.release();
    return 0;
  });
}

int32_t DecodeDracoMeshStep2(DracoMesh** mesh, void*, void*) {
  constexpr int32_t kNoMesh = -4;
  return mesh == nullptr || *mesh == nullptr ? kNoMesh : 0;
}

void ReleaseDracoMesh(DracoMesh** mesh) {
  if (mesh == nullptr || *mesh == nullptr) return;
  delete static_cast<DracoGeometry*>((*mesh)->privateMesh);
  delete *mesh;
  *mesh = nullptr;
}

bool GetAttribute(const DracoMesh* mesh, int32_t index, DracoAttribute** attribute) {
  return without_exceptions(false, [&] {
    int32_t left = index;
    return find_attribute(mesh, attribute, [&](const GeometryAttribute&) { return left-- == 0; });
  });
}

bool GetAttributeByType(const DracoMesh* mesh, int32_t type, int32_t index, DracoAttribute** attribute) {
  return without_exceptions(false, [&] {
    int32_t left = index;
    return find_attribute(mesh, attribute, [&](const GeometryAttribute& candidate) {
      return static_cast<int32_t>(candidate.description.semantic) == type && left-- == 0;
    });
  });
}

bool GetAttributeByUniqueId(const DracoMesh* mesh, int32_t uniqueId, DracoAttribute** attribute) {
  return without_exceptions(false, [&] {
    return find_attribute(mesh, attribute, [&](const GeometryAttribute& candidate) {
      return candidate.description.unique_id == static_cast<uint32_t>(uniqueId);
    });
  });
}

void ReleaseDracoAttribute(DracoAttribute** attribute) {
  if (attribute == nullptr) return;
  delete *attribute;
  *attribute = nullptr;
}

bool GetMeshIndices(const DracoMesh* mesh, int32_t dataType, void* indices, uint32_t indicesCount, bool flip) {
  if (mesh == nullptr || indices == nullptr) return false;
  const DracoGeometry& geometry = geometry_of(*mesh);
  constexpr uint32_t kMostPoints = 1 << 16;
  if (indicesCount / 3 < geometry.faces.size()) return false;
  if (dataType == static_cast<int32_t>(DataType::kUint32)) {
    write_indices(geometry, static_cast<uint32_t*>(indices), flip);
  } else if (dataType == static_cast<int32_t>(DataType::kUint16) && geometry.point_count <= kMostPoints) {
    write_indices(geometry, static_cast<uint16_t*>(indices), flip);
  } else {
    return false;
  }
  return true;
}

bool GetAttributeData(const DracoMesh* mesh, const DracoAttribute* attribute, DracoData** data, bool flip,
                      int32_t componentStride) {
  if (mesh == nullptr || attribute == nullptr || data == nullptr || *data != nullptr) return false;
  const auto& values = *static_cast<const GeometryAttribute*>(attribute->privateAttribute);
  constexpr int32_t kMostComponents = 4, kMostStride = 255;
  const int32_t components = values.description.components;
  if (components > kMostComponents || componentStride < components || componentStride > kMostStride)
    return false;
  return without_exceptions(false, [&] {
    std::unique_ptr<char[]> copied = copy_values_of_any_type(values, geometry_of(*mesh).point_count,
                                                             static_cast<uint32_t>(componentStride), flip);
    if (copied == nullptr) return false;
    give(data, {static_cast<int32_t>(values.description.type), copied.get()});
    copied.release();
    return true;
  });
}

void ReleaseDracoData(DracoData** data) {
  if (data == nullptr || *data == nullptr) return;
  delete[] static_cast<char*>((*data)->data);
  delete *data;
  *data = nullptr;
}
