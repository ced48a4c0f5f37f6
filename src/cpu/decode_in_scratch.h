// Decoding the patches of a container in a thread's scratch, and their values in the types that are requested.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "psplit/decode.h"
#include "src/container/border_values.h"
#include "src/container/claims.h"
#include "src/container/stored_type.h"
#include "src/container/write_faces.h"
#include "src/core/decode_cloud.h"
#include "src/cpu/convert.h"
#include "src/cpu/scratch.h"

namespace psplit {

using core::kInStep;

// The memory that any honest stream decodes in. Where faces are flat or have charts of their own, a stock
// stream has two points and more for each vertex: a short one gets memory for them, which costs nothing before
// it is touched.
template <typename Index>
size_t likely_size(const PatchContainer& container, uint32_t patch,
                   std::span<const AttributeRequest> requests) {
  constexpr uint64_t kMostForAVertex = sizeof(Index) == 2 ? 3 : 1;
  const uint64_t likely = container.likely_point_count(patch), stated = container.entries[patch].point_count;
  core::ValueCounts values{static_cast<uint32_t>(std::min(kMostForAVertex * likely, stated)),
                           static_cast<uint32_t>(requests.size()), 0};
  for (const AttributeRequest& request : requests) values.components += request.component_count;
  const size_t stream_bytes = container.streams[patch].size();
  // Without memory for their sums, normals are slower.
  const uint64_t bytes =
      uint64_t{core::workspace_bytes<Index>(container.headers[patch], stream_bytes, values)} +
      core::normal_sum_bytes(values.points);
  return static_cast<size_t>(std::min(bytes, core::justified_bytes(stream_bytes)));
}

// The header of a patch, in the memory of its stream, with the values at its border.
template <typename Index>
const core::StreamHeader& complete_header(const PatchContainer& container, const BorderValues& borders,
                                          uint32_t patch, StreamMemory<Index>& memory) {
  memory.header = container.headers[patch];
  borders.complete(patch, memory.header);
  return memory.header;
}

// Decodes a stream of `stream_bytes` bytes, and returns the status that use(arena) returns. decode(arena)
// returns a core::Fault. If it or `use`, which returns std::nullopt then, needs more memory than the first
// `size` bytes, decodes again in more memory, up to the amount that the stream's bytes justify.
template <typename Decode, typename Use>
Status decode_in_enough(StreamMemory<NarrowIndex>& memory, size_t size, size_t stream_bytes, Decode decode,
                        Use use) {
  const uint64_t most = core::justified_bytes(stream_bytes);
  for (size = static_cast<size_t>(std::min<uint64_t>(size, most));;
       size = static_cast<size_t>(std::min<uint64_t>(2 * memory.size, most))) {
    core::Arena arena = memory.arena(size);
    const core::Fault fault = decode(arena);
    if (fault == core::Fault::kNone) {
      if (std::optional<Status> status = use(arena)) return std::move(*status);
    } else if (fault != core::Fault::kWorkspace) {
      return status_of(fault);
    }
    if (memory.size >= most) return status_of(core::Fault::kWorkspace);
  }
}

// How much of a stream is decoded.
struct DecodeAll {
  template <typename Index>
  core::Fault operator()(const core::StreamHeader& header, core::Arena& arena, core::Patch<Index>& out) const {
    return core::decode_patch<Index>(header, arena, out);
  }
  core::Fault operator()(const core::CloudHeader& header, core::Arena& arena,
                         core::Patch<uint32_t>& out) const {
    return core::decode_cloud<uint32_t>(header, arena, out);
  }
};
struct DecodeOutline {
  template <typename Index>
  core::Fault operator()(const core::StreamHeader& header, core::Arena& arena, core::Patch<Index>& out) const {
    return core::outline_patch<Index>(header, arena, out);
  }
  core::Fault operator()(const core::CloudHeader& header, core::Arena& arena,
                         core::Patch<uint32_t>& out) const {
    return core::outline_cloud<uint32_t>(header, arena, out);
  }
};

// Decodes a patch, and returns the status that use(patch, arena) returns; std::nullopt stands for too little
// memory.
template <typename Decode = DecodeAll, typename Use>
Status with_decoded(const PatchContainer& container, const BorderValues& borders, uint32_t patch,
                    std::span<const AttributeRequest> requests, Scratch& scratch, Use use) {
  StreamMemory<NarrowIndex>& memory = scratch.streams[0];
  const core::StreamHeader& header = complete_header(container, borders, patch, memory);
  const auto decode = [&]<typename Index>(core::Patch<Index>& decoded) {
    return decode_in_enough(
        memory, likely_size<Index>(container, patch, requests), container.streams[patch].size(),
        [&](core::Arena& arena) {
          decoded = {};
          return Decode()(header, arena, decoded);
        },
        [&](core::Arena& arena) -> std::optional<Status> { return use(decoded, arena); });
  };
  return header.fits_16_bits() ? decode(memory.patch) : decode(scratch.wide);
}

// Decodes a point cloud, and returns the status that use(patch) returns.
template <typename Decode = DecodeAll, typename Use>
Status with_decoded_cloud(const core::CloudHeader& header, size_t stream_bytes, Scratch& scratch, Use use) {
  core::Patch<uint32_t>& decoded = scratch.wide;
  // As many values as most clouds have: a position, a normal and a colour.
  const core::ValueCounts likely{header.point_count, 3, 9};
  return decode_in_enough(
      scratch.streams[0], core::cloud_workspace_bytes<uint32_t>(header, stream_bytes, likely), stream_bytes,
      [&](core::Arena& arena) {
        decoded = {};
        return Decode()(header, arena, decoded);
      },
      [&](core::Arena&) -> std::optional<Status> { return use(decoded); });
}

// A stream to decode, of any container.
struct StreamTask {
  const PatchContainer* container;
  uint32_t patch;
  std::span<const AttributeRequest> requests;
};

// Decodes kCount streams in step, and calls use(n, patch, arena) for each. The containers share `borders`, or
// have none. Returns which streams are left for with_decoded: streams that did not decode, streams for which
// `use` is false because it needs more memory, and all if one of them is too large for 16-bit numbers.
template <uint32_t kCount, typename Use>
std::array<bool, kCount> decode_in_step(std::span<const StreamTask, kCount> tasks, const BorderValues& borders,
                                        Scratch& scratch, Use use) {
  static_assert(kCount <= kInStep);
  std::array<bool, kCount> left;
  left.fill(true);
  for (const StreamTask& task : tasks)
    if (!task.container->headers[task.patch].fits_16_bits()) return left;
  core::Arena arenas[kCount];
  core::PatchDecoder<NarrowIndex>* decoders[kCount];
  core::Fault faults[kCount];
  for (uint32_t n = 0; n < kCount; ++n) {
    const auto& [container, patch, requests] = tasks[n];
    StreamMemory<NarrowIndex>& memory = scratch.streams[n];
    arenas[n] = memory.arena(likely_size<NarrowIndex>(*container, patch, requests));
    memory.patch = {};
    const core::StreamHeader& header = complete_header(*container, borders, patch, memory);
    decoders[n] = &memory.decoder.emplace(header, arenas[n], memory.patch);
  }
  core::decode_in_step(decoders, faults);
  for (uint32_t n = 0; n < kCount; ++n)
    left[n] = faults[n] != core::Fault::kNone || !use(n, scratch.streams[n].patch, arenas[n]);
  return left;
}

// The attribute of each request, checked.
template <typename Index>
Status find_attributes(const core::Patch<Index>& patch, std::span<const AttributeRequest> requests,
                       std::vector<const core::Attribute<Index>*>& found) {
  found.clear();
  for (const AttributeRequest& request : requests) {
    const core::Attribute<Index>* attribute = nullptr;
    for (uint32_t i = 0; i < patch.attributes.size() && attribute == nullptr; ++i)
      if (patch.attributes[i].unique_id == request.unique_id) attribute = &patch.attributes[i];
    const uint32_t components = attribute != nullptr ? attribute->components : 0;
    if (Status status = check_request(request, components); !status.ok()) return status;
    found.push_back(attribute);
  }
  return {};
}

inline Status does_not_fit(const AttributeRequest& request) {
  return invalid_input("Draco stream: a value of " + request.semantic + " does not fit its accessor's type");
}

// The vertices of a patch's points, which the attributes of a group share.
template <typename Index>
class PointVertices {
 public:
  explicit PointVertices(const core::Patch<Index>& patch) : patch_(patch) {}

