#include "bindings/web/src/decoded_stream.h"

#include <cstring>

#include "bindings/web/src/heap.h"
#include "src/container/claims.h"
#include "src/core/decode_cloud.h"
#include "src/cpu/convert.h"

namespace psplit::web {
using core::Fault;

// A module for Draco streams alone leaves out the code for condensed streams. The other module has it anyway,
// so that one decoder serves both, and leaves out point clouds: its functions make meshes.
#if defined(PSPLIT_ONLY_DRACO)
constexpr auto kKinds = core::StreamKinds::kDraco;

Expected<core::CloudHeader> read_header(std::span<const uint8_t> stream) {
  core::CloudHeader header;
  const Fault fault = core::read_cloud_header(stream.data(), stream.size(), header);
  if (fault == Fault::kNone) return header;
  if (fault != Fault::kNotDraco) return status_of(fault);
  const Expected<core::StreamHeader> of_mesh = read_stream_header(stream);
  if (!of_mesh) return of_mesh.status();
  static_cast<core::StreamHeader&>(header) = *of_mesh;
  return header;
}
Fault decode_stream(const core::CloudHeader& header, core::Arena& arena, DecodedStream::Patch& patch) {
  return header.is_cloud ? core::decode_cloud<uint32_t, kKinds>(header, arena, patch)
                         : core::decode_patch<uint32_t, kKinds>(header, arena, patch);
}
#else
constexpr auto kKinds = core::StreamKinds::kBoth;

constexpr auto read_header = read_stream_header;
constexpr auto decode_stream = core::decode_patch<uint32_t, kKinds>;
#endif

Expected<std::unique_ptr<DecodedStream>> DecodedStream::decode(std::unique_ptr<uint8_t[]> bytes, size_t size) {
  const auto header = read_header({bytes.get(), size});
  if (!header) return header.status();
  std::unique_ptr<DecodedStream> stream(new DecodedStream());
  stream->bytes_ = std::move(bytes);
  // The heap grows as arrays are taken.
  constexpr size_t kFirstBytes = 4096;
  stream->memory_.reset(static_cast<uint8_t*>(allocate_last(kFirstBytes)));
  if (stream->memory_ == nullptr) return status_of(Fault::kWorkspace);
  const auto grow = [](uint8_t* memory, size_t wanted) { return resize(memory, wanted) ? wanted : 0; };
  const auto most = static_cast<size_t>(core::justified_bytes(size));
  core::Arena arena(stream->memory_.get(), kFirstBytes, most, grow);
  const Fault fault = decode_stream(*header, arena, stream->patch_);
  if (fault != Fault::kNone) {
    stream.reset();  // before a message takes memory after it
    return status_of(fault);
  }
  resize(stream->memory_.get(), arena.mark());
  stream->close_up_faces();
  return stream;
}

// Leaves out the unused fourth corners. Nothing else needs the points of corners any more: corner_of_point is
// empty if they are the mesh's vertices.
void DecodedStream::close_up_faces() {
  const uint32_t* from = patch_.point_at.data();
  uint32_t* to = patch_.point_at.data();
  for (uint32_t face = 0; face < patch_.face_count; ++face, from += 4)
    for (uint32_t k = 0; k < 3; ++k) *to++ = from[k];
}

void DecodedStream::write_faces(uint32_t index_bytes, void* out) const {
  const size_t count = size_t{3} * patch_.face_count;
  if (index_bytes == 4) {
    std::memcpy(out, faces(), count * sizeof(uint32_t));
    return;
  }
  for (size_t i = 0; i < count; ++i) static_cast<uint16_t*>(out)[i] = static_cast<uint16_t>(faces()[i]);
}

bool DecodedStream::write_attribute(const Attribute& attribute, DataType type, uint8_t* out) const {
  const size_t stride = attribute.stride();
  if (type == attribute.type) {
    patch_.write_values(attribute, ValuePlaces(out, stride));
    return true;
  }
  const size_t out_stride = attribute.components * core::data_type_bytes(type), points = patch_.point_count;
  // Values that are no larger than the converted ones wait at the end of these.
  std::unique_ptr<uint8_t[]> larger(stride > out_stride ? new uint8_t[stride * points] : nullptr);
  uint8_t* const values = larger != nullptr ? larger.get() : out + (out_stride - stride) * points;
  patch_.write_values(attribute, ValuePlaces(values, stride));
  return convert_components(values, attribute.type, attribute.normalized, attribute.components * points, type,
                            out);
}

// The vertex of a point in the table of the attribute's group.
uint32_t DecodedStream::vertex_of(const Attribute& attribute, uint32_t point) const {
  if (patch_.corner_of_point.empty()) return point;
  return patch_.groups[attribute.group].table.table.vertex[patch_.corner_of_point[point]];
}

bool DecodedStream::write_integers(const Attribute& attribute, int32_t* out) const {
  const uint32_t components = attribute.value_components(), stride = core::value_stride(components);
  if (attribute.coding == core::Coding::kRaw) return false;
  for (uint32_t point = 0; point < patch_.point_count; ++point) {
    const int32_t* const value = &attribute.values[size_t{vertex_of(attribute, point)} * stride];
    for (uint32_t k = 0; k < components; ++k) *out++ = value[k];
  }
  return true;
}

void DecodedStream::write_value_numbers(const Attribute& attribute, uint32_t* out) const {
  const auto& rank = patch_.groups[attribute.group].sequence.rank;
  for (uint32_t point = 0; point < patch_.point_count; ++point) *out++ = rank[vertex_of(attribute, point)];
}

}  // namespace psplit::web
