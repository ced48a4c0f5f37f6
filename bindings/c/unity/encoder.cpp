#include "bindings/c/unity/encoder.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <vector>

#include "bindings/c/no_throw.h"
#include "bindings/c/unity/flip.h"
#include "encoder/stream/draco_encoder.h"

using psplit::c::without_exceptions;

struct UnityEncoder {
  psplit::DracoMesh mesh{};
  // Bits of each semantic: position, normal, colour, texture coordinate, generic.
  std::vector<int> bits{14, 10, 10, 12, 12};
  int speed = 5;
  bool is_cloud = false;
  bool is_broken = false;  // a call had arguments that cannot be encoded
  std::optional<psplit::LabelledStream> stream{};
};

namespace psplit::unity {
namespace {

constexpr uint32_t kNoId = 0xffffffffu;

template <typename T>
void flip_values(std::byte* values, size_t count, uint32_t components) {
  for (size_t i = 0; i < count; ++i) {
    T value[4];
    std::byte* const place = values + i * components * sizeof(T);
    std::memcpy(value, place, components * sizeof(T));
    flip_value(value, components);
    std::memcpy(place, value, components * sizeof(T));
  }
}

void flip_attribute(Attribute& attribute, size_t count) {
  const uint32_t components = attribute.component_count;
  if (components < 2 || components > 4) return;
  std::byte* const values = attribute.values.data();
  switch (attribute.component_type) {
    case ComponentType::kInt8: return flip_values<int8_t>(values, count, components);
    case ComponentType::kUint8: return flip_values<uint8_t>(values, count, components);
    case ComponentType::kInt16: return flip_values<int16_t>(values, count, components);
    case ComponentType::kUint16: return flip_values<uint16_t>(values, count, components);
    case ComponentType::kUint32: return flip_values<uint32_t>(values, count, components);
    case ComponentType::kFloat32: return flip_values<float>(values, count, components);
  }
}

uint32_t set_attribute(UnityEncoder& encoder, int32_t semantic, int32_t data_type, int32_t components,
                       int32_t stride, bool flip, const void* data) {
  const auto type = component_type_of(static_cast<DataType>(data_type));
  constexpr int32_t kGeneric = static_cast<int32_t>(DracoSemantic::kGeneric), kMostComponents = 16;
  if (!type || semantic < 0 || semantic > kGeneric || components < 1 || components > kMostComponents ||
      stride < 0 || data == nullptr)
    return kNoId;
  Mesh& mesh = encoder.mesh.mesh;
  const size_t id = mesh.attributes.size();
  const DracoLabel label{static_cast<DracoSemantic>(semantic), static_cast<DataType>(data_type)};
  const bool is_position = label.semantic == DracoSemantic::kPosition && mesh.find("POSITION") == nullptr;
  Attribute attribute{
      is_position ? "POSITION" : "_" + std::to_string(id), *type, static_cast<uint8_t>(components), false, {}};
  const size_t bytes = attribute.stride();
  attribute.values.resize(mesh.point_count * bytes);
  for (size_t point = 0; point < mesh.point_count; ++point)
    std::memcpy(attribute.values.data() + point * bytes,
                static_cast<const std::byte*>(data) + point * static_cast<size_t>(stride), bytes);
  if (flip) flip_attribute(attribute, mesh.point_count);
  mesh.attributes.push_back(std::move(attribute));
  encoder.mesh.labels.push_back(label);
  encoder.mesh.share_values.push_back(0);
  return static_cast<uint32_t>(id);
}

bool set_indices(UnityEncoder& encoder, int32_t type, uint32_t count, bool flip, const void* indices) {
  constexpr int32_t kInt8 = 1, kUint32 = 6, kInt32 = 5;
  if (type < kInt8 || type > kUint32 || type == kInt32 || (indices == nullptr && count > 0)) return false;
  const size_t bytes = type <= 2 ? 1 : type <= 4 ? 2 : 4;
  const auto* const from = static_cast<const std::byte*>(indices);
  auto& faces = encoder.mesh.mesh.faces;
  faces.assign(count / 3, {});
  for (size_t corner = 0; corner < 3 * faces.size(); ++corner)
    std::memcpy(&faces[corner / 3][corner % 3], from + corner * bytes, bytes);  // little-endian
  if (flip)
    for (auto& face : faces) std::swap(face[1], face[2]);
  return true;
}

bool encode(UnityEncoder& encoder, bool is_sequential) {
  encoder.stream.reset();
  if (encoder.is_broken) return false;
  std::vector<AttributeCoding> codings;
  for (const DracoLabel& label : encoder.mesh.labels)
    codings.emplace_back().bits = encoder.bits[static_cast<size_t>(label.semantic)];
  Expected<LabelledStream> encoded =
      encoder.is_cloud ? encode_cloud_as_draco(encoder.mesh, std::move(codings), {}, encoder.speed)
                       : encode_as_draco(encoder.mesh, std::move(codings), is_sequential, encoder.speed);
  if (!encoded) return false;
  encoder.stream = std::move(*encoded);
  return true;
}

UnityEncoder* create(uint32_t vertex_count, bool is_cloud) {
  return without_exceptions<UnityEncoder*>(nullptr, [&] {
    auto* const encoder = new UnityEncoder;
    encoder->mesh.mesh.point_count = vertex_count;
    encoder->is_cloud = is_cloud;
    return encoder;
  });
}

}  // namespace
}  // namespace psplit::unity

