#include "encoder/draco/draco_backend.h"

#include <draco/attributes/attribute_octahedron_transform.h>
#include <draco/attributes/attribute_quantization_transform.h>
#include <draco/compression/decode.h>
#include <draco/core/draco_version.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>

#include "encoder/draco/describe_attribute.h"
#include "encoder/stitching/stitch_map.h"
#include "src/container/claims.h"
#include "src/core/stream_header.h"

namespace psplit {
namespace {

struct DracoMesh {
  std::unique_ptr<draco::Mesh> mesh;
};

// Streams before 1.3 give all their attributes the id 0.
bool has_no_unique_ids(std::span<const uint8_t> stream) {
  constexpr size_t kMajor = 5, kMinor = 6;
  return stream.size() > kMinor && (stream[kMajor] < 1 || (stream[kMajor] == 1 && stream[kMinor] < 3));
}

// Attributes without unique ids get their places for ids.
Expected<DracoMesh> decode_mesh(std::span<const uint8_t> stream, bool keep_quantized) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
  draco::Decoder decoder;
  if (keep_quantized)
    for (int type = 0; type < draco::GeometryAttribute::NAMED_ATTRIBUTES_COUNT; ++type)
      decoder.SetSkipAttributeTransform(static_cast<draco::GeometryAttribute::Type>(type));
  // libdraco sizes arrays from what the stream claims.
  const Status too_large = invalid_input("Draco stream: claims more data than memory can hold");
  try {
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (decoded.ok()) {
      DracoMesh decoded_mesh{std::move(decoded).value()};
      if (has_no_unique_ids(stream))
        for (int32_t i = 0; i < decoded_mesh.mesh->num_attributes(); ++i)
          decoded_mesh.mesh->attribute(i)->set_unique_id(static_cast<uint32_t>(i));
      return decoded_mesh;
    }
    const char* reason = decoded.status().error_msg();
    return invalid_input(std::string("Draco stream: ") + (*reason != 0 ? reason : "libdraco cannot decode it"));
  } catch (const std::bad_alloc&) {
    return too_large;
  } catch (const std::length_error&) {
    return too_large;
  }
}

// What libdraco leaves to its caller.
constexpr const char* kNoSuchPoint = "Draco stream: a face names a point that is not there";
bool has_its_points(const draco::Mesh::Face& face, uint32_t point_count) {
  return std::ranges::all_of(face, [&](draco::PointIndex point) { return point.value() < point_count; });
}

// Of streams that libdraco decodes; its API does not tell.
bool is_bitstream_2_2(std::span<const uint8_t> stream) { return stream[5] == 2 && stream[6] == 2; }
StreamCoding read_coding(std::span<const uint8_t> stream) {
  core::ByteReader reader(stream.data(), stream.size());
  reader.skip(8);  // magic, version, kind
  if (reader.u8() == 0) return StreamCoding::kSequential;
  if (constexpr uint32_t kHasMetadata = 0x8000; (reader.u16() & kHasMetadata) != 0)
    (void)core::skip_metadata(reader);
  const uint8_t traversal = reader.u8();
  return traversal == 0   ? StreamCoding::kEdgebreaker
         : traversal == 1 ? StreamCoding::kEdgebreakerPredictive
                          : StreamCoding::kEdgebreakerValence;
}

// Of an attribute whose transform was left undone.
void describe_quantization(const draco::PointAttribute& attribute, StreamAttribute& out) {
  const draco::AttributeTransformData* data = attribute.GetAttributeTransformData();
  const auto type = data == nullptr ? draco::ATTRIBUTE_NO_TRANSFORM : data->transform_type();
  draco::AttributeQuantizationTransform quantization;
  draco::AttributeOctahedronTransform octahedron;
  if (type == draco::ATTRIBUTE_QUANTIZATION_TRANSFORM && quantization.InitFromAttribute(attribute)) {
    out.bits = static_cast<uint8_t>(quantization.quantization_bits());
    out.range = quantization.range();
    out.origin = quantization.min_values();
  }
  if (type == draco::ATTRIBUTE_OCTAHEDRON_TRANSFORM && octahedron.InitFromAttribute(attribute))
    out.bits = static_cast<uint8_t>(octahedron.quantization_bits());
}

std::string describe(const AttributeRequest& request) {
  return request.semantic + " (unique id " + std::to_string(request.unique_id) + ")";
}

draco::DataType draco_type(ComponentType type) {
  switch (type) {
    case ComponentType::kInt8: return draco::DT_INT8;
    case ComponentType::kUint8: return draco::DT_UINT8;
    case ComponentType::kInt16: return draco::DT_INT16;
    case ComponentType::kUint16: return draco::DT_UINT16;
    case ComponentType::kUint32: return draco::DT_UINT32;
    case ComponentType::kFloat32: return draco::DT_FLOAT32;
  }
  return draco::DT_INVALID;
}

template <typename T>
bool convert_value(const draco::PointAttribute& attribute, draco::AttributeValueIndex index, uint8_t components,
                   std::byte* out) {
  std::array<T, 16> value{};
  if (!attribute.ConvertValue<T>(index, static_cast<int8_t>(components), value.data())) return false;
  std::memcpy(out, value.data(), components * sizeof(T));
  return true;
}

// Assets may declare an accessor type that differs from the stream's (normalized or wider integers): libdraco's
// own conversion then decides, as it does in every loader.
bool convert(const draco::PointAttribute& attribute, draco::AttributeValueIndex index,
             const AttributeRequest& request, std::byte* out) {
  const uint8_t components = request.component_count;
  switch (request.component_type) {
    case ComponentType::kInt8: return convert_value<int8_t>(attribute, index, components, out);
    case ComponentType::kUint8: return convert_value<uint8_t>(attribute, index, components, out);
    case ComponentType::kInt16: return convert_value<int16_t>(attribute, index, components, out);
    case ComponentType::kUint16: return convert_value<uint16_t>(attribute, index, components, out);
    case ComponentType::kUint32: return convert_value<uint32_t>(attribute, index, components, out);
    case ComponentType::kFloat32: return convert_value<float>(attribute, index, components, out);
  }
  return false;
}

Expected<Mesh> decode_stream(std::span<const uint8_t> stream, std::span<const AttributeRequest> requests) {
  Expected<DecodedStream> decoded = decode_draco_stream(stream, requests);
  if (!decoded) return decoded.status();
  Mesh mesh;
  mesh.point_count = decoded->point_count;
  mesh.faces = std::move(decoded->faces);
  for (size_t i = 0; i < requests.size(); ++i)
    mesh.attributes.push_back({requests[i].semantic, requests[i].component_type, requests[i].component_count,
                               requests[i].normalized, std::move(decoded->values[i])});
  return mesh;
}

Expected<Mesh> decode_container(std::span<const uint8_t> bytes, std::span<const AttributeRequest> requests,
                                const ThreadPool& pool) {
  const Expected<Container> container = parse_container(bytes);
  if (!container) return container.status();
  const size_t count = container->entries.size();
  std::vector<DecodedStream> streams(count);
  std::vector<Status> statuses(count);
  pool.for_each(count, [&](size_t i) {
    const StreamEntry& entry = container->entries[i];
    Expected<DecodedStream> stream = decode_draco_stream(container->streams[i], requests);
    const bool is_residue = i >= container->patch_count();
    if (!stream)
      statuses[i] = stream.status();
    else if (!is_bitstream_2_2(container->streams[i]))
      statuses[i] = wrong_version(container->streams[i]);
    else if ((read_coding(container->streams[i]) == StreamCoding::kSequential) != is_residue)
      statuses[i] = wrong_coding(is_residue);
    else if (stream->point_count != entry.point_count)
      statuses[i] = invalid_input("the stream has " + std::to_string(stream->point_count) +
                                  " points, the directory says " + std::to_string(entry.point_count));
    else if (is_residue ? stream->faces.size() < entry.face_count : stream->faces.size() != entry.face_count)
      statuses[i] = invalid_input("the stream has " + std::to_string(stream->faces.size()) +
                                  " faces, the directory says " + std::to_string(entry.face_count));
    else {
      streams[i] = std::move(*stream);
      // A sequential stream needs faces to carry points that no face uses; the directory does not count them.
      streams[i].faces.resize(entry.face_count);
    }
    if (!statuses[i].ok()) statuses[i] = std::move(statuses[i]).at({.patch = static_cast<int64_t>(i)});
  });
  for (Status& status : statuses)
    if (!status.ok()) return std::move(status);

  std::vector<std::span<const Face>> faces;
  faces.reserve(count);
  for (const DecodedStream& stream : streams) faces.emplace_back(stream.faces);
  const auto numbers = number_points(*container, faces, pool);
  if (!numbers) return numbers.status();

  Mesh mesh;
  mesh.point_count = container->point_count();
  mesh.faces.resize(container->face_count());
  for (const AttributeRequest& request : requests) {
    Attribute attribute{
        request.semantic, request.component_type, request.component_count, request.normalized, {}};
    attribute.values.resize(size_t{mesh.point_count} * attribute.stride());
    mesh.attributes.push_back(std::move(attribute));
  }
  pool.for_each(count, [&](size_t i) {
    const std::vector<uint32_t>& number = (*numbers)[i];
    Face* out = mesh.faces.data() + container->face_base[i];
    for (const Face& face : streams[i].faces) *out++ = {number[face[0]], number[face[1]], number[face[2]]};
    // The owner writes, and copies hold the same bits. What a patch owns is numbered in the order of its
    // points.
    uint32_t next = container->owned_base[i];
    for (uint32_t point = 0; point < streams[i].point_count; ++point) {
      if (number[point] != next) continue;
      ++next;
      for (size_t k = 0; k < requests.size(); ++k) {
        const size_t stride = mesh.attributes[k].stride();
        std::memcpy(mesh.attributes[k].values.data() + number[point] * stride,
                    streams[i].values[k].data() + point * stride, stride);
      }
    }
  });
  return mesh;
}

}  // namespace

