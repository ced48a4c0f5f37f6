// Sends a batch to a device and launches its kernels. A CUDA device (cuda_device.cuh) and its emulation in the
// tests share this code. A Device has
//
//   Array<T>                     memory of the device: reserve(count), size(), data(). It loses its
//                                contents when it grows, and never shrinks
//   HostArray<T>                 the same for pinned memory of the host
//   upload(to, from, count)      from the host
//   download(to, from, count)    to the host
//   launch_threads(count, busy, body)  calls body(i) for each i below count. About `busy` calls have much to do
//   launch_warps(count, body)    calls body(lanes, i), with the lanes of a warp
//   mark(stage)                  the name of the stage that follows, for measurements
//   wait()                       returns when everything before it is done
//   free_memory()                bytes
//
// The device does them in order. All except wait may return before they are done. Those that can fail return a
// Status.
#pragma once

#include <cstring>

#include "decoder_cuda/batch_plan.h"
#include "decoder_cuda/border_bodies.h"

namespace psplit {

template <core::StreamKinds kKinds, typename Index, typename Device>
Status launch_decoding(Device& device, const StreamSet<Index>& set, const LaunchPlan& plan) {
  if (set.count == 0) return {};
  device.mark("connectivity");
  if (Status status = device.launch_warps(set.count, BeginStreams<Index, kKinds>{set}); !status.ok())
    return status;
  for (uint32_t round = 0; round < plan.rounds; ++round) {
    device.mark("steps");
    const uint32_t busy = (round < plan.single_rounds ? 1 : plan.chains) * set.count;
    if (Status status = device.launch_threads(plan.runs * set.count, busy, TakeRuns<Index, kKinds>{set});
        !status.ok())
      return status;
    device.mark("between steps");
    if (Status status = device.launch_warps(set.count, ResumeStreams<Index, kKinds>{set, plan.runs});
        !status.ok())
      return status;
  }
  device.mark("prediction");
  if (Status status = device.launch_warps(set.count, PredictStreams<Index, kKinds>{set}); !status.ok())
    return status;
  if (plan.has_steps)
    if (Status status = device.launch_threads(plan.runs * set.count, set.count, TakeRuns<Index, kKinds>{set});
        !status.ok())
      return status;
  return device.launch_warps(set.count, CompleteStreams<Index, kKinds>{set});
}

// For streams of both kinds. All streams of a batch are numbered before one is written.
template <typename Index, typename Device>
Status launch_numbering(Device& device, const StreamSet<Index>& set) {
  if (set.count == 0) return {};
  device.mark("numbering");
  return device.launch_warps(set.count, FinishStreams<Index>{set});
}

template <typename Index, typename Device>
Status launch_writing(Device& device, const StreamSet<Index>& set) {
  if (set.count == 0) return {};
  device.mark("output");
  return device.launch_warps(set.count, WriteStreams<Index>{set});
}

// The values at the borders of `count` streams.
template <typename Device>
Status launch_borders(Device& device, const Batch& batch, const BorderTask* tasks, uint32_t count) {
  if (count == 0) return {};
  device.mark("borders");
  if (Status status = device.launch_threads(count, count, TakeBorderParts{batch, tasks}); !status.ok())
    return status;
  return device.launch_warps(count, ShareBorderValues{batch, tasks});
}

// Reserves at least `bytes`. Grows by half if `most` allows it, since the need may grow little by little.
template <typename Array>
Status grow(Array& array, uint64_t bytes, uint64_t most = ~uint64_t{0}) {
  if (bytes <= array.size()) return {};
  return array.reserve(std::max<uint64_t>(bytes, std::min<uint64_t>(most, array.size() + array.size() / 2)));
}

// Not thread-safe. Its memory is kept from batch to batch.
template <typename Device>
class BatchDecoder {
 public:
  explicit BatchDecoder(Device device) : device_(std::move(device)) {}

  Device& device() { return device_; }