using namespace psplit::unity;

UnityEncoder* dracoEncoderCreate(uint32_t vertexCount) { return create(vertexCount, false); }
UnityEncoder* dracoEncoderCreatePointCloud(uint32_t vertexCount) { return create(vertexCount, true); }
void dracoEncoderRelease(UnityEncoder* encoder) { delete encoder; }

void dracoEncoderSetCompressionSpeed(UnityEncoder* encoder, uint32_t encodingSpeed, uint32_t decodingSpeed) {
  constexpr uint32_t kMostSpeed = 10;
  if (encoder != nullptr)
    encoder->speed = static_cast<int>(std::min(std::max(encodingSpeed, decodingSpeed), kMostSpeed));
}
void dracoEncoderSetQuantizationBits(UnityEncoder* encoder, uint32_t position, uint32_t normal, uint32_t uv,
                                     uint32_t color, uint32_t generic) {
  if (encoder == nullptr) return;
  encoder->bits.clear();
  constexpr uint32_t kMostBits = 31;  // more bits are refused when the mesh is encoded
  for (const uint32_t bits : {position, normal, color, uv, generic})
    encoder->bits.push_back(static_cast<int>(std::min(bits, kMostBits)));
}

bool dracoEncoderSetIndices(UnityEncoder* encoder, int32_t indexComponentType, uint32_t indexCount, bool flip,
                            const void* indices) {
  if (encoder == nullptr) return false;
  const bool is_set = without_exceptions(
      false, [&] { return set_indices(*encoder, indexComponentType, indexCount, flip, indices); });
  encoder->is_broken |= !is_set;
  return is_set;
}

uint32_t dracoEncoderSetAttribute(UnityEncoder* encoder, int32_t attributeType, int32_t dataType,
                                  int32_t componentCount, int32_t stride, bool flip, const void* data) {
  if (encoder == nullptr) return kNoId;
  const uint32_t id = without_exceptions(kNoId, [&] {
    return set_attribute(*encoder, attributeType, dataType, componentCount, stride, flip, data);
  });
  encoder->is_broken |= id == kNoId;
  return id;
}

bool dracoEncoderEncode(UnityEncoder* encoder, uint8_t preserveTriangleOrder) {
  if (encoder == nullptr) return false;
  return without_exceptions(false, [&] { return encode(*encoder, preserveTriangleOrder != 0); });
}
uint32_t dracoEncoderGetEncodedVertexCount(UnityEncoder* encoder) {
  return encoder == nullptr || !encoder->stream ? 0 : encoder->stream->point_count;
}
uint32_t dracoEncoderGetEncodedIndexCount(UnityEncoder* encoder) {
  return encoder == nullptr || !encoder->stream ? 0 : 3 * encoder->stream->face_count;
}
uint64_t dracoEncoderGetByteLength(UnityEncoder* encoder) {
  return encoder == nullptr || !encoder->stream ? 0 : encoder->stream->bytes.size();
}
void dracoEncoderCopy(UnityEncoder* encoder, uint8_t* data) {
  if (encoder == nullptr || !encoder->stream || data == nullptr) return;
  std::memcpy(data, encoder->stream->bytes.data(), encoder->stream->bytes.size());
}
void dracoEncoderGetEncodeBuffer(UnityEncoder* encoder, void** data, uint64_t* size) {
  if (data == nullptr || size == nullptr) return;
  *size = dracoEncoderGetByteLength(encoder);
  *data = *size == 0 ? nullptr : encoder->stream->bytes.data();
}
