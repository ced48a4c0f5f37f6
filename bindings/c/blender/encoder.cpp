#include <algorithm>
#include <cstring>
#include <optional>
#include <vector>

#include "bindings/c/blender/bridge.h"
#include "bindings/c/blender/element_type.h"
#include "bindings/c/no_throw.h"
#include "psplit/encode.h"

using psplit::c::without_exceptions;

struct Encoder {
  psplit::Mesh mesh{};
  psplit::CodingOptions bits{14, 10, 12, 10, 12};  // Blender's
  uint32_t level = 7;
  bool is_broken = false;  // a call had arguments that cannot be encoded
  std::optional<psplit::EncodedPiece> stream{};
};

namespace psplit::blender {
namespace {

constexpr uint32_t kNoId = 0xffffffffu;

// Streams number the position 0, and the other attributes in their order from 1 on.
uint32_t next_id(const Mesh& mesh, const std::string& semantic) {
  if (semantic == "POSITION") return 0;
  return static_cast<uint32_t>(mesh.attributes.size()) + (mesh.find("POSITION") == nullptr ? 1 : 0);
}

bool is_normalized(const std::string& semantic, ComponentType type) {
  if (type == ComponentType::kFloat32) return false;
  return semantic.starts_with("COLOR_") || semantic.starts_with("TEXCOORD_") ||
         semantic.starts_with("WEIGHTS_");
}

uint32_t set_attribute(Encoder& encoder, const char* name, size_t component_type, const char* data_type,
                       const void* data) {
  const std::optional<ComponentType> type = component_type_of(component_type);
  const uint8_t components = component_count_of(data_type);
  const bool is_new = name != nullptr && encoder.mesh.find(name) == nullptr;
  if (!type || components == 0 || !is_new || (data == nullptr && encoder.mesh.point_count > 0)) {
    encoder.is_broken = true;
    return kNoId;
  }
  Attribute attribute{name, *type, components, is_normalized(name, *type), {}};
  attribute.values.resize(encoder.mesh.point_count * attribute.stride());
  if (!attribute.values.empty()) std::memcpy(attribute.values.data(), data, attribute.values.size());
  const uint32_t id = next_id(encoder.mesh, attribute.semantic);
  encoder.mesh.attributes.push_back(std::move(attribute));
  return id;
}

void set_indices(Encoder& encoder, size_t component_type, uint32_t count, const void* indices) {
  const std::optional<ComponentType> type = component_type_of(component_type);
  if (!type || *type == ComponentType::kFloat32 || (indices == nullptr && count > 0)) {
    encoder.is_broken = true;
    return;
  }
  const size_t bytes = component_bytes(*type);
  const auto* from = static_cast<const std::byte*>(indices);
  encoder.mesh.faces.assign(count / 3, {});
  for (std::array<uint32_t, 3>& face : encoder.mesh.faces)
    for (uint32_t& point : face) {
      std::memcpy(&point, from, bytes);  // little-endian; negative numbers become too large for any mesh
      from += bytes;
    }
}

bool encode(Encoder& encoder, bool keeps_order) {
  encoder.stream.reset();
  if (encoder.is_broken || encoder.mesh.faces.empty()) return false;
  EncodeOptions options{encoder.bits};
  options.storage = keeps_order ? Storage::kInOrder : Storage::kOneStream;
  options.keep_duplicates = true;  // as Blender's own library does
  options.encode_speed =
      kMostEncodeSpeed - static_cast<int>(std::min<uint32_t>(encoder.level, kMostEncodeSpeed));
  Expected<EncodedMesh> encoded = psplit::encode(encoder.mesh, options, ThreadPool(1));
  if (!encoded) return false;
  encoder.stream = std::move(encoded->pieces[0]);
  return true;
}

int bits_of(uint32_t bits) { return static_cast<int>(std::min<uint32_t>(bits, kMostGridBits)); }

}  // namespace
}  // namespace psplit::blender

Encoder* encoderCreate(uint32_t vertexCount) {
  return without_exceptions<Encoder*>(nullptr, [&] {
    auto* const encoder = new Encoder;
    encoder->mesh.point_count = vertexCount;
    return encoder;
  });
}
void encoderRelease(Encoder* encoder) { delete encoder; }

void encoderSetCompressionLevel(Encoder* encoder, uint32_t compressionLevel) {
  if (encoder != nullptr) encoder->level = compressionLevel;
}
void encoderSetQuantizationBits(Encoder* encoder, uint32_t position, uint32_t normal, uint32_t uv,
                                uint32_t color, uint32_t generic) {
  using psplit::blender::bits_of;
  if (encoder != nullptr)
    encoder->bits = {bits_of(position),
                     normal < 2 ? 0 : bits_of(normal),  // an octahedron has no fewer
                     bits_of(uv),
                     bits_of(color),
                     bits_of(generic),
                     false,
                     {true, true, true, true, true}};
}

void encoderSetIndices(Encoder* encoder, size_t indexComponentType, uint32_t indexCount, void* indices) {
  if (encoder == nullptr) return;
  const bool is_set = without_exceptions(false, [&] {
    psplit::blender::set_indices(*encoder, indexComponentType, indexCount, indices);
    return true;
  });
  if (!is_set) encoder->is_broken = true;
}

uint32_t encoderSetAttribute(Encoder* encoder, char* attributeName, size_t componentType, char* dataType,
                             void* data) {
  if (encoder == nullptr) return psplit::blender::kNoId;
  const uint32_t id = without_exceptions(psplit::blender::kNoId, [&] {
    return psplit::blender::set_attribute(*encoder, attributeName, componentType, dataType, data);
  });
  if (id == psplit::blender::kNoId) encoder->is_broken = true;
  return id;
}

bool encoderEncode(Encoder* encoder, uint8_t preserveTriangleOrder) {
  if (encoder == nullptr) return false;
  return without_exceptions(false,
                            [&] { return psplit::blender::encode(*encoder, preserveTriangleOrder != 0); });
}
uint32_t encoderGetEncodedVertexCount(Encoder* encoder) {
  return encoder == nullptr || !encoder->stream ? 0 : encoder->stream->decoded.point_count;
}
uint32_t encoderGetEncodedIndexCount(Encoder* encoder) {
  return encoder == nullptr || !encoder->stream
             ? 0
             : static_cast<uint32_t>(3 * encoder->stream->decoded.faces.size());
}
uint64_t encoderGetByteLength(Encoder* encoder) {
  return encoder == nullptr || !encoder->stream ? 0 : encoder->stream->bytes.size();
}
void encoderCopy(Encoder* encoder, uint8_t* data) {
  if (encoder == nullptr || !encoder->stream || data == nullptr) return;
  std::memcpy(data, encoder->stream->bytes.data(), encoder->stream->bytes.size());
}
