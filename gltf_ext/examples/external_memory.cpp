// Decodes a mesh into memory that Vulkan or Direct3D 12 has allocated, without a copy through the host:
//
//   external_memory MESH.psp MEMORY BYTES READY DONE [VALUE]
//
// MESH.psp is a patch container: the bytes of the extension's buffer view. MEMORY, READY and DONE are handles
// that another API exported for this process. On Linux they are file descriptors, and on Windows they are
// handles:
//
//              Vulkan, on Linux                         Vulkan or Direct3D 12, on Windows
//   MEMORY     vkGetMemoryFdKHR, OPAQUE_FD              vkGetMemoryWin32HandleKHR, or CreateSharedHandle of a
//                                                       committed buffer
//   READY,     vkGetSemaphoreFdKHR of timeline          vkGetSemaphoreWin32HandleKHR, or CreateSharedHandle of
//   DONE       semaphores, OPAQUE_FD                    ID3D12Fence
//
// The engine signals READY with VALUE when the memory may be written, and waits until DONE has VALUE before it
// draws. The indices come first, four bytes each; then the positions, three floats each, at the next multiple
// of 256 bytes. The memory must be a dedicated allocation, or the example's `dedicated` flag must go. Both APIs
// must use the same device: compare cudaDeviceProp::uuid with VkPhysicalDeviceIDProperties::deviceUUID, or
// cudaDeviceProp::luid with the LUID of the adapter.
#include <cuda_runtime_api.h>
#include <psplit/cuda.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <psplit/psplit.hpp>
#include <vector>

namespace {

using psplit::Status;

[[noreturn]] void give_up(const Status& status) {
  std::fprintf(stderr, "external_memory: %s\n", status.to_string().c_str());
  std::exit(3);
}
void check(const Status& status) {
  if (!status.ok()) give_up(status);
}
void check(cudaError_t error, const char* what) {
  if (error != cudaSuccess)
    give_up(psplit::runtime_failure(std::string(what) + ": " + cudaGetErrorString(error)));
}

// CUDA takes over a file descriptor that it imports, but not a handle of Windows.
#if defined(_WIN32)
constexpr auto kMemory = cudaExternalMemoryHandleTypeD3D12Resource;     // or ...OpaqueWin32, of Vulkan
constexpr auto kSemaphore = cudaExternalSemaphoreHandleTypeD3D12Fence;  // or ...TimelineSemaphoreWin32
template <typename Description>
void set_handle(Description& description, const char* text) {
  description.handle.win32.handle = reinterpret_cast<void*>(std::strtoull(text, nullptr, 0));
}
#else
constexpr auto kMemory = cudaExternalMemoryHandleTypeOpaqueFd;
constexpr auto kSemaphore = cudaExternalSemaphoreHandleTypeTimelineSemaphoreFd;
template <typename Description>
void set_handle(Description& description, const char* text) {
  description.handle.fd = std::atoi(text);
}
#endif

// The address on the device of memory that another API allocated.
std::byte* import_memory(const char* handle, size_t bytes, cudaExternalMemory_t& memory) {
  cudaExternalMemoryHandleDesc description{};
  description.type = kMemory;
  description.size = bytes;
  description.flags = cudaExternalMemoryDedicated;
  set_handle(description, handle);
  check(cudaImportExternalMemory(&memory, &description), "the memory cannot be imported");
  cudaExternalMemoryBufferDesc buffer{};
  buffer.size = bytes;
  void* mapped = nullptr;
  check(cudaExternalMemoryGetMappedBuffer(&mapped, memory, &buffer), "the memory cannot be mapped");
  return static_cast<std::byte*>(mapped);
}

cudaExternalSemaphore_t import_semaphore(const char* handle) {
  cudaExternalSemaphoreHandleDesc description{};
  description.type = kSemaphore;
  set_handle(description, handle);
  cudaExternalSemaphore_t semaphore = nullptr;
  check(cudaImportExternalSemaphore(&semaphore, &description), "the semaphore cannot be imported");
  return semaphore;
}

}  // namespace

int main(int count, char** words) {
  if (count < 6) {
    std::fputs("external_memory MESH.psp MEMORY BYTES READY DONE [VALUE]\n", stderr);
    return 1;
  }
  std::ifstream file(words[1], std::ios::binary);
  const std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
  const std::vector<psplit::AttributeRequest> attributes{{"POSITION", 0}};
  const psplit::Expected<psplit::CompressedPrimitive> mesh =
      psplit::CompressedPrimitive::open({bytes, attributes});
  if (!mesh) give_up(mesh.status());

  const size_t room = std::strtoull(words[3], nullptr, 0);
  const size_t index_bytes = size_t{12} * mesh->face_count();
  const size_t positions_at = (index_bytes + 255) / 256 * 256;
  if (positions_at + size_t{12} * mesh->point_count() > room)
    give_up({psplit::StatusCode::kUsage, "the memory is too small for the mesh"});

  cudaExternalMemory_t memory = nullptr;
  std::byte* const target = import_memory(words[2], room, memory);
  const cudaExternalSemaphore_t ready = import_semaphore(words[4]), done = import_semaphore(words[5]);
  cudaStream_t stream = nullptr;
  check(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), "no stream");

  psplit::CudaPrimitive primitive;
  primitive.container = &mesh->container();
  primitive.indices = target;
  primitive.attributes = {{0, psplit::ComponentType::kFloat32, 3, target + positions_at, 12}};
  psplit::CudaBatch batch = psplit::CudaBatch::plan({&primitive, 1});
  check(batch.prepare());

  // The device waits for the engine, decodes, and tells the engine; the host waits only for the status.
  cudaExternalSemaphoreWaitParams wait{};
  cudaExternalSemaphoreSignalParams signal{};
  wait.params.fence.value = signal.params.fence.value = count > 6 ? std::strtoull(words[6], nullptr, 0) : 1;
  check(cudaWaitExternalSemaphoresAsync(&ready, &wait, 1, stream), "the semaphore cannot be waited for");
  check(batch.enqueue(stream));
  check(cudaSignalExternalSemaphoresAsync(&done, &signal, 1, stream), "the semaphore cannot be signalled");
  check(batch.finish());

  check(cudaStreamSynchronize(stream), "the stream");
  (void)cudaDestroyExternalSemaphore(ready);
  (void)cudaDestroyExternalSemaphore(done);
  (void)cudaFree(target);
  (void)cudaDestroyExternalMemory(memory);
  (void)cudaStreamDestroy(stream);
}
