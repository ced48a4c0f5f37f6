#include "src/cpu/cpu_backend.h"

#include <algorithm>
#include <array>

#include "src/container/claims.h"
#include "src/core/numbering.h"
#include "src/core/workspace.h"
#include "src/cpu/convert.h"
#include "src/cpu/scratch.h"

namespace psplit {
namespace {

using core::Arena;
using core::Fault;

ScratchPool& scratch_pool() {
  static ScratchPool pool;
  return pool;
}

// What `use` below returns to be called again with more memory.
Status more_memory() { return runtime_failure("the scratch is too small"); }

// Memory that does for all but liars. `points` is 0 where no directory says.
template <typename Index>
size_t likely_size(const core::StreamHeader& header, std::span<const uint8_t> stream, uint32_t points,
                   std::span<const AttributeRequest> requests) {
  if (points == 0) points = core::likely_points(header);
  core::ValueCounts values{points, static_cast<uint32_t>(requests.size()), 0};
  for (const AttributeRequest& request : requests) values.components += request.component_count;
  return static_cast<size_t>(std::min<uint64_t>(core::workspace_bytes<Index>(header, stream.size(), values),
                                                core::justified_bytes(stream.size())));
}

// Decodes, and calls use(patch, arena) for the patch of 16-bit or 32-bit numbers; what it returns is returned.
// For `points` see likely_size.
template <typename Use>
Status with_decoded(std::span<const uint8_t> stream, const core::StreamHeader& header, uint32_t points,
                    std::span<const AttributeRequest> requests, Scratch& scratch, Use use) {
  const uint64_t most = core::justified_bytes(stream.size());
  const auto decode = [&]<typename Index>(core::Patch<Index>& patch) -> Status {
    for (size_t size = likely_size<Index>(header, stream, points, requests);;
         size = static_cast<size_t>(std::min<uint64_t>(2 * scratch.lanes[0].size, most))) {
      Arena arena = scratch.lanes[0].arena(size);
      patch = {};
      const Fault fault = core::decode_patch<Index>(header, arena, patch);
      if (fault == Fault::kNone) {
        Status status = use(patch, arena);
        if (status.code() != StatusCode::kRuntimeFailure) return status;
      } else if (fault != Fault::kWorkspace) {
        return status_of(fault);
      }
      if (scratch.lanes[0].size >= most) return status_of(Fault::kWorkspace);
    }
  };
  return header.fits_16_bits() ? decode(scratch.lanes[0].patch) : decode(scratch.wide);
}

// Decodes as many streams as there are lanes in step, and calls use(n, patch, arena) for each. Those that did
// not decode, or for which `use` wants more memory, are left for with_decoded: returns which. So are all where
// one is too large for 16-bit numbers.
template <typename Use>
std::array<bool, kLanes> decode_in_lanes(const std::array<std::span<const uint8_t>, kLanes>& streams,
                                         std::span<const core::StreamHeader, kLanes> headers,
                                         const std::array<uint32_t, kLanes>& points,
                                         std::span<const AttributeRequest> requests, Scratch& scratch,
                                         Use use) {
  std::array<bool, kLanes> left;
  left.fill(true);
  for (const core::StreamHeader& header : headers)
    if (!header.fits_16_bits()) return left;
  Arena arenas[kLanes];
  core::PatchDecoder<uint16_t>* decoders[kLanes];
  Fault faults[kLanes];
  for (uint32_t n = 0; n < kLanes; ++n) {
    Lane& lane = scratch.lanes[n];
    arenas[n] = lane.arena(likely_size<uint16_t>(headers[n], streams[n], points[n], requests));
    lane.patch = {};
    decoders[n] = &lane.decoder.emplace(headers[n], arenas[n], lane.patch);
  }
  core::decode_in_step(decoders, faults);
  for (uint32_t n = 0; n < kLanes; ++n)
    left[n] = faults[n] != Fault::kNone || !use(n, scratch.lanes[n].patch, arenas[n]);
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
    const std::string name = request.semantic + " (unique id " + std::to_string(request.unique_id) + ")";
    if (attribute == nullptr) return invalid_input("Draco stream: no attribute for " + name);
    if (request.component_count == 0 || request.component_count > 16 ||
        attribute->components != request.component_count)
      return invalid_input("Draco stream: " + name + " has " + std::to_string(attribute->components) +
                           " components, not " + std::to_string(request.component_count));
    found.push_back(attribute);
  }
  return {};
}

// Writes an attribute's values where place_of(point) says, in the type asked for.
template <typename Index, typename PlaceOf>
Status write_attribute(const core::Patch<Index>& patch, const core::Attribute<Index>& attribute,
                       const AttributeRequest& request, PlaceOf place_of) {
  if (attribute.type == stored_type(request.component_type)) {
    patch.write_values(attribute, [&](uint32_t point) { return reinterpret_cast<uint8_t*>(place_of(point)); });
    return {};
  }
  std::vector<std::byte> stored(size_t{patch.point_count} * attribute.stride());
  patch.write_values(attribute, [&](uint32_t point) {
    return reinterpret_cast<uint8_t*>(stored.data() + size_t{point} * attribute.stride());
  });
  for (uint32_t point = 0; point < patch.point_count; ++point) {
    std::byte* const place = place_of(point);
    if (place != nullptr &&
        !convert_value(stored.data() + size_t{point} * attribute.stride(), attribute.type, attribute.normalized,
                       request.component_type, attribute.components, place))
      return invalid_input("Draco stream: a value of " + request.semantic +
                           " does not fit its accessor's type");
  }
  return {};
}

std::vector<Attribute> make_attributes(std::span<const AttributeRequest> requests, size_t point_count) {
  std::vector<Attribute> attributes;
  for (const AttributeRequest& request : requests) {
    attributes.push_back(
        {request.semantic, request.component_type, request.component_count, request.normalized, {}});
    attributes.back().values.resize(point_count * attributes.back().stride());
  }
  return attributes;
}

Expected<Mesh> decode_stream(std::span<const uint8_t> stream, std::span<const AttributeRequest> requests) {
  const ScratchPool::Lease lease(scratch_pool());
  Mesh mesh;
  const Expected<core::StreamHeader> header = read_stream_header(stream);
  if (!header) return header.status();
  Status status = with_decoded(stream, *header, 0, requests, *lease,
                               [&]<typename Index>(const core::Patch<Index>& patch, Arena&) -> Status {
                                 std::vector<const core::Attribute<Index>*> attributes;
                                 if (Status found = find_attributes(patch, requests, attributes); !found.ok())
                                   return found;
                                 mesh.point_count = patch.point_count;
                                 mesh.faces.resize(patch.face_count);
                                 for (uint32_t face = 0; face < patch.face_count; ++face)
                                   mesh.faces[face] = {patch.point_at[4 * face], patch.point_at[4 * face + 1],
                                                       patch.point_at[4 * face + 2]};
                                 mesh.attributes = make_attributes(requests, patch.point_count);
                                 for (size_t i = 0; i < requests.size(); ++i) {
                                   Attribute& out = mesh.attributes[i];
                                   const size_t stride = out.stride();
                                   Status written = write_attribute(
                                       patch, *attributes[i], requests[i],
                                       [&](uint32_t point) { return out.values.data() + point * stride; });
                                   if (!written.ok()) return written;
                                 }
                                 return {};
                               });
  if (!status.ok()) return status;
  return mesh;
}

// A container's mesh while its patches come in. Two rounds over the patches: first each writes what it owns,
// and its faces with references as placeholders; then references take the numbers that their owners gave.
class ContainerDecoder {
 public:
  ContainerDecoder(const Container& container, std::span<const AttributeRequest> requests,
                   const ThreadPool& pool)
      : container_(container),
        has_references_(container.reference_count() > 0),
        requests_(requests),
        pool_(pool),
        patches_(container.entries.size()) {}

