// Tasks to the host's memory, as many at once as the device has memory for.
#pragma once

#include "decoder_cuda/batch_decoder.h"

namespace psplit {

// One thread takes the steps of a stream, and needs about a microsecond for a face (measured: 0.62 on an H200).
// A display's watchdog ends kernels after two seconds on some systems.
inline constexpr uint32_t kMostFacesOfAStream = 1'000'000;

// Not safe to share between threads. Its memory of the device is kept from call to call.
template <typename Device>
class HostDecoder {
 public:
  // Takes no more than `memory_limit` bytes of the device, and no more than nine tenths of its free memory. A
  // limit of 0 means no other limit. Half of it is for results. Tasks that need more are decoded batch by
  // batch, and large meshes window by window. A task with a stream of more than `most_faces` faces is refused.
  explicit HostDecoder(Device device, uint64_t memory_limit = 0, uint32_t most_faces = kMostFacesOfAStream)
      : decoder_(std::move(device)), most_faces_(most_faces) {
    limit_ = decoder_.device().free_memory() / 10 * 9;
    if (memory_limit > 0) limit_ = std::min(limit_, memory_limit);
    decoder_.set_memory_limit(limit_ - limit_ / 2);
  }

  // DecodeBackend::decode_into. Errors: as for BatchDecoder::finish. Reports progress in tasks, and looks
  // before each batch whether to stop.
  std::vector<Status> decode_into(Span<const DecodeTask> tasks, const BuffersFor& buffers_for,
                                  const ThreadPool& pool, const Watch& watch) {
    Call call{tasks, buffers_for, pool, watch, {}, {}, {}, 0};
    call.statuses.resize(tasks.size());
    call.buffers.resize(tasks.size());
    size_t done = 0;
    for (size_t i = 0; i < tasks.size(); ++i) {
      const PatchContainer& container = *tasks[i].container;
      call.statuses[i] = check_container(container);
      if (call.statuses[i].ok()) call.statuses[i] = check_sizes(container);
      if (!call.statuses[i].ok()) continue;
      const auto stream_count = static_cast<uint32_t>(container.entries.size());
      const auto bytes_of = [&](uint32_t first, uint32_t end) { return result_bytes(tasks[i], first, end); };
      if (call.result_bytes + bytes_of(0, stream_count) > limit_ / 2) run(call);
      for (uint32_t first = 0, end; first < stream_count; first = end) {
        uint64_t bytes = bytes_of(first, first + 1);
        for (end = first + 1; end < stream_count; ++end) {
          const uint64_t more = bytes_of(end, end + 1);
          if (bytes + more > limit_ / 2) break;
          bytes += more;
        }
        if (call.result_bytes + bytes > limit_ / 2) run(call);
        call.windows.push_back({i, first, end});
        call.result_bytes += bytes;
      }
      if (watch.progress && done < i) watch.progress(done = i, tasks.size());
    }
    run(call);
    if (watch.progress && !watch.stopped()) watch.progress(tasks.size(), tasks.size());
    return std::move(call.statuses);
  }

 private:
  // Consecutive patches of a task.
  struct Window {
    size_t task = 0;
    uint32_t first = 0, end = 0;
  };
  struct Call {
    std::span<const DecodeTask> tasks;
    const BuffersFor& buffers_for;
    const ThreadPool& pool;  // plans, and copies results
    const Watch& watch;
    std::vector<Status> statuses;           // of each task
    std::vector<PrimitiveBuffers> buffers;  // of each task, when its first window was decoded
    std::vector<Window> windows;            // collected for the next batch
    uint64_t result_bytes = 0;              // of these
  };

  Status check_sizes(const PatchContainer& container) const {
    for (size_t i = 0; i < container.headers.size(); ++i)
      if (container.headers[i].counts.face_count > most_faces_)
        return unsupported(
            "a stream of " + std::to_string(container.headers[i].counts.face_count) +
                " faces would take a device too long, because one thread takes its steps: it has to "
                "be decoded on the CPU, or as patches",
            {.patch = static_cast<int64_t>(i)});
    return {};
  }

  static uint64_t face_bytes(const PatchContainer& container, uint32_t first, uint32_t end) {
    return uint64_t{12} * (container.face_base[end] - container.face_base[first]);
  }
  static uint64_t result_bytes(const DecodeTask& task, uint32_t first, uint32_t end) {
    const PatchContainer& container = *task.container;
    const uint64_t points = container.owned_base[end] - container.owned_base[first];
    uint64_t bytes = BatchPlan::in_block(face_bytes(container, first, end));
    for (const AttributeRequest& request : task.requests)
      bytes += BatchPlan::in_block(request.value_bytes() * points);
    return bytes;
  }