Expected<DecodedStream> decode_draco_stream(std::span<const uint8_t> stream,
                                            std::span<const AttributeRequest> requests) {
  Expected<DracoMesh> decoded = decode_mesh(stream, false);
  if (!decoded) return decoded.status();
  const draco::Mesh& mesh = *decoded->mesh;
  DecodedStream out;
  out.point_count = mesh.num_points();
  out.faces.reserve(mesh.num_faces());
  for (uint32_t i = 0; i < mesh.num_faces(); ++i) {
    const draco::Mesh::Face& face = mesh.face(draco::FaceIndex(i));
    if (!has_its_points(face, out.point_count)) return invalid_input(kNoSuchPoint);
    out.faces.push_back({face[0].value(), face[1].value(), face[2].value()});
  }
  for (const AttributeRequest& request : requests) {
    const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(request.unique_id);
    if (attribute == nullptr) return invalid_input("Draco stream: no attribute for " + describe(request));
    if (request.component_count == 0 || request.component_count > 16 ||
        attribute->num_components() != request.component_count)
      return invalid_input("Draco stream: " + describe(request) + " has " +
                           std::to_string(attribute->num_components()) + " components, not " +
                           std::to_string(request.component_count));
    const size_t stride = component_bytes(request.component_type) * request.component_count;
    Array<std::byte> values(out.point_count * stride);
    const bool same_type = attribute->data_type() == draco_type(request.component_type);
    for (uint32_t i = 0; i < out.point_count; ++i) {
      const draco::AttributeValueIndex index = attribute->mapped_index(draco::PointIndex(i));
      if (index.value() >= attribute->size())
        return invalid_input("Draco stream: a point of " + describe(request) + " has no value");
      if (same_type)
        std::memcpy(values.data() + i * stride, attribute->GetAddress(index), stride);
      else if (!convert(*attribute, index, request, values.data() + i * stride))
        return invalid_input("Draco stream: a value of " + describe(request) +
                             " does not fit its accessor's type");
    }
    out.values.push_back(std::move(values));
  }
  return out;
}

