// Decodes batches in memory that it keeps. A stream that had too little memory is decoded again.
#pragma once

#include "decoder_cuda/prepared_batch.h"

namespace psplit {

// Not thread-safe. Its memory is kept from batch to batch.
template <typename Device>
class BatchDecoder {
 public:
  explicit BatchDecoder(Device device) : device_(std::move(device)) {}

  Device& device() { return device_; }

  // CudaDecoder::set_memory_limit.
  void set_memory_limit(uint64_t bytes) { memory_limit_ = bytes; }

  // Plans and launches, with the threads of `pool`, unless it is null. The containers and their bytes must stay
  // until finish. Errors: kRuntimeFailure if the device fails. All others come from finish.
  Status start(Span<const CudaPrimitive> primitives, const ThreadPool* pool = nullptr) {
    if (is_running_) (void)device_.wait();  // for a batch without a finish
    statuses_ = batch_.make(primitives, BatchPlan::Gather::kSmallPieces, pool);
    results_ = StreamResults(plan().streams().size());
    is_uploaded_ = false;
    Status status = reserve();
    if (status.ok()) status = launch(pool);
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

  // The status of a primitive of the batch, after finish.
  const Status& status(size_t primitive) const { return statuses_[primitive]; }
  // The number of points of a stock stream, after finish; 0 after an error.
  uint32_t point_count(size_t primitive) const {
    return statuses_[primitive].ok() ? plan().point_count(primitive, results_.point_counts) : 0;
  }

 private:
  const BatchPlan& plan() const { return batch_.plan(); }

  // Ends all primitives with an error. Kernels that were launched before may still be running.
  void give_up(const Status& status) {
    (void)device_.wait();
    std::fill(statuses_.begin(), statuses_.end(), status);
  }

  // Reserves memory for the streams that are due, in as few parts as the limit allows.
  Status reserve() {
    uint64_t bytes = batch_.arrange(memory_limit_);
    if (bytes <= memory_.size()) return {};
    const uint64_t limit = std::min(memory_limit_, (device_.free_memory() + memory_.size()) / 10 * 9);
    bytes = batch_.arrange(limit);
    is_uploaded_ = is_uploaded_ && bytes <= memory_.size();
    return grow(memory_, bytes, limit);
  }

  // Uploads the tables, and pieces that are not on the device yet.
  Status launch(const ThreadPool* pool) {
    Status status = batch_.write(memory_.data(), !is_uploaded_, pool);
    if (status.ok())
      status = batch_.upload(device_, [&](uint8_t* to, std::span<const uint8_t> bytes) {
        return uploader_.upload(device_, to, bytes, pool);
      });
    if (status.ok()) status = batch_.launch(device_);
    is_uploaded_ = is_uploaded_ || status.ok();
    return status;
  }

  Status finish_streams() {
    Status shortage;
    for (;;) {
      if (Status status = device_.wait(); !status.ok()) return status;
      batch_.take_results(results_);
      if (!batch_.enlarge(results_.faults)) break;
      // If there is no more memory, the streams that were decoded are right nevertheless.
      if (shortage = reserve(); !shortage.ok()) break;
      if (Status status = launch(nullptr); !status.ok()) return status;
    }
    plan().add_faults(results_.faults, shortage, statuses_);
    return {};
  }

  Device device_;
  uint64_t memory_limit_ = ~uint64_t{0};
  PreparedBatch<Device> batch_;
  Uploader<Device> uploader_;
  std::vector<Status> statuses_;  // by primitive
  StreamResults results_;
  bool is_running_ = false;
  bool is_uploaded_ = false;  // the containers' pieces
  typename Device::template Array<uint8_t> memory_;
};

}  // namespace psplit
