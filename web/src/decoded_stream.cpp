#include "web/src/decoded_stream.h"

#include <algorithm>
#include <cstring>

#include "src/container/claims.h"
#include "src/core/workspace.h"
#include "src/cpu/convert.h"

namespace psplit::web {

using core::DataType;
using core::Fault;

// A module for Draco streams alone leaves out the code for condensed streams. The other module has it anyway,
// so that one decoder serves both.
#if defined(PSPLIT_ONLY_DRACO)
constexpr auto kKinds = core::StreamKinds::kDraco;
#else
constexpr auto kKinds = core::StreamKinds::kBoth;
#endif

Expected<std::unique_ptr<DecodedStream>> DecodedStream::decode(std::unique_ptr<uint8_t[]> bytes, size_t size) {
  const Expected<core::StreamHeader> header = read_stream_header({bytes.get(), size});
  if (!header) return header.status();
  std::unique_ptr<DecodedStream> stream(new DecodedStream());
  stream->bytes_ = std::move(bytes);
  // Most streams have no more attributes than these. The others are decoded again, in more memory.
  core::ValueCounts values{core::likely_points(*header), 3, 8};
  const uint64_t most = core::justified_bytes(size);
  uint64_t memory_bytes = core::workspace_bytes<uint32_t>(*header, size, values);
  for (;; memory_bytes *= 2) {
    memory_bytes = std::min(memory_bytes, most);
    if (memory_bytes > SIZE_MAX) return status_of(Fault::kWorkspace);
    core::Arena arena = stream->scratch_.streams[0].arena(static_cast<size_t>(memory_bytes));
    stream->patch_ = {};
    const Fault fault = core::decode_patch<uint32_t, kKinds>(*header, arena, stream->patch_);
    if (fault == Fault::kNone) return stream;
    if (fault != Fault::kWorkspace || memory_bytes == most) return status_of(fault);
  }
}

void ValuePlaces::Conversion::convert() {
  fits &= convert_components(value, attribute.type, attribute.normalized, attribute.components, type, out);
  out += attribute.components * core::data_type_bytes(type);
}

void DecodedStream::write_faces(uint32_t index_bytes, void* out) const {
  const auto write = [&](auto* index) {
    for (uint32_t face = 0; face < patch_.face_count; ++face)
      for (uint32_t k = 0; k < 3; ++k)
        *index++ = static_cast<std::remove_pointer_t<decltype(index)>>(patch_.point_at[4 * face + k]);
  };
  index_bytes == 2 ? write(static_cast<uint16_t*>(out)) : write(static_cast<uint32_t*>(out));
}

bool DecodedStream::write_attribute(const Attribute& attribute, DataType type, uint8_t* out) const {
  if (type == attribute.type) {
    patch_.write_values(attribute, ValuePlaces(out, attribute.stride()));
    return true;
  }
  ValuePlaces::Conversion conversion{attribute, type, out};
  patch_.write_values(attribute, ValuePlaces(conversion));
  if (patch_.point_count > 0) conversion.convert();
  return conversion.fits;
}

bool DecodedStream::write_integers(const Attribute& attribute, int32_t* out) const {
  const uint32_t components = attribute.value_components(), stride = core::value_stride(components);
  if (attribute.coding != core::Coding::kQuantized && attribute.coding != core::Coding::kNormal) return false;
  const auto& vertex_at = patch_.groups[attribute.group].table.table.vertex;
  for (uint32_t point = 0; point < patch_.point_count; ++point) {
    const uint32_t vertex = patch_.corner_of_point.empty() ? point : vertex_at[patch_.corner_of_point[point]];
    const int32_t* const value = &attribute.values[size_t{vertex} * stride];
    for (uint32_t k = 0; k < components; ++k) *out++ = value[k];
  }
  return true;
}

}  // namespace psplit::web