  // Decodes the windows that were collected.
  void run(Call& call) {
    call.result_bytes = 0;
    const std::vector<Window> windows = std::exchange(call.windows, {});
    if (call.watch.stopped())
      for (const Window& window : windows) call.statuses[window.task] = cancelled();
    else
      run(call, windows);
  }

  // Decodes all at once. If memory is short, decodes one by one, so that only a task that is too large fails.
  void run(Call& call, std::span<const Window> windows) {
    if (windows.empty()) return;
    Status status = start(call, windows);
    if (status.ok()) return finish(call, windows);
    if (windows.size() == 1) {
      call.statuses[windows[0].task] = status;
      return;
    }
    for (const Window& window : windows)
      if (call.statuses[window.task].ok()) run(call, {&window, 1});
  }

  Status start(const Call& call, std::span<const Window> windows) {
    uint64_t bytes = 0;
    for (const Window& window : windows)
      bytes += result_bytes(call.tasks[window.task], window.first, window.end);
    if (Status status = grow(out_, bytes, limit_ / 2); !status.ok()) return status;
    batch_.clear();
    uint8_t* out = out_.data();
    const auto take = [&](uint64_t size) { return std::exchange(out, out + BatchPlan::in_block(size)); };
    for (const Window& window : windows) {
      const DecodeTask& task = call.tasks[window.task];
      const PatchContainer& container = *task.container;
      const uint64_t points = container.owned_base[window.end] - container.owned_base[window.first];
      CudaPrimitive& primitive = batch_.emplace_back();
      primitive.container = &container;
      primitive.first = window.first;
      primitive.end = window.end;
      primitive.indices = take(face_bytes(container, window.first, window.end));
      for (const AttributeRequest& request : task.requests)
        primitive.attributes.push_back({request.unique_id, request.component_type, request.component_count,
                                        take(request.value_bytes() * points),
                                        static_cast<uint32_t>(request.value_bytes())});
    }
    return decoder_.start(batch_, &call.pool);
  }

  void finish(Call& call, std::span<const Window> windows) {
    (void)decoder_.finish();
    std::vector<DownloadedRange> ranges;
    for (size_t n = 0; n < windows.size(); ++n) {
      Status& status = call.statuses[windows[n].task];
      if (!status.ok()) continue;
      const Status& decoded = decoder_.status(n);
      status = decoded.ok() ? add_ranges(call, windows[n], n, ranges)
                            : Status(decoded.code(), decoded.message(), {.patch = decoded.place().patch});
    }
    if (Status status = downloader_.download(decoder_.device(), ranges, call.pool); !status.ok())
      for (const Window& window : windows) call.statuses[window.task] = status;
  }

  // The ranges of a window, which is the n-th primitive of the batch.
  Status add_ranges(Call& call, const Window& window, size_t n, std::vector<DownloadedRange>& ranges) const {
    const DecodeTask& task = call.tasks[window.task];
    const PatchContainer& container = *task.container;
    PrimitiveBuffers& buffers = call.buffers[window.task];
    uint32_t points = container.owned_base[window.end] - container.owned_base[window.first];
    if (container.is_stock) points = decoder_.point_count(n);
    if (window.first == 0) {
      Expected<PrimitiveBuffers> given = call.buffers_for(
          window.task, container.is_stock ? points : container.point_count(), container.face_count());
      if (!given) return given.status();
      buffers = std::move(*given);
    }
    const size_t index_bytes = buffers.index_bytes;
    ranges.push_back({static_cast<const uint8_t*>(batch_[n].indices),
                      face_bytes(container, window.first, window.end),
                      buffers.indices.data() + 3 * index_bytes * container.face_base[window.first],
                      sizeof(uint32_t), index_bytes, index_bytes});
    for (size_t k = 0; k < task.requests.size(); ++k) {
      const size_t size = task.requests[k].value_bytes(), stride = buffers.attributes[k].stride;
      ranges.push_back({static_cast<const uint8_t*>(batch_[n].attributes[k].values), points * size,
                        buffers.attributes[k].bytes.data() + container.owned_base[window.first] * stride, size,
                        size, stride});
    }
    return {};
  }

  BatchDecoder<Device> decoder_;
  Downloader<Device> downloader_;
  uint64_t limit_ = 0;
  uint32_t most_faces_ = 0;
  std::vector<CudaPrimitive> batch_;
  typename Device::template Array<uint8_t> out_;
};

}  // namespace psplit