  // CudaDecoder::set_memory_limit.
  void set_memory_limit(uint64_t bytes) { memory_limit_ = bytes; }

  // Plans and launches. The containers and their bytes must stay until finish. Errors: kRuntimeFailure if the
  // device fails. All others come from finish.
  Status start(std::span<const CudaPrimitive> primitives) {
    if (is_running_) (void)device_.wait();  // for a batch without a finish
    statuses_ = plan_.make(primitives);
    layout_ = Layout(plan_);
    faults_.assign(2 * plan_.streams().size(), core::Fault::kNone);
    point_counts_.assign(plan_.streams().size(), 0);
    is_uploaded_ = false;
    Status status = reserve();
    if (status.ok()) status = upload();
    if (status.ok()) status = launch();
    is_running_ = status.ok();
    if (!status.ok()) give_up(status);
    return status;
  }

  // CudaDecoder::finish. The place of an error has the primitive of the batch and the patch.
  Status finish() {
    if (std::exchange(is_running_, false))
      if (Status status = finish_streams(); !status.ok()) give_up(status);
    for (const Status& each : statuses_)
      if (!each.ok()) return each;
    return {};
  }

  // After finish: the status of a primitive of the batch.
  const Status& status(size_t primitive) const { return statuses_[primitive]; }
  // After finish: the number of points of a stock stream; 0 after an error.
  uint32_t point_count(size_t primitive) const {
    const size_t stream = plan_.primitives()[primitive].first_stream;
    return statuses_[primitive].ok() && stream < point_counts_.size() ? point_counts_[stream] : 0;
  }

 private:
  // The places of everything in the one array that a batch has on the device, so that one limit holds for all
  // of it. Tables and pieces of containers come first: they are uploaded. The workspace is last: only it may
  // grow.
  struct Layout {
    size_t primitives = 0, targets = 0, streams = 0, lists = 0, heads = 0, border_tasks = 0, known = 0;
    size_t pieces = 0;
    size_t walks = 0, walk_numbers = 0, borders = 0, faults = 0, point_counts = 0, workspace = 0;

    Layout() = default;
    explicit Layout(const BatchPlan& plan) {
      const size_t count = plan.streams().size();
      size_t end = 0;
      const auto place = [&](size_t bytes) { return std::exchange(end, end + BatchPlan::in_block(bytes)); };
      primitives = place(plan.primitives().size() * sizeof(PrimitiveTask));
      targets = place(plan.targets().size() * sizeof(AttributeTarget));
      streams = place(count * sizeof(StreamTask));
      lists = place(count * sizeof(uint32_t));  // narrow, then wide
      heads = place(plan.head_bytes());
      border_tasks = place(plan.borders().size() * sizeof(BorderTask));
      known = place(plan.known().size() * sizeof(int32_t));
      pieces = place(plan.piece_bytes());
      walks = place(count * sizeof(core::View<uint32_t>));
      walk_numbers = place(plan.walk_points() * sizeof(uint32_t));
      borders = place(plan.border_bytes());
      faults = place(2 * count * sizeof(core::Fault));
      point_counts = place(count * sizeof(uint32_t));
      workspace = end;
    }
  };

  template <typename T>
  T* array(size_t at) const {
    return reinterpret_cast<T*>(memory_.data() + at);
  }

  // Ends all primitives with an error. Kernels that were launched before may still be running.
  void give_up(const Status& status) {
    (void)device_.wait();
    std::fill(statuses_.begin(), statuses_.end(), status);
  }

  // Reserves memory for the streams that are due, in as few parts as the limit allows.
  Status reserve() {
    uint64_t limit = memory_limit_;
    const auto needed = [&] {
      const uint64_t left = std::max(limit - std::min<uint64_t>(limit, layout_.workspace), limit / 4);
      // The streams' bytes must justify the memory, whatever the streams claim.
      plan_.arrange(std::min(left, core::justified_bytes(plan_.stream_bytes())));
      return layout_.workspace + plan_.workspace_bytes();
    };
    if (needed() <= memory_.size()) return {};
    limit = std::min(limit, (device_.free_memory() + memory_.size()) / 10 * 9);
    const uint64_t bytes = needed();
    is_uploaded_ = is_uploaded_ && bytes <= memory_.size();
    return grow(memory_, bytes, limit);
  }