  Expected<Mesh> decode() {
    Expected<std::vector<core::StreamHeader>> headers = check_claims(container_);
    if (!headers) return headers.status();
    headers_ = std::move(*headers);
    mesh_.point_count = container_.point_count();
    mesh_.faces.resize(container_.face_count());
    mesh_.attributes = make_attributes(requests_, mesh_.point_count);
    const auto count = static_cast<uint32_t>(patches_.size());
    // In step only where that leaves no thread without work.
    const uint32_t in_step = count / kLanes >= static_cast<uint32_t>(pool_.thread_count()) ? count / kLanes : 0;
    pool_.for_each(in_step + (count - in_step * kLanes), [&](size_t task) {
      const auto i = static_cast<uint32_t>(task);
      if (i < in_step)
        decode_patches(i * kLanes);
      else
        decode_patch(in_step * (kLanes - 1) + i);
    });
    if (Status status = first_failure(); !status.ok()) return status;
    pool_.for_each(count, [&](size_t i) {
      patches_[i].status = resolve_references(static_cast<uint32_t>(i)).at({.patch = static_cast<int64_t>(i)});
    });
    if (Status status = first_failure(); !status.ok()) return status;
    return std::move(mesh_);
  }

 private:
  struct Placeholder {
    uint32_t corner;     // of the mesh, three a face
    uint32_t reference;  // of the patch, in the order of its stitch map
  };
  struct StitchedPatch {
    std::vector<uint32_t> walk;  // the mesh's numbers along the border; kNoPoint for references
    std::vector<Placeholder> placeholders;
    Status status;
  };

