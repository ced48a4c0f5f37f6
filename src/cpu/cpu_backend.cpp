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

// The tasks of a call, and what becomes of them.
class Tasks {
 public:
  Tasks(std::span<const DecodeTask> tasks, const BuffersFor& buffers_for, const ThreadPool& pool,
        const Watch& watch)
      : tasks_(tasks),
        buffers_for_(buffers_for),
        pool_(pool),
        steps_(watch, step_count(tasks)),
        statuses_(tasks.size()) {}

  // The largest first, so that no thread begins a large one when all others are done. A thread takes several
  // short streams at a time, and decodes them in step, unless other threads would have nothing to do. A call of
  // few bytes is done before another thread is awake.
  std::vector<Status> decode() {
    std::vector<size_t> order(tasks_.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return bytes(a) > bytes(b); });
    size_t total = 0;
    for (const size_t task : order) total += bytes(task);
    const size_t threads = std::min(static_cast<size_t>(pool_.thread_count()), 1 + total / kBytesForAThread);
    std::vector<std::span<const size_t>> groups;
    for (std::span<const size_t> left = order; !left.empty();) {
      size_t count = 1, sum = bytes(left[0]);
      if (is_short_stream(left[0])) {
        const size_t most = std::min<size_t>(kInStep, left.size() / threads);
        for (; count < most && is_short_stream(left[count]); ++count)
          if ((sum += bytes(left[count])) > total / threads) break;
      }
      groups.push_back(left.first(count));
      left = left.subspan(count);
    }
    if (threads == 1)
      for (const std::span<const size_t> group : groups) decode(group);
    else
      pool_.for_each(groups.size(), [&](size_t group) { decode(groups[group]); });
    return std::move(statuses_);
  }

 private:
  // A thread takes some ten microseconds to wake up. It decodes so many bytes in about two hundred.
  static constexpr size_t kBytesForAThread = 1 << 13;

  size_t bytes(size_t task) const { return tasks_[task].container->bytes.size(); }
  static size_t step_count(std::span<const DecodeTask> tasks) {
    size_t patches = 0;
    for (const DecodeTask& task : tasks) patches += task.container->entries.size();
    return patches;
  }
  bool is_short_stream(size_t task) const {
    const PatchContainer& container = *tasks_[task].container;
    return container.is_stock && container.refusal.ok() && container.headers[0].fits_16_bits();
  }

  void decode(std::span<const size_t> group) {
    const PatchContainer& container = *tasks_[group[0]].container;
    if (steps_.stopped()) {
      for (const size_t task : group) statuses_[task] = cancelled();
    } else if (!container.is_stock) {
      statuses_[group[0]] = decode_patches(group[0]);
    } else if (!container.refusal.ok()) {
      statuses_[group[0]] = container.refusal;
      steps_.finish(1);
    } else {
      static_assert(kInStep == 3);
      switch (group.size()) {
        case 3: decode_in_step(group.first<3>()); break;
        case 2: decode_in_step(group.first<2>()); break;
        default: decode_stream(group[0], *ScratchPool::Lease(scratch_pool()));
      }
      steps_.finish(group.size());
    }
  }

  Status decode_patches(size_t task) {
    const PatchContainer& container = *tasks_[task].container;
    const Expected<PrimitiveBuffers> out = buffers_for_(task, container.point_count(), container.face_count());
    if (out) return ContainerDecoder(tasks_[task], *out, pool_, steps_).decode();
    steps_.finish(container.entries.size());
    return out.status();
  }
  void decode_stream(size_t task, Scratch& scratch) {
    statuses_[task] = with_decoded(*tasks_[task].container, BorderValues(), 0, tasks_[task].requests, scratch,
                                   [&](const auto& patch, core::Arena&) { return write(task, patch); });
  }
  template <size_t kCount>
  void decode_in_step(std::span<const size_t, kCount> group) {
    const ScratchPool::Lease lease(scratch_pool());
    std::array<StreamTask, kCount> streams;
    for (size_t n = 0; n < kCount; ++n) streams[n] = {tasks_[group[n]].container, 0, tasks_[group[n]].requests};
    const auto left = psplit::decode_in_step<kCount>(streams, BorderValues(), *lease,
                                                     [&](uint32_t n, const auto& patch, core::Arena&) {
                                                       statuses_[group[n]] = write(group[n], patch);
                                                       return true;
                                                     });
    for (size_t n = 0; n < kCount; ++n)
      if (left[n]) decode_stream(group[n], *lease);
  }
  template <typename Index>
  Status write(size_t task, const core::Patch<Index>& patch) const {
    const auto& [container, requests] = tasks_[task];
    std::vector<const core::Attribute<Index>*> attributes;
    if (Status found = find_attributes(patch, requests, attributes); !found.ok()) return found;
    const Expected<PrimitiveBuffers> out = buffers_for_(task, patch.point_count, container->face_count());
    if (!out) return out.status();
    return write_stream<Index>(patch, requests, attributes, container->face_count(), *out);
  }

  const std::span<const DecodeTask> tasks_;
  const BuffersFor& buffers_for_;
  const ThreadPool& pool_;
  Steps steps_;
  std::vector<Status> statuses_;
};

std::vector<Status> decode_into(std::span<const DecodeTask> tasks, const BuffersFor& buffers_for,
                                const ThreadPool& pool, const Watch& watch) {
  return Tasks(tasks, buffers_for, pool, watch).decode();
}