  // Empty if the points are the vertices, or if no attribute before this one was of its group.
  core::View<const Index> of(const core::Attribute<Index>& attribute) {
    if (PSPLIT_IS_SMALL_CODE || patch_.corner_of_point.empty()) return {};
    if (group_ != attribute.group) {
      group_ = attribute.group;
      found_.clear();
    } else if (found_.empty()) {
      const core::View<const Index> vertex = patch_.groups[attribute.group].table.table.vertex;
      for (uint32_t point = 0; point < patch_.point_count; ++point)
        found_.push_back(vertex[patch_.corner_of_point[point]]);
    }
    return {found_.data(), found_.size()};
  }

 private:
  const core::Patch<Index>& patch_;
  static constexpr uint32_t kNoGroup = ~0u;
  uint32_t group_ = kNoGroup;  // of the attribute before this one
  std::vector<Index> found_;
};

// Writes an attribute's values to place_of(point), in the requested type. If the values are one after another,
// the first one may be given, which is faster.
template <typename Index, typename PlaceOf>
Status write_attribute(const core::Patch<Index>& patch, const core::Attribute<Index>& attribute,
                       const AttributeRequest& request, PointVertices<Index>& vertices, PlaceOf place_of,
                       std::byte* first = nullptr) {
  const DataType type = stored_type(request.component_type);
  if (attribute.type == type && attribute.coding != core::Coding::kRaw) {
    auto* const out = reinterpret_cast<uint8_t*>(first);
    if (const core::View<const Index> of_points = vertices.of(attribute); !of_points.empty()) {
      if (out != nullptr)
        patch.write_all_values_of(of_points, attribute, out);
      else
        patch.write_values_of(of_points, attribute, [place_of](uint32_t point) {
          return reinterpret_cast<uint8_t*>(place_of(point));
        });
      return {};
    }
    if (!PSPLIT_IS_SMALL_CODE && out != nullptr) return patch.write_all_values(attribute, out), Status();
  }
  const size_t stride = attribute.stride();
  std::vector<uint8_t> stored(attribute.type == type ? 0 : patch.point_count * stride);
  patch.write_values(attribute, [place_of, stride,
                                 converted = attribute.type == type ? nullptr : stored.data()](uint32_t point) {
    return converted == nullptr ? reinterpret_cast<uint8_t*>(place_of(point)) : converted + point * stride;
  });
  if (attribute.type == type) return {};
  for (uint32_t point = 0; point < patch.point_count; ++point) {
    auto* const place = reinterpret_cast<uint8_t*>(place_of(point));
    if (place != nullptr && !convert_components(stored.data() + point * stride, attribute.type,
                                                attribute.normalized, attribute.components, type, place))
      return does_not_fit(request);
  }
  return {};
}

// As write_attribute, for places that are `stride` bytes apart.
template <typename Index>
Status write_attribute_at(const core::Patch<Index>& patch, const core::Attribute<Index>& attribute,
                          const AttributeRequest& request, PointVertices<Index>& vertices, std::byte* first,
                          size_t stride) {
  return write_attribute(
      patch, attribute, request, vertices, [=](uint32_t point) { return first + point * stride; },
      stride == attribute.stride() ? first : nullptr);
}

// Writes the first faces of a stream.
template <typename Index>
void write_stream_faces(const core::Patch<Index>& patch, uint32_t face_count, void* indices,
                        uint32_t index_bytes) {
  write_faces(face_count, indices, index_bytes,
              [&](uint32_t face, uint32_t k) { return patch.point_at[4 * face + k]; });
}

// Writes the faces and the requested attributes of a stream without borders.
template <typename Index>
Status write_stream(const core::Patch<Index>& patch, std::span<const AttributeRequest> requests,
                    std::span<const core::Attribute<Index>* const> attributes, uint32_t face_count,
                    const PrimitiveBuffers& out) {
  write_stream_faces(patch, face_count, out.indices.data(), out.index_bytes);
  PointVertices<Index> vertices(patch);
  for (size_t i = 0; i < requests.size(); ++i) {
    Status written = write_attribute_at(patch, *attributes[i], requests[i], vertices,
                                        out.attributes[i].bytes.data(), out.attributes[i].stride);
    if (!written.ok()) return written;
  }
  return {};
}

}  // namespace psplit
