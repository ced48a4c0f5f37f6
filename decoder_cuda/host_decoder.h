// Tasks to meshes in the host's memory, as many at once as the device has memory for.
#pragma once

#include <optional>

#include "decoder_cuda/batch_decoder.h"
#include "decoder_cuda/download.h"
#include "src/container/stream_description.h"

namespace psplit {

// Not safe to share between threads. Its memory of the device is kept from call to call.
template <typename Device>
class HostDecoder {
 public:
  // Takes no more than `memory_limit` bytes of the device, and no more than nine tenths of what is free now, of
  // which 0 means all; half of that is for results. More is decoded batch after batch, large meshes window
  // after window.
  explicit HostDecoder(Device device, uint64_t memory_limit = 0) : decoder_(std::move(device)) {
    limit_ = decoder_.device().free_memory() / 10 * 9;
    if (memory_limit > 0) limit_ = std::min(limit_, memory_limit);
    decoder_.set_memory_limit(limit_ - limit_ / 2);
  }

  // A mesh or an error for each task. Errors: those of BatchDecoder::finish and parse_container.
  std::vector<Expected<Mesh>> decode(std::span<const DecodeTask> tasks, const Progress& progress = {}) {
    std::vector<Expected<Mesh>> meshes(tasks.size(), Mesh());
    std::vector<Input> inputs(tasks.size());
    for (size_t i = 0; i < tasks.size(); ++i)
      if (Status status = inputs[i].prepare(tasks[i]); !status.ok()) meshes[i] = std::move(status);
    size_t done = 0;
    for (size_t i = 0; i < tasks.size(); ++i) {
      if (!meshes[i]) continue;
      const Input& input = inputs[i];
      const uint64_t whole = input.result_bytes(0, input.stream_count());
      if (used_ + whole > limit_ / 2) run(inputs, meshes);
      for (uint32_t first = 0, end; first < input.stream_count(); first = end) {
        uint64_t bytes = input.result_bytes(first, first + 1);
        for (end = first + 1; end < input.stream_count(); ++end) {
          const uint64_t more = input.result_bytes(end, end + 1);
          if (bytes + more > limit_ / 2) break;
          bytes += more;
        }
        if (used_ + bytes > limit_ / 2) run(inputs, meshes);
        windows_.push_back({i, first, end});
        used_ += bytes;
      }
      if (progress && done < i) progress(done = i, tasks.size());
    }
    run(inputs, meshes);
    if (progress) progress(tasks.size(), tasks.size());
    return meshes;
  }

 private:
  struct Input {
    DecodeTask task;
    std::optional<Container> container;
    std::vector<core::StreamHeader> headers;
    std::vector<uint32_t> strides;

    Status prepare(const DecodeTask& of) {
      task = of;
      Expected<Container> parsed =
          task.is_stream ? container_of_stream(task.bytes) : parse_container(task.bytes);
      if (!parsed) return parsed.status();
      // Before memory is taken for results.
      Expected<std::vector<core::StreamHeader>> checked = check_claims(*parsed);
      if (!checked) return checked.status();
      container = std::move(*parsed);
      headers = std::move(*checked);
      for (const AttributeRequest& request : task.requests)
        strides.push_back(static_cast<uint32_t>(component_bytes(request.component_type)) *
                          request.component_count);
      return {};
    }
    uint32_t stream_count() const { return static_cast<uint32_t>(container->entries.size()); }
    uint32_t faces(uint32_t first, uint32_t end) const {
      return container->face_base[end] - container->face_base[first];
    }
    uint32_t points(uint32_t first, uint32_t end) const {
      return container->owned_base[end] - container->owned_base[first];
    }
    uint64_t result_bytes(uint32_t first, uint32_t end) const {
      uint64_t bytes = rounded(uint64_t{12} * faces(first, end));
      for (const uint32_t stride : strides) bytes += rounded(uint64_t{stride} * points(first, end));
      return bytes;
    }
  };
  struct Window {
    size_t task = 0;
    uint32_t first = 0, end = 0;
  };

  static uint64_t rounded(uint64_t bytes) { return (bytes + 255) / 256 * 256; }

  // Decodes the windows that were collected.
  void run(const std::vector<Input>& inputs, std::vector<Expected<Mesh>>& meshes) {
    used_ = 0;
    run(inputs, std::exchange(windows_, {}), meshes);
  }

