#include <algorithm>
#include <numeric>

#include "psplit/decode.h"
#include "src/cpu/container_decoder.h"
#include "src/cpu/decode_in_scratch.h"

namespace psplit {
namespace {

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
  // A thread takes some ten microseconds to wake up, and decodes kBytesForAThread in about two hundred.
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
      decode_streams(group);
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
  // Decodes at most kCount streams.
  template <uint32_t kCount = kInStep>
  void decode_streams(std::span<const size_t> group) {
    if constexpr (kCount == 1) {
      decode_stream(group[0], *ScratchPool::Lease(scratch_pool()));
    } else if (group.size() == kCount) {
      decode_in_step(group.first<kCount>());
    } else {
      decode_streams<kCount - 1>(group);
    }
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

std::vector<Status> decode_into(Span<const DecodeTask> tasks, const BuffersFor& buffers_for,
                                const ThreadPool& pool, const Watch& watch) {
  return Tasks(tasks, buffers_for, pool, watch).decode();
}

}  // namespace

void release_scratch() { scratch_pool().clear(); }

DecodeBackend cpu_backend() { return {"cpu", decode_into}; }

}  // namespace psplit