// The header of a point cloud. Nothing if the stream is of another kind.
Expected<std::optional<core::CloudHeader>> read_cloud_header(std::span<const uint8_t> stream) {
  core::CloudHeader header;
  const core::Fault fault = core::read_cloud_header(stream.data(), stream.size(), header);
  if (fault == core::Fault::kNotDraco) return std::optional<core::CloudHeader>();
  if (fault == core::Fault::kVersion) {
    constexpr size_t kMajor = 5, kMinor = 6;  // behind "DRACO"
    return unsupported("Draco stream: a point cloud of bitstream " + std::to_string(stream[kMajor]) + "." +
                       std::to_string(stream[kMinor]) + ", and only 2.2 and 2.3 are decoded");
  }
  if (fault != core::Fault::kNone) return status_of(fault);
  return std::optional(header);
}

template <typename Use>
Status with_any_cloud(const core::CloudHeader& header, std::span<const uint8_t> stream, Use use) {
  const ScratchPool::Lease lease(scratch_pool());
  return with_decoded_cloud(header, stream.size(), *lease,
                            [&](const auto& patch) { return use(header, patch); });
}

// Decodes a stream whose attributes are not known, and calls use(header, patch).
template <typename Use>
Status with_any_stream(std::span<const uint8_t> stream, Use use) {
  const Expected<std::optional<core::CloudHeader>> cloud = read_cloud_header(stream);
  if (!cloud) return cloud.status();
  if (*cloud) return with_any_cloud(**cloud, stream, use);
  const PatchContainer container = open_stream(stream);
  if (!container.refusal.ok()) return container.refusal;
  const ScratchPool::Lease lease(scratch_pool());
  // The first try has memory for as many attributes as most streams have.
  const std::array<AttributeRequest, 4> likely;
  return with_decoded(container, BorderValues(), 0, likely, *lease,
                      [&](const auto& patch, core::Arena&) { return use(container.headers[0], patch); });
}

StreamCoding coding_of(const core::CloudHeader& header) {
  return header.is_kd_tree ? StreamCoding::kCloudKdTree : StreamCoding::kCloudSequential;
}
StreamCoding coding_of(const core::StreamHeader& header) {
  return !header.edgebreaker ? StreamCoding::kSequential
         : header.valence    ? StreamCoding::kEdgebreakerValence
                             : StreamCoding::kEdgebreaker;
}

template <typename Header, typename Index>
StreamDescription description_of(const Header& header, const core::Patch<Index>& patch) {
  StreamDescription description;
  description.coding = coding_of(header);
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
  Status status = with_any_stream(stream, [&](const auto& header, const auto& patch) -> Status {
    description = description_of(header, patch);
    return {};
  });
  if (!status.ok()) return status;
  return description;
}

Expected<Mesh> decode_draco(std::span<const uint8_t> stream, StreamDescription* description) {
  Mesh mesh;
  Status status = with_any_stream(
      stream, [&]<typename Index>(const auto& header, const core::Patch<Index>& patch) -> Status {
        StreamDescription described = description_of(header, patch);
        const Expected<std::vector<AttributeRequest>> requests = gltf_attributes(described.attributes);
        if (!requests) return requests.status();
        const Expected<PrimitiveBuffers> out =
            allocate_mesh(patch.point_count, patch.face_count, *requests, stream.size(), mesh);
        if (!out) return out.status();
        std::vector<const core::Attribute<Index>*> attributes;
        if (Status found = find_attributes(patch, *requests, attributes); !found.ok()) return found;
        if (description != nullptr) *description = std::move(described);
        return write_stream<Index>(patch, *requests, attributes, patch.face_count, *out);
      });
  if (!status.ok()) return status;
  return mesh;
}

Expected<PointCloud> decode_cloud(std::span<const uint8_t> stream) {
  const Expected<std::optional<core::CloudHeader>> header = read_cloud_header(stream);
  if (!header) return header.status();
  if (!*header) return invalid_input("Draco stream: not a point cloud");
  PointCloud cloud;
  Status status = with_any_cloud(**header, stream, [&](const auto& cloud_header, const auto& patch) -> Status {
    StreamDescription description = description_of(cloud_header, patch);
    uint64_t point_bytes = 0;
    for (uint32_t i = 0; i < patch.attributes.size(); ++i) point_bytes += patch.attributes[i].stride();
    if (point_bytes * patch.point_count > justified_result_bytes(stream.size()))
      return status_of(core::Fault::kWorkspace);
    cloud.coding = description.coding;
    cloud.point_count = patch.point_count;
    for (uint32_t i = 0; i < patch.attributes.size(); ++i) {
      const size_t stride = patch.attributes[i].stride();
      CloudAttribute& attribute = cloud.attributes.emplace_back(std::move(description.attributes[i]));
      attribute.values.resize(patch.point_count * stride);
      patch.write_values(patch.attributes[i], [stride, values = attribute.values.data()](uint32_t point) {
        return reinterpret_cast<uint8_t*>(values + point * stride);
      });
    }
    return {};
  });
  if (!status.ok()) return status;
  return cloud;
}

void release_scratch() { scratch_pool().clear(); }

DecodeBackend cpu_backend() { return {"cpu", decode_into}; }

}  // namespace psplit
