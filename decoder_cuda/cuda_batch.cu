#include "decoder_cuda/cuda_kernels.cuh"
#include "decoder_cuda/prepared_batch.h"
#include "psplit/cuda.h"

namespace psplit {

struct PSPLIT_HIDDEN CudaBatch::Implementation {
  PreparedBatch<CudaDevice> batch;
  uint64_t workspace_bytes = 0;
  std::vector<Status> planned, statuses;
  StreamResults results;
  CudaDevice::Array<uint8_t> memory;  // if the caller gave none
  cudaEvent_t done = nullptr;         // of the last upload or enqueue that was not captured
  int device = 0;
  bool is_prepared = false, is_uploaded = false, is_enqueued = false;
  bool is_captured = false;  // the last enqueue

  ~Implementation() {
    if (done == nullptr) return;
    const CurrentDevice current(device);
    ignore(cudaEventSynchronize(done));
    ignore(cudaEventDestroy(done));
    memory = {};
  }

  Status prepare(void* workspace, const ThreadPool* pool) {
    std::string why;
    if (!cuda_available(&why)) return unsupported("no CUDA device to decode on: " + why);
    if (reinterpret_cast<uintptr_t>(workspace) % 256 != 0)
      return {StatusCode::kUsage, "a workspace that is not aligned to 256 bytes"};
    int current = 0;
    if (Status status = cuda_status(cudaGetDevice(&current), "cudaGetDevice"); !status.ok()) return status;
    if (done != nullptr && current != device)
      return {StatusCode::kUsage, "a batch that was prepared on another device"};
    device = current;
    is_prepared = is_uploaded = is_enqueued = false;
    Status status;
    if (done == nullptr)
      status = cuda_status(cudaEventCreateWithFlags(&done, cudaEventDisableTiming), "cudaEventCreate");
    if (status.ok() && workspace == nullptr) status = memory.reserve(workspace_bytes);
    uint8_t* const at = workspace != nullptr ? static_cast<uint8_t*>(workspace) : memory.data();
    if (status.ok()) status = batch.write(at, true, pool);
    is_prepared = status.ok();
    return status;
  }

  // Calls act(device) for work in the order of `stream`, and notes when it is done. Says whether `stream` is
  // being captured. After an error, nothing of it runs any more.
  template <typename Act>
  Status enqueue_work(cudaStream_t stream, bool& is_capturing, Act act) {
    if (!is_prepared) return {StatusCode::kUsage, "a batch that is not prepared"};
    const CurrentDevice current(device);
    Expected<CudaDevice> on = CudaDevice::on(stream);
    if (!on) return on.status();
    // CUDA's default stream takes no work while other streams are captured. This call says so, and does not end
    // their captures, as a copy would.
    cudaStreamCaptureStatus capture = cudaStreamCaptureStatusNone;
    Status status = cuda_status(cudaStreamIsCapturing(stream, &capture), "cudaStreamIsCapturing");
    if (!status.ok()) return status;
    is_capturing = capture != cudaStreamCaptureStatusNone;
    status = act(*on);
    if (is_capturing) return status;  // an event in a capture cannot be asked
    if (status.ok()) status = cuda_status(cudaEventRecord(done, stream), "cudaEventRecord");
    if (!status.ok()) (void)on->wait();
    return status;
  }

  Status upload(cudaStream_t stream) {
    bool is_capturing = false;
    Status status = enqueue_work(stream, is_capturing, [&](CudaDevice& on) { return batch.upload(on); });
    is_uploaded = status.ok() && !is_capturing;
    return status;
  }

  Status enqueue(cudaStream_t stream) {
    Status status = enqueue_work(stream, is_captured, [&](CudaDevice& on) {
      Status uploaded = is_uploaded ? Status() : batch.upload(on);
      return uploaded.ok() ? batch.launch(on) : uploaded;
    });
    is_enqueued = status.ok();
    return status;
  }

  Expected<bool> poll() const {
    if (!is_enqueued) return Status(StatusCode::kUsage, "a batch that is not enqueued");
    if (is_captured) return true;
    const CurrentDevice current(device);
    const cudaError_t error = cudaEventQuery(done);
    if (error == cudaErrorNotReady) return false;
    Status status = cuda_status(error, "cudaEventQuery");
    if (!status.ok()) return status;
    return true;
  }

  Status finish() {
    if (!is_enqueued) return {StatusCode::kUsage, "a batch that is not enqueued"};
    if (!is_captured) {
      const CurrentDevice current(device);
      if (Status status = cuda_status(cudaEventSynchronize(done), "cudaEventSynchronize"); !status.ok()) {
        std::fill(statuses.begin(), statuses.end(), status);
        return status;
      }
    }
    statuses = planned;
    batch.take_results(results);
    batch.plan().add_faults(
        results.faults, runtime_failure("a patch needs more memory than was planned: CudaDecoder decodes it"),
        statuses);
    for (const Status& each : statuses)
      if (!each.ok()) return each;
    return {};
  }
};

CudaBatch::CudaBatch(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
CudaBatch::CudaBatch(CudaBatch&&) noexcept = default;
CudaBatch::~CudaBatch() = default;

CudaBatch CudaBatch::plan(Span<const CudaPrimitive> primitives, uint64_t memory_limit, const ThreadPool* pool) {
  auto made = std::make_unique<Implementation>();
  made->planned = made->statuses = made->batch.make(primitives, BatchPlan::Gather::kAllPieces, pool);
  made->results = StreamResults(made->batch.plan().streams().size());
  made->workspace_bytes = made->batch.arrange(memory_limit);
  return CudaBatch(std::move(made));
}

uint64_t CudaBatch::workspace_bytes() const { return implementation_->workspace_bytes; }
Status CudaBatch::prepare(void* workspace, const ThreadPool* pool) {
  return implementation_->prepare(workspace, pool);
}
Status CudaBatch::upload(CUstream_st* stream) { return implementation_->upload(stream); }
Status CudaBatch::enqueue(CUstream_st* stream) { return implementation_->enqueue(stream); }
Expected<bool> CudaBatch::poll() const { return implementation_->poll(); }
Status CudaBatch::finish() { return implementation_->finish(); }
Status CudaBatch::status(size_t primitive) const { return implementation_->statuses[primitive]; }
uint32_t CudaBatch::point_count(size_t primitive) const {
  const Implementation& made = *implementation_;
  return made.statuses[primitive].ok() ? made.batch.plan().point_count(primitive, made.results.point_counts)
                                       : 0;
}

}  // namespace psplit