  // Uploads the tables, and pieces that are not on the device yet. Gathered pieces go in one copy, which is
  // interrupted only by pieces that are copied from where they are.
  Status upload() {
    const size_t gathered = is_uploaded_ ? 0 : plan_.gathered_bytes();
    if (Status status = grow(host_block_, layout_.pieces + gathered); !status.ok()) return status;
    device_.mark("upload");
    uint8_t *const host = host_block_.data(), *const device = memory_.data();
    const auto copy = [&](size_t at, const auto& values) {
      if (!values.empty()) std::memcpy(host + at, values.data(), values.size() * sizeof(values[0]));
      return at + values.size() * sizeof(values[0]);
    };
    std::vector<PrimitiveTask> primitives = plan_.primitives();
    for (PrimitiveTask& primitive : primitives)
      if (primitive.bytes == nullptr) primitive.bytes = device + layout_.pieces;
    for (const BatchPlan::Head& head : plan_.heads()) {
      const size_t at = layout_.heads + head.at;
      write_device_head(*head.head, host + at, device + at);
      for (size_t i = head.first_primitive; i < head.primitive_end; ++i)
        primitives[i].head = reinterpret_cast<const DeviceHead*>(device + at);
    }
    copy(layout_.primitives, primitives);
    copy(layout_.targets, plan_.targets());
    copy(layout_.streams, plan_.streams());
    copy(copy(layout_.lists, plan_.narrow().streams), plan_.wide().streams);
    copy(layout_.border_tasks, plan_.borders());
    copy(layout_.known, plan_.known());

    size_t begin = 0, end = layout_.pieces;  // of the gathered bytes that are not uploaded yet
    size_t to = 0;
    const auto upload_gathered = [&] { return device_.upload(device + to, host + begin, end - begin); };
    for (const BatchPlan::Piece& piece : plan_.pieces()) {
      if (is_uploaded_) break;
      if (piece.is_gathered) {
        end = copy(end, piece.bytes);
        continue;
      }
      Status status = upload_gathered();
      to = layout_.pieces + piece.at;
      if (status.ok()) status = device_.upload(device + to, piece.bytes.data(), piece.bytes.size());
      if (!status.ok()) return status;
      to += piece.bytes.size();
      begin = end;
    }
    is_uploaded_ = true;
    return upload_gathered();
  }

  Status launch() {
    const Batch batch{.primitives = array<PrimitiveTask>(layout_.primitives),
                      .targets = array<AttributeTarget>(layout_.targets),
                      .streams = array<StreamTask>(layout_.streams),
                      .workspace = array<uint8_t>(layout_.workspace),
                      .walk_numbers = array<uint32_t>(layout_.walk_numbers),
                      .walks = array<core::View<uint32_t>>(layout_.walks),
                      .faults = array<core::Fault>(layout_.faults),
                      .stitch_faults = array<core::Fault>(layout_.faults) + plan_.streams().size(),
                      .point_counts = array<uint32_t>(layout_.point_counts),
                      .borders = array<uint8_t>(layout_.borders),
                      .known = array<int32_t>(layout_.known)};
    const auto* const lists = array<uint32_t>(layout_.lists);
    const StreamSet<uint16_t> narrow{batch, lists, static_cast<uint32_t>(plan_.narrow().streams.size())};
    const StreamSet<uint32_t> wide{batch, lists + narrow.count,
                                   static_cast<uint32_t>(plan_.wide().streams.size())};
    if (Status status = launch_borders(device_, batch, array<BorderTask>(layout_.border_tasks),
                                       static_cast<uint32_t>(plan_.borders().size()));
        !status.ok())
      return status;
    for (const BatchPlan::Part& part : plan_.parts()) {
      Status status = decode(narrow, part.narrow, plan_.narrow());
      if (status.ok()) status = decode(wide, part.wide, plan_.wide());
      if (status.ok()) status = launch_numbering(device_, narrow.range(part.narrow.first, part.narrow.end));
      if (status.ok()) status = launch_numbering(device_, wide.range(part.wide.first, part.wide.end));
      if (status.ok()) status = launch_writing(device_, narrow.range(part.narrow.first, part.narrow.end));
      if (status.ok()) status = launch_writing(device_, wide.range(part.wide.first, part.wide.end));
      if (!status.ok()) return status;
    }
    return {};
  }
  template <typename Index>
  Status decode(const StreamSet<Index>& all, const BatchPlan::Range& range, const BatchPlan::Width& width) {
    Status status = launch_decoding<core::StreamKinds::kDraco>(
        device_, all.range(range.first, range.first_condensed), width.draco);
    if (!status.ok()) return status;
    return launch_decoding<core::StreamKinds::kCondensed>(device_, all.range(range.first_condensed, range.end),
                                                          width.condensed);
  }