Expected<StreamCounts> stream_counts(std::span<const uint8_t> stream) {
  const Expected<DracoMesh> decoded = decode_mesh(stream, false);
  if (!decoded) return decoded.status();
  return StreamCounts{decoded->mesh->num_faces(), decoded->mesh->num_points()};
}

Expected<StreamDescription> describe_draco_stream(std::span<const uint8_t> stream) {
  const Expected<DracoMesh> decoded = decode_mesh(stream, false);
  if (!decoded) return decoded.status();
  // Bits are known only where the transform is left undone, types only where it is done.
  const Expected<DracoMesh> quantized = decode_mesh(stream, true);
  if (!quantized) return quantized.status();
  StreamDescription description;
  description.coding = read_coding(stream);
  description.face_count = decoded->mesh->num_faces();
  description.point_count = decoded->mesh->num_points();
  for (uint32_t i = 0; i < description.face_count; ++i)
    if (!has_its_points(decoded->mesh->face(draco::FaceIndex(i)), description.point_count))
      return invalid_input(kNoSuchPoint);
  for (int32_t i = 0; i < decoded->mesh->num_attributes(); ++i) {
    description.attributes.push_back(describe_attribute(*decoded->mesh->attribute(i)));
    describe_quantization(*quantized->mesh->attribute(i), description.attributes.back());
  }
  return description;
}

std::string draco_version() { return draco::kDracoVersion; }

DecodeBackend draco_backend() { return one_by_one("draco", decode_container, decode_stream); }

}  // namespace psplit
