#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "bindings/c/blender/bridge.h"
#include "bindings/c/blender/element_type.h"
#include "bindings/c/no_throw.h"
#include "encoder/libdraco/draco_backend.h"
#include "psplit/decode.h"
#include "src/container/stored_type.h"
#include "src/cpu/convert.h"

using psplit::c::without_exceptions;

struct Decoder {
  psplit::DracoGeometry geometry{};
  // A stream that only libdraco decodes. `geometry` then has no values.
  std::vector<uint8_t> old_stream{};
  std::vector<std::byte> indices{};
  std::map<size_t, std::vector<std::byte>> attributes{};  // that were read, by their ids

  const psplit::GeometryAttribute* find(uint32_t id) const {
    for (const psplit::GeometryAttribute& attribute : geometry.attributes)
      if (attribute.description.unique_id == id) return &attribute;
    return nullptr;
  }
};

namespace psplit::blender {
namespace {

bool decode_old_stream(std::span<const uint8_t> stream, Decoder& decoder) {
  const Expected<StreamDescription> description = describe_draco_stream(stream);
  if (!description) return false;
  Expected<Mesh> mesh = decode_draco_stream(stream, {});
  if (!mesh) return false;
  decoder.geometry.point_count = mesh->point_count;
  decoder.geometry.faces = std::move(mesh->faces);
  for (const StreamAttribute& attribute : description->attributes)
    decoder.geometry.attributes.push_back({attribute, {}});
  decoder.old_stream.assign(stream.begin(), stream.end());
  return true;
}

bool decode(std::span<const uint8_t> stream, Decoder& decoder) {
  decoder = {};
  Expected<DracoGeometry> geometry = decode_geometry(stream);
  if (!geometry)
    return geometry.status().code() == StatusCode::kUnsupported && decode_old_stream(stream, decoder);
  if (is_cloud(geometry->coding)) return false;  // the add-on asks for meshes
  decoder.geometry = std::move(*geometry);
  return true;
}

std::optional<std::vector<std::byte>> read_old_values(const Decoder& decoder, const AttributeRequest& request) {
  Expected<Mesh> mesh = decode_draco_stream(decoder.old_stream, {&request, 1});
  if (!mesh) return std::nullopt;
  const Array<std::byte>& values = mesh->attributes[0].values;
  return std::vector<std::byte>(values.begin(), values.end());
}

std::optional<std::vector<std::byte>> read_values(const Decoder& decoder, const GeometryAttribute& attribute,
                                                  const AttributeRequest& request) {
  const DataType from = attribute.description.type, to = stored_type(request.component_type);
  const Array<std::byte>& values = attribute.values;
  if (from == to) return std::vector<std::byte>(values.begin(), values.end());
  const size_t points = decoder.geometry.point_count;
  std::vector<std::byte> converted(points * request.value_bytes());
  if (!convert_components(reinterpret_cast<const uint8_t*>(values.data()), from,
                          attribute.description.normalized, points * attribute.description.components, to,
                          reinterpret_cast<uint8_t*>(converted.data())))
    return std::nullopt;
  return converted;
}

bool read_attribute(Decoder& decoder, uint32_t id, size_t component_type, const char* data_type) {
  const GeometryAttribute* const attribute = decoder.find(id);
  const std::optional<ComponentType> type = component_type_of(component_type);
  if (attribute == nullptr || !type || component_count_of(data_type) != attribute->description.components)
    return false;
  const AttributeRequest request{"", id, *type, attribute->description.components, false};
  std::optional<std::vector<std::byte>> values = decoder.old_stream.empty()
                                                     ? read_values(decoder, *attribute, request)
                                                     : read_old_values(decoder, request);
  if (!values) return false;
  decoder.attributes[id] = std::move(*values);
  return true;
}

bool read_indices(Decoder& decoder, size_t component_type) {
  const std::optional<ComponentType> type = component_type_of(component_type);
  if (!type || *type == ComponentType::kFloat32) return false;
  const size_t bytes = component_bytes(*type);
  const bool is_signed = *type == ComponentType::kInt8 || *type == ComponentType::kInt16;
  const uint64_t most = (uint64_t{1} << (8 * bytes - (is_signed ? 1 : 0))) - 1;
  std::vector<std::byte> indices(3 * decoder.geometry.faces.size() * bytes);
  std::byte* to = indices.data();
  for (const std::array<uint32_t, 3>& face : decoder.geometry.faces)
    for (const uint32_t point : face) {
      if (point > most) return false;
      std::memcpy(to, &point, bytes);  // little-endian
      to += bytes;
    }
  decoder.indices = std::move(indices);
  return true;
}

}  // namespace
}  // namespace psplit::blender

Decoder* decoderCreate() {
  return without_exceptions<Decoder*>(nullptr, [] { return new Decoder; });
}
void decoderRelease(Decoder* decoder) { delete decoder; }

bool decoderDecode(Decoder* decoder, void* data, size_t byteLength) {
  if (decoder == nullptr || (data == nullptr && byteLength > 0)) return false;
  return without_exceptions(false, [&] {
    return psplit::blender::decode({static_cast<const uint8_t*>(data), byteLength}, *decoder);
  });
}
uint32_t decoderGetVertexCount(Decoder* decoder) {
  return decoder == nullptr ? 0 : decoder->geometry.point_count;
}
uint32_t decoderGetIndexCount(Decoder* decoder) {
  return decoder == nullptr ? 0 : static_cast<uint32_t>(3 * decoder->geometry.faces.size());
}
bool decoderAttributeIsNormalized(Decoder* decoder, uint32_t id) {
  const psplit::GeometryAttribute* const attribute = decoder == nullptr ? nullptr : decoder->find(id);
  return attribute != nullptr && attribute->description.normalized;
}

bool decoderReadAttribute(Decoder* decoder, uint32_t id, size_t componentType, char* dataType) {
  if (decoder == nullptr) return false;
  return without_exceptions(
      false, [&] { return psplit::blender::read_attribute(*decoder, id, componentType, dataType); });
}
size_t decoderGetAttributeByteLength(Decoder* decoder, size_t id) {
  if (decoder == nullptr) return 0;
  const auto found = decoder->attributes.find(id);
  return found == decoder->attributes.end() ? 0 : found->second.size();
}
void decoderCopyAttribute(Decoder* decoder, size_t id, void* output) {
  const size_t bytes = decoderGetAttributeByteLength(decoder, id);
  if (bytes > 0 && output != nullptr) std::memcpy(output, decoder->attributes.find(id)->second.data(), bytes);
}

bool decoderReadIndices(Decoder* decoder, size_t indexComponentType) {
  if (decoder == nullptr) return false;
  return without_exceptions(false, [&] { return psplit::blender::read_indices(*decoder, indexComponentType); });
}
size_t decoderGetIndicesByteLength(Decoder* decoder) {
  return decoder == nullptr ? 0 : decoder->indices.size();
}
void decoderCopyIndices(Decoder* decoder, void* output) {
  if (decoder == nullptr || output == nullptr || decoder->indices.empty()) return;
  std::memcpy(output, decoder->indices.data(), decoder->indices.size());
}
