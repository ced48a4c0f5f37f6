// A batch with its plan, the bytes to upload and the places of everything on the device. Uploading and
// launching it takes no memory and waits for nothing, so that both can be recorded and repeated.
#pragma once

#include <cstring>

#include "decoder_cuda/device_plan.h"
#include "decoder_cuda/launches.h"
#include "decoder_cuda/transfers.h"

namespace psplit {

// Reserves at least `bytes`. Grows by half if `most` allows it, since the need may grow little by little.
template <typename Array>
Status grow(Array& array, uint64_t bytes, uint64_t most = ~uint64_t{0}) {
  if (bytes <= array.size()) return {};
  return array.reserve(std::max<uint64_t>(bytes, std::min<uint64_t>(most, array.size() + array.size() / 2)));
}

// What a device found out about the streams of a batch.
struct StreamResults {
  std::vector<core::Fault> faults;     // of decoding all streams, then of stitching them
  std::vector<uint32_t> point_counts;  // if the plan has point limits

  explicit StreamResults(size_t stream_count = 0)
      : faults(2 * stream_count, core::Fault::kNone), point_counts(stream_count, 0) {}
};

// In the order of the calls: make, arrange, write, upload, launch. upload and launch may be repeated; the
// results of launch are there when the device is done.
template <typename Device>
class PreparedBatch {
 public:
  // BatchPlan::make.
  std::vector<Status> make(std::span<const CudaPrimitive> primitives, BatchPlan::Gather gather,
                           const ThreadPool* pool = nullptr) {
    std::vector<Status> statuses = plan_.make(primitives, gather, pool);
    layout_ = Layout(plan_);
    return statuses;
  }
  const BatchPlan& plan() const { return plan_; }
  // BatchPlan::enlarge. `arrange` has to follow.
  bool enlarge(std::span<const core::Fault> faults) { return plan_.enlarge(faults); }

  // Arranges the streams that are due in parts that take at most `limit` bytes of the device, if that is
  // possible. Returns the bytes that the batch takes.
  uint64_t arrange(uint64_t limit) {
    const uint64_t left = std::max(limit - std::min<uint64_t>(limit, layout_.workspace), limit / 4);
    // The streams' bytes must justify the memory, whatever the streams claim.
    plan_.arrange(std::min(left, core::justified_bytes(plan_.stream_bytes())));
    return layout_.workspace + plan_.workspace_bytes();
  }

  // Takes `memory` of the device, which has the bytes that `arrange` returned and is aligned to 256 bytes, and
  // writes what upload will copy to pinned memory of the host. `with_pieces`: also the gathered pieces of
  // containers, which threads of `pool` copy, unless it is null.
  Status write(uint8_t* memory, bool with_pieces, const ThreadPool* pool = nullptr) {
    memory_ = memory;
    has_pieces_ = with_pieces;
    const size_t count = plan_.streams().size();
    results_at_ = BatchPlan::in_block(layout_.pieces + (with_pieces ? plan_.gathered_bytes() : 0));
    const size_t result_bytes = count * (2 * sizeof(core::Fault) + sizeof(uint32_t)) + sizeof(uint32_t);
    if (Status status = grow(host_block_, results_at_ + result_bytes); !status.ok()) return status;
    write_tables();
    size_t end = layout_.pieces;
    for (const BatchPlan::Piece& piece : plan_.pieces())
      if (with_pieces && piece.is_gathered) {
        copy_bytes(piece.bytes, host_block_.data() + end, pool);
        end += piece.bytes.size();
      }
    return {};
  }

  // Uploads what was written, and pieces that are not gathered from where they are.
  Status upload(Device& device) const {
    return upload(device, [&](uint8_t* to, std::span<const uint8_t> bytes) {
      return device.upload(to, bytes.data(), bytes.size());
    });
  }
  // An overload of upload: upload_large(to, bytes) uploads the pieces that are not gathered.
  template <typename UploadLarge>
  Status upload(Device& device, UploadLarge upload_large) const {
    device.mark("upload");
    const uint8_t* const host = host_block_.data();
    size_t begin = 0, end = layout_.pieces;  // of the gathered bytes that are not uploaded yet
    size_t to = 0;
    const auto upload_gathered = [&] { return device.upload(memory_ + to, host + begin, end - begin); };
    for (const BatchPlan::Piece& piece : plan_.pieces()) {
      if (!has_pieces_) break;
      if (piece.is_gathered) {
        end += piece.bytes.size();
        continue;
      }
      Status status = upload_gathered();
      to = layout_.pieces + piece.at;
      if (status.ok()) status = upload_large(memory_ + to, piece.bytes);
      if (!status.ok()) return status;
      to += piece.bytes.size();
      begin = end;
    }
    return upload_gathered();
  }