  Status first_failure() const {
    for (const StitchedPatch& patch : patches_)
      if (!patch.status.ok()) return patch.status;
    return {};
  }

  void decode_patch(uint32_t i) {
    const ScratchPool::Lease lease(scratch_pool());
    decode_patch(i, *lease);
  }
  void decode_patch(uint32_t i, Scratch& scratch) {
    Status status =
        with_decoded(container_.streams[i], headers_[i], container_.entries[i].point_count, requests_, scratch,
                     [&]<typename Index>(const core::Patch<Index>& patch, Arena& arena) -> Status {
                       return write_patch(i, patch, arena, scratch.numbers);
                     });
    patches_[i].status = std::move(status).at({.patch = i});
  }

  // Patches [first, first + kLanes).
  void decode_patches(uint32_t first) {
    const ScratchPool::Lease lease(scratch_pool());
    Scratch& scratch = *lease;
    std::array<std::span<const uint8_t>, kLanes> streams;
    std::array<uint32_t, kLanes> points;
    for (uint32_t n = 0; n < kLanes; ++n) {
      streams[n] = container_.streams[first + n];
      points[n] = container_.entries[first + n].point_count;
    }
    const auto left =
        decode_in_lanes(streams, std::span<const core::StreamHeader, kLanes>(&headers_[first], kLanes), points,
                        requests_, scratch, [&](uint32_t n, const auto& patch, Arena& arena) {
                          Status status = write_patch(first + n, patch, arena, scratch.numbers);
                          const bool is_done = status.code() != StatusCode::kRuntimeFailure;
                          patches_[first + n].status = std::move(status).at({.patch = first + n});
                          return is_done;
                        });
    for (uint32_t n = 0; n < kLanes; ++n)
      if (left[n]) decode_patch(first + n, scratch);
  }

  template <typename Index>
  Status write_patch(uint32_t i, const core::Patch<Index>& patch, Arena& arena,
                     std::vector<uint32_t>& numbers) {
    const StreamEntry& entry = container_.entries[i];
    if (patch.point_count != entry.point_count)
      return differs_from_directory("points", patch.point_count, entry.point_count);
    std::vector<const core::Attribute<Index>*> attributes;
    if (Status status = find_attributes(patch, requests_, attributes); !status.ok()) return status;
    core::View<Index> border;
    if (has_references_ && core::walk_border(patch, arena, border) == Fault::kWorkspace) return more_memory();
    numbers.resize(entry.point_count);
    const Fault fault = core::number_mesh_points(core::SerialLanes(), row(i), core::View<const Index>(border),
                                                 core::View<uint32_t>(numbers.data(), numbers.size()));
    if (fault != Fault::kNone) return status_of(fault);

    const uint32_t total = mesh_.point_count;
    std::vector<Placeholder>& placeholders = patches_[i].placeholders;
    placeholders.clear();
    std::array<uint32_t, 3>* face_out = mesh_.faces.data() + container_.face_base[i];
    for (uint32_t face = 0; face < entry.face_count; ++face, ++face_out) {
      for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t number = numbers[patch.point_at[4 * face + k]];
        (*face_out)[k] = number;
        if (number >= total) placeholders.push_back({3 * (container_.face_base[i] + face) + k, number - total});
      }
    }
    for (size_t k = 0; k < requests_.size(); ++k) {
      std::byte* const values = mesh_.attributes[k].values.data();
      const size_t stride = mesh_.attributes[k].stride();
      Status status = write_attribute(patch, *attributes[k], requests_[k], [&](uint32_t point) -> std::byte* {
        // The owner writes; every copy holds the same bits.
        return numbers[point] < total ? values + numbers[point] * stride : nullptr;
      });
      if (!status.ok()) return status;
    }
    patches_[i].walk.resize(border.size());
    for (size_t at = 0; at < border.size(); ++at) {
      const uint32_t number = numbers[border[at]];
      patches_[i].walk[at] = number < total ? number : core::kNoPoint;
    }
    return {};
  }

