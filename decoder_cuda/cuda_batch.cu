#include "decoder_cuda/cuda_kernels.cuh"
#include "decoder_cuda/prepared_batch.h"
#include "decoder_cuda/psplit_cuda.h"

namespace psplit {

struct PSPLIT_HIDDEN CudaBatch::Implementation {
  PreparedBatch<CudaDevice> batch;
  uint64_t workspace_bytes = 0;
  std::vector<Status> planned, statuses;
  StreamResults results;
  CudaDevice::Array<uint8_t> memory;  // if the caller gave none
  cudaEvent_t done = nullptr;         // of the last enqueue that was not captured
  int device = 0;
  bool is_prepared = false, is_uploaded = false, is_enqueued = false, is_captured = false;

  ~Implementation() {
    if (done == nullptr) return;
    const CurrentDevice current(device);
    if (is_enqueued && !is_captured) (void)cudaEventSynchronize(done);
    (void)cudaEventDestroy(done);
    memory = {};
  }

  Status prepare(void* workspace) {
    std::string why;
    if (!cuda_available(&why)) return unsupported("no CUDA device to decode on: " + why);
    if (reinterpret_cast<uintptr_t>(workspace) % 256 != 0)
      return {StatusCode::kUsage, "a workspace that is not aligned to 256 bytes"};
    Status status = cuda_status(cudaGetDevice(&device), "no device");
    if (status.ok() && workspace == nullptr) status = memory.reserve(workspace_bytes);
    if (status.ok() && done == nullptr)
      status = cuda_status(cudaEventCreateWithFlags(&done, cudaEventDisableTiming), "no event");
    if (status.ok())
      status = batch.write(workspace != nullptr ? static_cast<uint8_t*>(workspace) : memory.data(), true);
    is_prepared = status.ok();
    is_uploaded = false;
    return status;
  }

  Status upload(cudaStream_t stream) {
    if (!is_prepared) return {StatusCode::kUsage, "a batch that is not prepared"};
    const CurrentDevice current(device);
    Expected<CudaDevice> on = CudaDevice::on(stream);
    if (!on) return on.status();
    Status status = batch.upload(*on);
    is_uploaded = status.ok();
    return status;
  }

  Status enqueue(cudaStream_t stream) {
    if (!is_prepared) return {StatusCode::kUsage, "a batch that is not prepared"};
    const CurrentDevice current(device);
    Expected<CudaDevice> on = CudaDevice::on(stream);
    if (!on) return on.status();
    Status status = is_uploaded ? Status() : batch.upload(*on);
    if (status.ok()) status = batch.launch(*on);
    cudaStreamCaptureStatus capture = cudaStreamCaptureStatusNone;
    if (status.ok()) status = cuda_status(cudaStreamIsCapturing(stream, &capture), "no stream");
    is_captured = capture != cudaStreamCaptureStatusNone;
    // An event that is recorded in a capture cannot be asked.
    if (status.ok() && !is_captured) status = cuda_status(cudaEventRecord(done, stream), "no event");
    is_enqueued = status.ok();
    return status;
  }

  Expected<bool> poll() const {
    if (!is_enqueued) return Status(StatusCode::kUsage, "a batch that is not enqueued");
    if (is_captured) return true;
    const CurrentDevice current(device);
    const cudaError_t error = cudaEventQuery(done);
    if (error == cudaErrorNotReady) return false;
    Status status = cuda_status(error, "decoding");
    if (!status.ok()) return status;
    return true;
  }

  Status finish() {
    if (!is_enqueued) return {StatusCode::kUsage, "a batch that is not enqueued"};
    if (!is_captured) {
      const CurrentDevice current(device);
      if (Status status = cuda_status(cudaEventSynchronize(done), "decoding"); !status.ok()) {
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

CudaBatch CudaBatch::plan(std::span<const CudaPrimitive> primitives, uint64_t memory_limit) {
  auto made = std::make_unique<Implementation>();
  made->planned = made->statuses = made->batch.make(primitives, BatchPlan::Gather::kAllPieces);
  made->results = StreamResults(made->batch.plan().streams().size());
  made->workspace_bytes = made->batch.arrange(memory_limit);
  return CudaBatch(std::move(made));
}

uint64_t CudaBatch::workspace_bytes() const { return implementation_->workspace_bytes; }
Status CudaBatch::prepare(void* workspace) { return implementation_->prepare(workspace); }
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
