#include "src/cpu/cpu_backend.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <numeric>

#include "src/container/claims.h"
#include "src/container/stitch_row.h"
#include "src/core/stitch.h"
#include "src/core/workspace.h"
#include "src/cpu/convert.h"
#include "src/cpu/scratch.h"

namespace psplit {
namespace {

using core::Arena;
using core::Fault;
using core::kInStep;

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
         size = static_cast<size_t>(std::min<uint64_t>(2 * scratch.streams[0].size, most))) {
      Arena arena = scratch.streams[0].arena(size);
      patch = {};
      const Fault fault = core::decode_patch<Index>(header, arena, patch);
      if (fault == Fault::kNone) {
        Status status = use(patch, arena);
        if (status.code() != StatusCode::kRuntimeFailure) return status;
      } else if (fault != Fault::kWorkspace) {
        return status_of(fault);
      }
      if (scratch.streams[0].size >= most) return status_of(Fault::kWorkspace);
    }
  };
  return header.fits_16_bits() ? decode(scratch.streams[0].patch) : decode(scratch.wide);
}

// Decodes kInStep streams in step, and calls use(n, patch, arena) for each. Those that did
// not decode, or for which `use` wants more memory, are left for with_decoded: returns which. So are all where
// one is too large for 16-bit numbers.
template <typename Use>
std::array<bool, kInStep> decode_in_step(const std::array<std::span<const uint8_t>, kInStep>& streams,
                                         std::span<const core::StreamHeader, kInStep> headers,
                                         const std::array<uint32_t, kInStep>& points,
                                         std::span<const AttributeRequest> requests, Scratch& scratch,
                                         Use use) {
  std::array<bool, kInStep> left;
  left.fill(true);
  for (const core::StreamHeader& header : headers)
    if (!header.fits_16_bits()) return left;
  Arena arenas[kInStep];
  core::PatchDecoder<uint16_t>* decoders[kInStep];
  Fault faults[kInStep];
  for (uint32_t n = 0; n < kInStep; ++n) {
    StreamMemory& memory = scratch.streams[n];
    arenas[n] = memory.arena(likely_size<uint16_t>(headers[n], streams[n], points[n], requests));
    memory.patch = {};
    decoders[n] = &memory.decoder.emplace(headers[n], arenas[n], memory.patch);
  }
  core::decode_in_step(decoders, faults);
  for (uint32_t n = 0; n < kInStep; ++n)
    left[n] = faults[n] != Fault::kNone || !use(n, scratch.streams[n].patch, arenas[n]);
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

// Tells a caller how far its work is, and asks it whether to go on. Safe to share between threads.
class Steps {
 public:
  Steps(const Watch& watch, size_t total) : watch_(watch), total_(total) {}

  bool stopped() const { return watch_.stopped(); }
  void finish(size_t count) {
    if (watch_.progress) watch_.progress(done_ += count, total_);
  }

 private:
  const Watch& watch_;
  const size_t total_;
  std::atomic<size_t> done_ = 0;
};

// Calls write(indices) with the target's, of the type that they have.
template <typename Write>
void with_indices(const MeshTarget& target, Write write) {
  if (target.index_bytes == 2)
    write(static_cast<uint16_t*>(target.indices));
  else
    write(static_cast<uint32_t*>(target.indices));
}

template <typename Index>
Status write_stream(const core::Patch<Index>& patch, std::span<const AttributeRequest> requests,
                    std::span<const core::Attribute<Index>* const> attributes, const MeshTarget& target) {
  with_indices(target, [&]<typename Out>(Out* out) {
    for (uint32_t face = 0; face < target.face_count; ++face)
      for (uint32_t k = 0; k < 3; ++k) *out++ = static_cast<Out>(patch.point_at[4 * face + k]);
  });
  for (size_t i = 0; i < requests.size(); ++i) {
    const MeshTarget::Values& out = target.attributes[i];
    Status written = write_attribute(patch, *attributes[i], requests[i],
                                     [&](uint32_t point) { return out.first + point * out.stride; });
    if (!written.ok()) return written;
  }
  return {};
}

// Calls target_for(patch) for the target, or an error, when it is known what the stream holds. `point_count` is
// what it should have, 0 where that is not known.
template <typename TargetFor>
Status decode_stream_to(std::span<const uint8_t> stream, std::span<const AttributeRequest> requests,
                        uint32_t point_count, TargetFor target_for) {
  const ScratchPool::Lease lease(scratch_pool());
  const Expected<core::StreamHeader> header = read_stream_header(stream);
  if (!header) return header.status();
  return with_decoded(stream, *header, point_count, requests, *lease,
                      [&]<typename Index>(const core::Patch<Index>& patch, Arena&) -> Status {
                        std::vector<const core::Attribute<Index>*> attributes;
                        Status found = find_attributes(patch, requests, attributes);
                        if (!found.ok()) return found;
                        const Expected<MeshTarget> target = target_for(patch);
                        if (!target) return target.status();
                        return write_stream<Index>(patch, requests, attributes, *target);
                      });
}

// An empty mesh of the patch's size.
template <typename Index>
Status make_mesh(const core::Patch<Index>& patch, std::span<const AttributeRequest> requests,
                 size_t stream_bytes, Mesh& mesh) {
  if (Status status = check_results(patch.point_count, patch.face_count, requests, stream_bytes); !status.ok())
    return status;
  mesh.point_count = patch.point_count;
  mesh.faces.resize(patch.face_count);
  mesh.attributes = make_attributes(requests, patch.point_count);
  return {};
}

Expected<Mesh> decode_stream(std::span<const uint8_t> stream, std::span<const AttributeRequest> requests) {
  Mesh mesh;
  Status status = decode_stream_to(stream, requests, 0, [&](const auto& patch) -> Expected<MeshTarget> {
    if (Status made = make_mesh(patch, requests, stream.size(), mesh); !made.ok()) return made;
    return target_of(mesh);
  });
  if (!status.ok()) return status;
  return mesh;
}

// Decodes a stream of which nobody knows the attributes, and calls use(header, patch).
template <typename Use>
Status with_any_stream(std::span<const uint8_t> stream, Use use) {
  const Expected<core::StreamHeader> header = read_stream_header(stream);
  if (!header) return header.status();
  const ScratchPool::Lease lease(scratch_pool());
  // The first try has memory for as many attributes as most streams have.
  const std::array<AttributeRequest, 4> likely;
  return with_decoded(stream, *header, 0, likely, *lease,
                      [&](const auto& patch, Arena&) { return use(*header, patch); });
}

template <typename Index>
StreamDescription description_of(const core::StreamHeader& header, const core::Patch<Index>& patch) {
  StreamDescription description;
  description.coding = !header.edgebreaker ? StreamCoding::kSequential
                       : header.valence    ? StreamCoding::kEdgebreakerValence
                                           : StreamCoding::kEdgebreaker;
  description.face_count = patch.face_count;
  description.point_count = patch.point_count;
  for (uint32_t i = 0; i < patch.attributes.size(); ++i) {
    const core::Attribute<Index>& attribute = patch.attributes[i];
    description.attributes.push_back({attribute.unique_id, static_cast<DracoSemantic>(attribute.semantic),
                                      attribute.type, attribute.components, attribute.normalized,
                                      attribute.bits});
    if (attribute.coding != core::Coding::kQuantized) continue;
    StreamAttribute& described = description.attributes.back();
    described.range = attribute.range;
    described.origin.resize(attribute.components);
    std::memcpy(described.origin.data(), attribute.origin, described.origin.size() * sizeof(float));
  }
  return description;
}

Status decode_stream_into(std::span<const uint8_t> stream, std::span<const AttributeRequest> requests,
                          const MeshTarget& target) {
  return decode_stream_to(stream, requests, target.point_count, [&](const auto& patch) -> Expected<MeshTarget> {
    if (patch.point_count != target.point_count)
      return differs_from_directory("points", patch.point_count, target.point_count);
    if (patch.face_count < target.face_count)
      return differs_from_directory("faces", patch.face_count, target.face_count);
    return target;
  });
}

// A container's mesh while its patches come in. Two rounds over the patches: first each writes what it owns,
// and its faces with references as placeholders; then references take the numbers that their owners gave.
class ContainerDecoder {
 public:
  // `headers` are those that check_claims gives.
  ContainerDecoder(const Container& container, std::span<const core::StreamHeader> headers,
                   std::span<const AttributeRequest> requests, const MeshTarget& target, const ThreadPool& pool,
                   Steps& steps)
      : container_(container),
        has_references_(container.reference_count() > 0),
        headers_(headers),
        requests_(requests),
        target_(target),
        pool_(pool),
        steps_(steps),
        patches_(container.entries.size()) {}

  Status decode() {
    const auto count = static_cast<uint32_t>(patches_.size());
    // In step only where that leaves no thread without work.
    const uint32_t in_step =
        count / kInStep >= static_cast<uint32_t>(pool_.thread_count()) ? count / kInStep : 0;
    pool_.for_each(in_step + (count - in_step * kInStep), [&](size_t task) {
      if (steps_.stopped()) return;
      const auto i = static_cast<uint32_t>(task);
      if (i < in_step)
        decode_patches(i * kInStep);
      else
        decode_patch(in_step * (kInStep - 1) + i);
      steps_.finish(i < in_step ? kInStep : 1);
    });
    if (steps_.stopped()) return cancelled();
    if (Status status = first_failure(); !status.ok()) return status;
    pool_.for_each(count, [&](size_t i) {
      patches_[i].status = resolve_references(static_cast<uint32_t>(i)).at({.patch = static_cast<int64_t>(i)});
    });
    return first_failure();
  }

 private:
  struct Placeholder {
    uint32_t corner;     // of the mesh, three a face
    uint32_t reference;  // of the patch, in the order of its stitch map
  };
  struct StitchedPatch {
    std::vector<uint32_t> walk;  // the mesh's numbers along the border; kNoPoint for references
    std::vector<Placeholder> placeholders;
    std::vector<uint32_t> references;  // the mesh's numbers, once they are resolved
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

  // Patches [first, first + kInStep).
  void decode_patches(uint32_t first) {
    const ScratchPool::Lease lease(scratch_pool());
    Scratch& scratch = *lease;
    std::array<std::span<const uint8_t>, kInStep> streams;
    std::array<uint32_t, kInStep> points;
    for (uint32_t n = 0; n < kInStep; ++n) {
      streams[n] = container_.streams[first + n];
      points[n] = container_.entries[first + n].point_count;
    }
    const auto left =
        decode_in_step(streams, std::span<const core::StreamHeader, kInStep>(&headers_[first], kInStep), points,
                       requests_, scratch, [&](uint32_t n, const auto& patch, Arena& arena) {
                         Status status = write_patch(first + n, patch, arena, scratch.numbers);
                         const bool is_done = status.code() != StatusCode::kRuntimeFailure;
                         patches_[first + n].status = std::move(status).at({.patch = first + n});
                         return is_done;
                       });
    for (uint32_t n = 0; n < kInStep; ++n)
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
    const Fault fault = core::number_mesh_points(
        core::SerialLanes(), stitch_row(container_, i), core::View<const Index>(border),
        core::View<uint32_t>(numbers.data(), numbers.size()), references_of(i));
    if (fault != Fault::kNone) return status_of(fault);

    const uint32_t total = target_.point_count;
    std::vector<Placeholder>& placeholders = patches_[i].placeholders;
    placeholders.clear();
    with_indices(target_, [&]<typename Out>(Out* out) {
      out += size_t{3} * container_.face_base[i];
      for (uint32_t face = 0; face < entry.face_count; ++face) {
        for (uint32_t k = 0; k < 3; ++k) {
          const uint32_t number = numbers[patch.point_at[4 * face + k]];
          *out++ = static_cast<Out>(number);
          if (number >= total)
            placeholders.push_back({3 * (container_.face_base[i] + face) + k, number - total});
        }
      }
    });
    for (size_t k = 0; k < requests_.size(); ++k) {
      std::byte* const values = target_.attributes[k].first;
      const size_t stride = target_.attributes[k].stride;
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

  core::View<uint32_t> references_of(uint32_t i) {
    std::vector<uint32_t>& references = patches_[i].references;
    references.resize(container_.entries[i].reference_count);
    return {references.data(), references.size()};
  }

  Status resolve_references(uint32_t i) {
    const core::View<uint32_t> numbers = references_of(i);
    const auto walk_of = [&](uint32_t stream, uint32_t place) {
      const std::vector<uint32_t>& walk = patches_[stream].walk;
      return place < walk.size() ? walk[place] : core::kNoPoint;
    };
    const auto owned_of = [&](uint32_t stream, uint32_t rank) {
      const uint32_t base = container_.owned_base[stream];
      return rank < container_.owned_base[stream + 1] - base ? base + rank : core::kNoPoint;
    };
    const Fault fault =
        core::resolve_references(core::SerialLanes(), stitch_row(container_, i), walk_of, owned_of, numbers);
    if (fault != Fault::kNone) return status_of(fault);
    with_indices(target_, [&]<typename Out>(Out* out) {
      for (const Placeholder& placeholder : patches_[i].placeholders)
        out[placeholder.corner] = static_cast<Out>(numbers[placeholder.reference]);
    });
    return {};
  }

  const Container& container_;
  const bool has_references_;
  const std::span<const core::StreamHeader> headers_;
  const std::span<const AttributeRequest> requests_;
  const MeshTarget& target_;
  const ThreadPool& pool_;
  Steps& steps_;
  std::vector<StitchedPatch> patches_;
};

Expected<Mesh> decode_container(std::span<const uint8_t> bytes, std::span<const AttributeRequest> requests,
                                const ThreadPool& pool) {
  const Expected<Container> container = parse_container(bytes);
  if (!container) return container.status();
  // Before memory is taken for the mesh.
  const Expected<std::vector<core::StreamHeader>> headers = check_claims(*container);
  if (!headers) return headers.status();
  if (Status status = check_results(container->point_count(), container->face_count(), requests, bytes.size());
      !status.ok())
    return status;
  Mesh mesh;
  mesh.point_count = container->point_count();
  mesh.faces.resize(container->face_count());
  mesh.attributes = make_attributes(requests, mesh.point_count);
  const MeshTarget target = target_of(mesh);
  const Watch nobody;
  Steps steps(nobody, container->entries.size());
  Status status = ContainerDecoder(*container, *headers, requests, target, pool, steps).decode();
  if (!status.ok()) return status;
  return mesh;
}

Status decode_container_into(const Container& container, std::span<const AttributeRequest> requests,
                             const MeshTarget& target, const ThreadPool& pool, Steps& steps) {
  if (container.point_count() != target.point_count)
    return differs_from_directory("points", target.point_count, container.point_count());
  if (container.face_count() != target.face_count)
    return differs_from_directory("faces", target.face_count, container.face_count());
  const Expected<std::vector<core::StreamHeader>> headers = check_claims(container);
  if (!headers) return headers.status();
  return ContainerDecoder(container, *headers, requests, target, pool, steps).decode();
}

std::vector<Status> decode_into(std::span<const DecodeTask> tasks, std::span<const MeshTarget> targets,
                                const ThreadPool& pool, const Watch& watch) {
  std::vector<Status> statuses(tasks.size());
  std::vector<Container> containers(tasks.size());
  size_t patch_count = 0;
  for (size_t i = 0; i < tasks.size(); ++i) {
    if (tasks[i].is_stream) {
      ++patch_count;
      continue;
    }
    Expected<Container> container = parse_container(tasks[i].bytes);
    statuses[i] = container.status();
    if (!container) continue;
    containers[i] = std::move(*container);
    patch_count += containers[i].entries.size();
  }
  Steps steps(watch, patch_count);
  // The largest first, so that no thread begins one when all others are done.
  std::vector<size_t> order(tasks.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return tasks[a].bytes.size() > tasks[b].bytes.size(); });
  pool.for_each(tasks.size(), [&](size_t place) {
    const size_t i = order[place];
    if (!statuses[i].ok()) return;
    if (steps.stopped())
      statuses[i] = cancelled();
    else if (!tasks[i].is_stream)
      statuses[i] = decode_container_into(containers[i], tasks[i].requests, targets[i], pool, steps);
    else {
      statuses[i] = decode_stream_into(tasks[i].bytes, tasks[i].requests, targets[i]);
      steps.finish(1);
    }
  });
  return statuses;
}

}  // namespace

Expected<StreamDescription> describe_stream(std::span<const uint8_t> stream) {
  StreamDescription description;
  Status status = with_any_stream(stream, [&](const core::StreamHeader& header, const auto& patch) -> Status {
    description = description_of(header, patch);
    return {};
  });
  if (!status.ok()) return status;
  return description;
}

Expected<Mesh> decode_draco(std::span<const uint8_t> stream) {
  Mesh mesh;
  Status status = with_any_stream(
      stream, [&]<typename Index>(const core::StreamHeader& header, const core::Patch<Index>& patch) -> Status {
        const Expected<std::vector<AttributeRequest>> requests =
            gltf_attributes(description_of(header, patch).attributes);
        if (!requests) return requests.status();
        if (Status made = make_mesh(patch, *requests, stream.size(), mesh); !made.ok()) return made;
        std::vector<const core::Attribute<Index>*> attributes;
        if (Status found = find_attributes(patch, *requests, attributes); !found.ok()) return found;
        return write_stream<Index>(patch, *requests, attributes, target_of(mesh));
      });
  if (!status.ok()) return status;
  return mesh;
}

DecodeBackend cpu_backend() {
  DecodeBackend backend = one_by_one("cpu", decode_container, decode_stream);
  backend.decode_into = decode_into;
  return backend;
}

}  // namespace psplit
