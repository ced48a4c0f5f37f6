#include "encoder/libdraco/draco_backend.h"

#include <draco/attributes/attribute_octahedron_transform.h>
#include <draco/attributes/attribute_quantization_transform.h>
#include <draco/compression/decode.h>
#include <draco/core/draco_version.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>

#include "encoder/fields/expand_container.h"
#include "encoder/libdraco/draco_types.h"
#include "encoder/libdraco/unfused_values.h"
#include "encoder/stitching/stitch_map.h"
#include "psplit/encode.h"
#include "src/container/claims.h"
#include "src/container/write_faces.h"
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
  // libdraco sizes arrays from what the stream claims.
  const Status too_large = invalid_input("Draco stream: claims more data than memory can hold");
  try {
    auto decoded = decode_unfused(stream, keep_quantized);
    if (decoded.ok()) {
      DracoMesh decoded_mesh{std::move(decoded).value()};
      // Only libdraco built for its transcoder knows more types than the bitstream.
      for (int32_t i = 0; i < decoded_mesh.mesh->num_attributes(); ++i)
        if (decoded_mesh.mesh->attribute(i)->attribute_type() > draco::GeometryAttribute::GENERIC)
          return invalid_input("Draco stream: an attribute of an unknown type");
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

// libdraco leaves this check to its caller.
constexpr const char* kNoSuchPoint = "Draco stream: a face names a point that is not there";
bool has_its_points(const draco::Mesh::Face& face, uint32_t point_count) {
  return std::ranges::all_of(face, [&](draco::PointIndex point) { return point.value() < point_count; });
}

// Reads the coding of a stream that libdraco decodes. libdraco's API does not tell it.
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

// The grid of an attribute whose transform was skipped.
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

template <typename T>
bool convert_value(const draco::PointAttribute& attribute, draco::AttributeValueIndex index, uint8_t components,
                   std::byte* out) {
  std::array<T, 16> value{};
  if (attribute.data_type() == draco::DT_BOOL) {
    // libdraco would read a bool from a byte that may be neither 0 nor 1, which is undefined.
    const uint8_t* const bytes = attribute.GetAddress(index);
    for (size_t i = 0; i < components; ++i) {
      if (static_cast<double>(bytes[i]) > static_cast<double>(std::numeric_limits<T>::max())) return false;
      value[i] = static_cast<T>(bytes[i]);
    }
  } else if (!attribute.ConvertValue<T>(index, static_cast<int8_t>(components), value.data())) {
    return false;
  }
  std::memcpy(out, value.data(), components * sizeof(T));
  return true;
}

// Accessors may declare another type than the stream's (normalized or wider integers). libdraco's own
// conversion then decides, as it does in every loader.
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

// The attribute of each request, after a check that its values can be written.
Expected<std::vector<const draco::PointAttribute*>> find_attributes(
    const draco::Mesh& mesh, std::span<const AttributeRequest> requests) {
  std::vector<const draco::PointAttribute*> found;
  for (const AttributeRequest& request : requests) {
    const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(request.unique_id);
    const auto components = attribute != nullptr ? static_cast<uint32_t>(attribute->num_components()) : 0;
    if (Status status = check_request(request, components); !status.ok()) return status;
    found.push_back(attribute);
  }
  return found;
}

Status check_faces(const draco::Mesh& mesh) {
  for (uint32_t i = 0; i < mesh.num_faces(); ++i)
    if (!has_its_points(mesh.face(draco::FaceIndex(i)), mesh.num_points())) return invalid_input(kNoSuchPoint);
  return {};
}

Status write_values(const draco::PointAttribute& attribute, uint32_t point_count,
                    const AttributeRequest& request, const AttributeBuffer& out) {
  const bool same_type = attribute.data_type() == draco_type(request.component_type);
  for (uint32_t point = 0; point < point_count; ++point) {
    const draco::AttributeValueIndex index = attribute.mapped_index(draco::PointIndex(point));
    if (index.value() >= attribute.size())
      return invalid_input("Draco stream: a point of " + describe(request) + " has no value");
    std::byte* const value = out.bytes.data() + point * out.stride;
    if (same_type)
      std::memcpy(value, attribute.GetAddress(index), request.value_bytes());
    else if (!convert(attribute, index, request, value))
      return invalid_input("Draco stream: a value of " + describe(request) +
                           " does not fit its accessor's type");
  }
  return {};
}

constexpr uint32_t kAllFaces = 0xffffffffu;

// Decodes a stream into the memory that buffers_for(point_count, face_count) gives. Writes its first
// `most_faces` faces: a residue has more faces than its row counts.
template <typename BuffersForCounts>
Status decode_stream(std::span<const uint8_t> stream, std::span<const AttributeRequest> requests,
                     uint32_t most_faces, BuffersForCounts buffers_for) {
  const Expected<DracoMesh> decoded = decode_mesh(stream, false);
  if (!decoded) return decoded.status();
  const draco::Mesh& mesh = *decoded->mesh;
  if (Status status = check_faces(mesh); !status.ok()) return status;
  const auto attributes = find_attributes(mesh, requests);
  if (!attributes) return attributes.status();
  const uint32_t face_count = std::min(most_faces, mesh.num_faces());
  const Expected<PrimitiveBuffers> out = buffers_for(mesh.num_points(), face_count);
  if (!out) return out.status();
  write_faces(face_count, out->indices.data(), out->index_bytes,
              [&](uint32_t face, uint32_t k) { return mesh.face(draco::FaceIndex(face))[k].value(); });
  for (size_t i = 0; i < requests.size(); ++i)
    if (Status status = write_values(*(*attributes)[i], mesh.num_points(), requests[i], out->attributes[i]);
        !status.ok())
      return status;
  return {};
}

// Returns decode(stream) of a patch's Draco stream. libdraco knows only Draco streams, so condensed ones are
// expanded first.
template <typename Result, typename Decode>
Result with_draco_stream(const PatchContainer& container, uint32_t patch, Decode decode) {
  if (!container.entries[patch].is_condensed) return decode(container.streams[patch]);
  const Expected<std::vector<uint8_t>> stream = expand_patch(container, patch);
  return stream ? decode(*stream) : stream.status();
}

Expected<Mesh> decode_patch(const PatchContainer& container, uint32_t patch,
                            std::span<const AttributeRequest> requests) {
  Expected<Mesh> mesh = with_draco_stream<Expected<Mesh>>(
      container, patch, [&](std::span<const uint8_t> stream) { return decode_draco_stream(stream, requests); });
  if (!mesh) return mesh;
  const StreamEntry& entry = container.entries[patch];
  const auto face_count = static_cast<uint32_t>(mesh->faces.size());
  if (mesh->point_count != entry.point_count)
    return differs_from_directory("points", mesh->point_count, entry.point_count);
  if (patch >= container.patch_count() ? face_count < entry.face_count : face_count != entry.face_count)
    return differs_from_directory("faces", face_count, entry.face_count);
  // A sequential stream needs faces to carry points that no face uses. The directory does not count them.
  mesh->faces.resize(entry.face_count);
  return mesh;
}

Status decode_container(const DecodeTask& task, const PrimitiveBuffers& out, const ThreadPool& pool) {
  const PatchContainer& container = *task.container;
  const size_t count = container.entries.size();
  std::vector<Mesh> patches(count);
  std::vector<Status> statuses(count);
  pool.for_each(count, [&](size_t i) {
    Expected<Mesh> patch = decode_patch(container, static_cast<uint32_t>(i), task.requests);
    statuses[i] = patch.status().at({.patch = static_cast<int64_t>(i)});
    if (patch) patches[i] = std::move(*patch);
  });
  for (Status& status : statuses)
    if (!status.ok()) return std::move(status);

  std::vector<std::span<const Face>> faces;
  faces.reserve(count);
  for (const Mesh& patch : patches) faces.emplace_back(patch.faces);
  const auto numbers = number_points(container, faces, pool);
  if (!numbers) return numbers.status();

  pool.for_each(count, [&](size_t i) {
    const std::vector<uint32_t>& number = (*numbers)[i];
    const std::span<std::byte> indices =
        out.indices.subspan(size_t{3} * out.index_bytes * container.face_base[i]);
    write_faces(container.entries[i].face_count, indices.data(), out.index_bytes,
                [&](uint32_t face, uint32_t k) { return number[faces[i][face][k]]; });
    // The owner writes, and copies hold the same bits. A patch numbers the points that it owns in their order.
    uint32_t next = container.owned_base[i];
    for (uint32_t point = 0; point < patches[i].point_count; ++point) {
      if (number[point] != next) continue;
      for (size_t k = 0; k < task.requests.size(); ++k) {
        const size_t size = task.requests[k].value_bytes();
        std::memcpy(out.attributes[k].bytes.data() + next * out.attributes[k].stride,
                    patches[i].attributes[k].values.data() + point * size, size);
      }
      ++next;
    }
  });
  return {};
}

std::vector<Status> decode_into(Span<const DecodeTask> tasks, const BuffersFor& buffers_for,
                                const ThreadPool& pool, const Watch& watch) {
  const auto decode = [&](size_t i) -> Status {
    if (watch.stopped()) return cancelled();
    const PatchContainer& container = *tasks[i].container;
    if (container.is_stock) {
      const uint32_t most_faces = container.refusal.ok() ? container.face_count() : kAllFaces;
      return with_draco_stream<Status>(container, 0, [&](std::span<const uint8_t> stream) {
        return decode_stream(stream, tasks[i].requests, most_faces,
                             [&](uint32_t points, uint32_t count) { return buffers_for(i, points, count); });
      });
    }
    const Expected<PrimitiveBuffers> out = buffers_for(i, container.point_count(), container.face_count());
    return out ? decode_container(tasks[i], *out, pool) : out.status();
  };
  std::vector<Status> statuses(tasks.size());
  std::atomic<size_t> done = 0;
  pool.for_each(tasks.size(), [&](size_t i) {
    statuses[i] = decode(i);
    if (watch.progress && statuses[i].code() != StatusCode::kCancelled) watch.progress(++done, tasks.size());
  });
  return statuses;
}

}  // namespace

Expected<Mesh> decode_draco_stream(Span<const uint8_t> stream, Span<const AttributeRequest> requests) {
  Mesh mesh;
  Status status = decode_stream(stream, requests, kAllFaces, [&](uint32_t points, uint32_t faces) {
    return allocate_mesh(points, faces, requests, stream.size(), mesh);
  });
  if (!status.ok()) return status;
  return mesh;
}

Expected<StreamDescription> describe_draco_stream(Span<const uint8_t> stream) {
  const Expected<DracoMesh> decoded = decode_mesh(stream, false);
  if (!decoded) return decoded.status();
  // Bits are known only if the transform is skipped, and types only if it is not.
  const Expected<DracoMesh> quantized = decode_mesh(stream, true);
  if (!quantized) return quantized.status();
  StreamDescription description;
  description.coding = read_coding(stream);
  description.face_count = decoded->mesh->num_faces();
  description.point_count = decoded->mesh->num_points();
  if (Status status = check_faces(*decoded->mesh); !status.ok()) return status;
  for (int32_t i = 0; i < decoded->mesh->num_attributes(); ++i) {
    description.attributes.push_back(describe_attribute(*decoded->mesh->attribute(i)));
    describe_quantization(*quantized->mesh->attribute(i), description.attributes.back());
  }
  return description;
}

std::string draco_version() { return draco::kDracoVersion; }

const OlderStreams* older_streams() {
  static constexpr OlderStreams kOlder{describe_draco_stream, decode_draco_stream};
  return &kOlder;
}

DecodeBackend draco_backend() { return {"draco", decode_into}; }

}  // namespace psplit