  core::StitchRow row(uint32_t i) const {
    const std::span<const uint8_t> bytes = container_.stitch[i];
    return {{bytes.data(), bytes.size()},
            i,
            container_.entries[i].reference_count,
            container_.owned_base[i],
            mesh_.point_count};
  }

  Status resolve_references(uint32_t i) {
    std::vector<uint32_t> numbers(container_.entries[i].reference_count);
    const auto walk_of = [&](uint32_t stream, uint32_t place) {
      const std::vector<uint32_t>& walk = patches_[stream].walk;
      return place < walk.size() ? walk[place] : core::kNoPoint;
    };
    const auto owned_of = [&](uint32_t stream, uint32_t rank) {
      const uint32_t base = container_.owned_base[stream];
      return rank < container_.owned_base[stream + 1] - base ? base + rank : core::kNoPoint;
    };
    const Fault fault = core::resolve_references(core::SerialLanes(), row(i), walk_of, owned_of,
                                                 core::View<uint32_t>(numbers.data(), numbers.size()));
    if (fault != Fault::kNone) return status_of(fault);
    for (const Placeholder& placeholder : patches_[i].placeholders)
      mesh_.faces[placeholder.corner / 3][placeholder.corner % 3] = numbers[placeholder.reference];
    return {};
  }

  const Container& container_;
  const bool has_references_;
  std::span<const AttributeRequest> requests_;
  const ThreadPool& pool_;
  std::vector<core::StreamHeader> headers_;
  std::vector<StitchedPatch> patches_;
  Mesh mesh_;
};

Expected<Mesh> decode_container(std::span<const uint8_t> bytes, std::span<const AttributeRequest> requests,
                                const ThreadPool& pool) {
  const Expected<Container> container = parse_container(bytes);
  if (!container) return container.status();
  return ContainerDecoder(*container, requests, pool).decode();
}

}  // namespace

Expected<StreamDescription> describe_stream(std::span<const uint8_t> stream) {
  const Expected<core::StreamHeader> header = read_stream_header(stream);
  if (!header) return header.status();
  StreamDescription description;
  description.coding = !header->edgebreaker ? StreamCoding::kSequential
                       : header->valence    ? StreamCoding::kEdgebreakerValence
                                            : StreamCoding::kEdgebreaker;
  const ScratchPool::Lease lease(scratch_pool());
  // Nobody knows the attributes yet: the first try has memory for as many as most streams have.
  const std::array<AttributeRequest, 4> likely;
  Status status =
      with_decoded(stream, *header, 0, likely, *lease,
                   [&]<typename Index>(const core::Patch<Index>& patch, Arena&) -> Status {
                     description.face_count = patch.face_count;
                     description.point_count = patch.point_count;
                     for (uint32_t i = 0; i < patch.attributes.size(); ++i) {
                       const core::Attribute<Index>& attribute = patch.attributes[i];
                       description.attributes.push_back(
                           {attribute.unique_id, static_cast<DracoSemantic>(attribute.semantic), attribute.type,
                            attribute.components, attribute.normalized, attribute.bits});
                     }
                     return {};
                   });
  if (!status.ok()) return status;
  return description;
}

DecodeBackend cpu_backend() { return one_by_one("cpu", decode_container, decode_stream); }

}  // namespace psplit