  // At once, or where there is no memory for that each on its own: one's shortage is no other's error.
  void run(const std::vector<Input>& inputs, std::span<const Window> windows,
           std::vector<Expected<Mesh>>& meshes) {
    if (windows.empty()) return;
    Status status = start(inputs, windows);
    if (status.ok()) return finish(inputs, windows, meshes);
    if (windows.size() == 1) {
      meshes[windows[0].task] = status;
      return;
    }
    for (const Window& window : windows)
      if (meshes[window.task]) run(inputs, {&window, 1}, meshes);
  }

  Status start(const std::vector<Input>& inputs, std::span<const Window> windows) {
    uint64_t bytes = 0;
    for (const Window& window : windows) bytes += inputs[window.task].result_bytes(window.first, window.end);
    if (Status status = grow(out_, bytes, limit_ / 2); !status.ok()) return status;
    batch_.clear();
    uint8_t* out = out_.data();
    const auto take = [&](uint64_t size) { return std::exchange(out, out + rounded(size)); };
    for (const Window& window : windows) {
      const Input& input = inputs[window.task];
      BatchPrimitive& primitive = batch_.emplace_back();
      primitive.bytes = input.task.bytes;
      primitive.container = &*input.container;
      primitive.headers = &input.headers;
      primitive.is_stream = input.task.is_stream;
      primitive.first = window.first;
      primitive.end = window.end;
      primitive.indices = take(uint64_t{12} * input.faces(window.first, window.end));
      for (size_t k = 0; k < input.strides.size(); ++k) {
        const AttributeRequest& request = input.task.requests[k];
        uint8_t* const values = take(uint64_t{input.strides[k]} * input.points(window.first, window.end));
        primitive.targets.push_back({request.unique_id, stored_type(request.component_type),
                                     request.component_count, values, input.strides[k], nullptr});
      }
    }
    return decoder_.start(batch_);
  }

  void finish(const std::vector<Input>& inputs, std::span<const Window> windows,
              std::vector<Expected<Mesh>>& meshes) {
    (void)decoder_.finish();
    std::vector<DownloadedRange> ranges;
    for (size_t n = 0; n < windows.size(); ++n) {
      Expected<Mesh>& mesh = meshes[windows[n].task];
      if (!mesh) continue;
      const Status& failed = decoder_.status(n);
      if (failed.ok())
        add_ranges(inputs[windows[n].task], windows[n], n, *mesh, ranges);
      else
        mesh = Status(failed.code(), failed.message(), {.patch = failed.place().patch});
    }
    if (Status status = downloader_.download(decoder_.device(), ranges); !status.ok())
      for (const Window& window : windows) meshes[window.task] = status;
  }

  // Makes room in the mesh for a window of it, the n-th of the batch.
  void add_ranges(const Input& input, const Window& window, size_t n, Mesh& mesh,
                  std::vector<DownloadedRange>& ranges) const {
    const Container& container = *input.container;
    uint32_t points = input.points(window.first, window.end);
    if (window.first == 0) {
      mesh.point_count = input.task.is_stream ? points = decoder_.point_count(n) : container.point_count();
      mesh.faces.resize(container.face_count());
      for (const AttributeRequest& request : input.task.requests) {
        mesh.attributes.push_back(
            {request.semantic, request.component_type, request.component_count, request.normalized, {}});
        mesh.attributes.back().values.resize(size_t{mesh.point_count} * mesh.attributes.back().stride());
      }
    }
    ranges.push_back({static_cast<const uint8_t*>(batch_[n].indices),
                      size_t{12} * input.faces(window.first, window.end),
                      mesh.faces.data() + container.face_base[window.first]});
    for (size_t k = 0; k < input.strides.size(); ++k) {
      const size_t stride = input.strides[k];
      ranges.push_back({batch_[n].targets[k].values, points * stride,
                        mesh.attributes[k].values.data() + container.owned_base[window.first] * stride});
    }
  }

  BatchDecoder<Device> decoder_;
  Downloader<Device> downloader_;
  uint64_t limit_ = 0;
  std::vector<Window> windows_;
  uint64_t used_ = 0;  // bytes of their results
  std::vector<BatchPrimitive> batch_;
  typename Device::template Array<uint8_t> out_;
};

}  // namespace psplit