  Status finish_streams() {
    const size_t count = plan_.streams().size();
    if (count == 0) return {};
    Status shortage;
    for (;;) {
      if (Status status = take_faults(); !status.ok()) return status;
      if (!plan_.enlarge({faults_.data(), count})) break;
      // If there is no more memory, the streams that were decoded are right nevertheless.
      if (shortage = reserve(); !shortage.ok()) break;
      Status status = upload();
      if (status.ok()) status = launch();
      if (!status.ok()) return status;
    }
    for (size_t i = 0; i < count; ++i) {
      const StreamTask& task = plan_.streams()[i];
      const core::Fault fault = faults_[i] != core::Fault::kNone ? faults_[i] : faults_[count + i];
      Status& status = statuses_[task.primitive];
      if (fault == core::Fault::kNone || !status.ok()) continue;
      const bool is_short = fault == core::Fault::kWorkspace && plan_.is_due(task.primitive);
      status = is_short ? shortage : status_of(fault);
      status = std::move(status).at({.primitive = task.primitive, .patch = task.number});
    }
    return {};
  }

  // Waits, and downloads the faults of the streams that were due.
  Status take_faults() {
    const size_t count = plan_.streams().size();
    std::vector<core::Fault> faults(2 * count);
    std::vector<uint32_t> point_counts(count);
    device_.mark("faults");
    Status status = device_.download(faults.data(), array<core::Fault>(layout_.faults), faults.size());
    if (status.ok() && plan_.has_point_limits())
      status = device_.download(point_counts.data(), array<uint32_t>(layout_.point_counts), count);
    device_.mark("");
    if (Status waited = device_.wait(); status.ok()) status = std::move(waited);
    if (!status.ok()) return status;
    for (const BatchPlan::Width* width : {&plan_.narrow(), &plan_.wide()})
      for (const uint32_t stream : width->streams) {
        faults_[stream] = faults[stream];
        faults_[count + stream] = faults[count + stream];
        point_counts_[stream] = point_counts[stream];
      }
    for (const BorderTask& border : plan_.borders())
      if (plan_.streams()[border.stream].use == StreamUse::kBorder)
        faults_[border.stream] = faults[border.stream];
    return {};
  }

  Device device_;
  uint64_t memory_limit_ = ~uint64_t{0};
  BatchPlan plan_;
  Layout layout_;
  std::vector<Status> statuses_;     // by primitive
  std::vector<core::Fault> faults_;  // of decoding, then of stitching
  std::vector<uint32_t> point_counts_;
  bool is_running_ = false;
  bool is_uploaded_ = false;  // the containers' pieces
  typename Device::template HostArray<uint8_t> host_block_;
  typename Device::template Array<uint8_t> memory_;
};

}  // namespace psplit