  // Launches all kernels, and downloads the faults and the numbers of points.
  Status launch(Device& device) const {
    const size_t count = plan_.streams().size();
    if (count == 0) return {};
    if (Status status = launch_kernels(device); !status.ok()) return status;
    device.mark("faults");
    Status status = device.download(faults(), array<core::Fault>(layout_.faults), 2 * count);
    if (status.ok() && plan_.has_point_limits())
      status = device.download(point_counts(), array<uint32_t>(layout_.point_counts), count);
    device.mark("");
    return status;
  }

  // When the device is done: sets the results of the streams that were due.
  void take_results(StreamResults& results) const {
    const size_t count = plan_.streams().size();
    for (const BatchPlan::Width* width : {&plan_.narrow(), &plan_.wide()})
      for (const uint32_t stream : width->streams) {
        results.faults[stream] = faults()[stream];
        results.faults[count + stream] = faults()[count + stream];
        if (plan_.has_point_limits()) results.point_counts[stream] = point_counts()[stream];
      }
    for (const BorderTask& border : plan_.borders())
      if (plan_.streams()[border.stream].use == StreamUse::kBorder)
        results.faults[border.stream] = faults()[border.stream];
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
    return reinterpret_cast<T*>(memory_ + at);
  }
  // Results in the pinned block, after the uploaded bytes.
  uint32_t* point_counts() const { return reinterpret_cast<uint32_t*>(host_block_.data() + results_at_); }
  core::Fault* faults() const {
    return reinterpret_cast<core::Fault*>(point_counts() + plan_.streams().size());
  }

  // Copies values to a place of the pinned block, and returns the place after them.
  template <typename Values>
  size_t copy(size_t at, const Values& values) {
    if (!values.empty()) std::memcpy(host_block_.data() + at, values.data(), values.size() * sizeof(values[0]));
    return at + values.size() * sizeof(values[0]);
  }
  void write_tables() {
    uint8_t *const host = host_block_.data(), *const device = memory_;
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
  }

  Status launch_kernels(Device& device) const {
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
    if (Status status = launch_borders(device, batch, array<BorderTask>(layout_.border_tasks),
                                       static_cast<uint32_t>(plan_.borders().size()));
        !status.ok())
      return status;
    for (const BatchPlan::Part& part : plan_.parts()) {
      Status status = decode(device, narrow, part.narrow, plan_.narrow());
      if (status.ok()) status = decode(device, wide, part.wide, plan_.wide());
      if (status.ok()) status = launch_numbering(device, narrow.range(part.narrow.first, part.narrow.end));
      if (status.ok()) status = launch_numbering(device, wide.range(part.wide.first, part.wide.end));
      if (status.ok()) status = launch_writing(device, narrow.range(part.narrow.first, part.narrow.end));
      if (status.ok()) status = launch_writing(device, wide.range(part.wide.first, part.wide.end));
      if (!status.ok()) return status;
    }
    return {};
  }
  template <typename Index>
  static Status decode(Device& device, const StreamSet<Index>& all, const BatchPlan::Range& range,
                       const BatchPlan::Width& width) {
    Status status = launch_decoding<core::StreamKinds::kDraco>(
        device, all.range(range.first, range.first_condensed), width.draco);
    if (!status.ok()) return status;
    return launch_decoding<core::StreamKinds::kCondensed>(device, all.range(range.first_condensed, range.end),
                                                          width.condensed);
  }

  BatchPlan plan_;
  Layout layout_;
  uint8_t* memory_ = nullptr;  // of the device
  typename Device::template HostArray<uint8_t> host_block_;
  bool has_pieces_ = false;  // host_block_ has the gathered pieces
  size_t results_at_ = 0;    // in host_block_
};

}  // namespace psplit
