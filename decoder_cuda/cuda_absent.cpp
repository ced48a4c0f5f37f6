// Replaces the CUDA decoder in builds without a CUDA toolkit, so that callers need no #ifdef.
#include "psplit/cuda.h"

namespace psplit {
namespace {

Status absent() { return unsupported("no CUDA device to decode on: built without CUDA"); }

}  // namespace

bool cuda_available(std::string* why) {
  if (why != nullptr) *why = "built without CUDA";
  return false;
}

uint32_t cuda_multiprocessors() { return 0; }
std::string cuda_device_name() { return ""; }

Expected<CudaMemory> CudaMemory::allocate(size_t) { return absent(); }
CudaMemory::~CudaMemory() = default;
Status CudaMemory::download(const void*, WritableBytes) { return absent(); }

struct CudaDecoder::Implementation {};

CudaDecoder::CudaDecoder(CudaDecoder&&) noexcept = default;
CudaDecoder::~CudaDecoder() = default;
Expected<CudaDecoder> CudaDecoder::create(CUstream_st*) { return absent(); }
Status CudaDecoder::start(Span<const CudaPrimitive>, const ThreadPool*) { return absent(); }
Status CudaDecoder::finish() { return absent(); }
Status CudaDecoder::status(size_t) const { return absent(); }
uint32_t CudaDecoder::point_count(size_t) const { return 0; }
void CudaDecoder::set_memory_limit(uint64_t) {}
void CudaDecoder::measure(bool) {}
std::vector<std::pair<std::string, double>> CudaDecoder::take_times() { return {}; }

struct CudaBatch::Implementation {};

CudaBatch::CudaBatch(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
CudaBatch::CudaBatch(CudaBatch&&) noexcept = default;
CudaBatch::~CudaBatch() = default;
CudaBatch CudaBatch::plan(Span<const CudaPrimitive>, uint64_t, const ThreadPool*) {
  return CudaBatch(std::make_unique<Implementation>());
}
uint64_t CudaBatch::workspace_bytes() const { return 0; }
Status CudaBatch::prepare(void*, const ThreadPool*) { return absent(); }
Status CudaBatch::upload(CUstream_st*) { return absent(); }
Status CudaBatch::enqueue(CUstream_st*) { return absent(); }
Expected<bool> CudaBatch::poll() const { return absent(); }
Status CudaBatch::finish() { return absent(); }
Status CudaBatch::status(size_t) const { return absent(); }
uint32_t CudaBatch::point_count(size_t) const { return 0; }

Status cuda_warm_up() { return absent(); }

DecodeBackend cuda_backend(uint64_t) {
  return {"cuda", [](std::span<const DecodeTask> tasks, const BuffersFor&, const ThreadPool&, const Watch&) {
            return std::vector<Status>(tasks.size(), absent());
          }};
}

}  // namespace psplit
