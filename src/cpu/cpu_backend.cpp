#include "src/cpu/cpu_backend.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "src/cpu/container_decoder.h"
#include "src/cpu/decode_in_scratch.h"

namespace psplit {
namespace {

template <typename Index>
Status write_stream(const core::Patch<Index>& patch, std::span<const AttributeRequest> requests,
                    std::span<const core::Attribute<Index>* const> attributes, uint32_t face_count,
                    const PrimitiveBuffers& out) {
  with_indices(out, [&]<typename Out>(Out* indices) {
    for (uint32_t face = 0; face < face_count; ++face)
      for (uint32_t k = 0; k < 3; ++k) *indices++ = static_cast<Out>(patch.point_at[4 * face + k]);
  });
  for (size_t i = 0; i < requests.size(); ++i) {
    std::byte* const values = out.attributes[i].bytes.data();
    const size_t stride = out.attributes[i].stride;
    Status written = write_attribute(patch, *attributes[i], requests[i],
                                     [&](uint32_t point) { return values + point * stride; });
    if (!written.ok()) return written;
  }
  return {};
}

// Calls buffers_for(point_count, face_count) for the memory when the stream's counts are known.
template <typename BuffersForCounts>
Status decode_stream(const DecodeTask& task, BuffersForCounts buffers_for) {
  const PatchContainer& container = *task.container;
  const ScratchPool::Lease lease(scratch_pool());
  return with_decoded(container, BorderValues(), 0, task.requests, *lease,
                      [&]<typename Index>(const core::Patch<Index>& patch, core::Arena&) -> Status {
                        std::vector<const core::Attribute<Index>*> attributes;
                        Status found = find_attributes(patch, task.requests, attributes);
                        if (!found.ok()) return found;
                        const uint32_t face_count = container.face_count();
                        const Expected<PrimitiveBuffers> out = buffers_for(patch.point_count, face_count);
                        if (!out) return out.status();
                        return write_stream<Index>(patch, task.requests, attributes, face_count, *out);
                      });
}

std::vector<Status> decode_into(std::span<const DecodeTask> tasks, const BuffersFor& buffers_for,
                                const ThreadPool& pool, const Watch& watch) {
  size_t patch_count = 0;
  for (const DecodeTask& task : tasks) patch_count += task.container->entries.size();
  Steps steps(watch, patch_count);
  const auto decode = [&](size_t i) -> Status {
    if (steps.stopped()) return cancelled();
    const PatchContainer& container = *tasks[i].container;
    if (container.is_stock) {
      const auto buffers = [&](uint32_t points, uint32_t faces) { return buffers_for(i, points, faces); };
      Status status = container.refusal.ok() ? decode_stream(tasks[i], buffers) : container.refusal;
      steps.finish(1);
      return status;
    }
    const Expected<PrimitiveBuffers> out = buffers_for(i, container.point_count(), container.face_count());
    if (out) return ContainerDecoder(tasks[i], *out, pool, steps).decode();
    steps.finish(container.entries.size());
    return out.status();
  };
  // The largest first, so that no thread begins a large one when all others are done.
  std::vector<size_t> order(tasks.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return tasks[a].container->bytes.size() > tasks[b].container->bytes.size();
  });
  std::vector<Status> statuses(tasks.size());
  pool.for_each(tasks.size(), [&](size_t place) { statuses[order[place]] = decode(order[place]); });
  return statuses;
}

// Decodes a stream whose attributes are not known, and calls use(header, patch).
template <typename Use>
Status with_any_stream(std::span<const uint8_t> stream, Use use) {
  const PatchContainer container = open_stream(stream);
  if (!container.refusal.ok()) return container.refusal;
  const ScratchPool::Lease lease(scratch_pool());
  // The first try has memory for as many attributes as most streams have.
  const std::array<AttributeRequest, 4> likely;
  return with_decoded(container, BorderValues(), 0, likely, *lease,
                      [&](const auto& patch, core::Arena&) { return use(container.headers[0], patch); });
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
        const Expected<PrimitiveBuffers> out =
            allocate_mesh(patch.point_count, patch.face_count, *requests, stream.size(), mesh);
        if (!out) return out.status();
        std::vector<const core::Attribute<Index>*> attributes;
        if (Status found = find_attributes(patch, *requests, attributes); !found.ok()) return found;
        return write_stream<Index>(patch, *requests, attributes, patch.face_count, *out);
      });
  if (!status.ok()) return status;
  return mesh;
}

void release_scratch() { scratch_pool().clear(); }

DecodeBackend cpu_backend() { return {"cpu", decode_into}; }

}  // namespace psplit
