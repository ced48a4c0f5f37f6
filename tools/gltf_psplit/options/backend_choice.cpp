#include "tools/gltf_psplit/options/backend_choice.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <mutex>
#include <optional>

#include "encoder/libdraco/draco_backend.h"
#include "psplit/cuda.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "src/container/patch_container.h"
#include "tools/gltf_psplit/options/count_option.h"
#include "tools/gltf_psplit/options/file_options.h"

namespace psplit {
namespace {

constexpr const char* kWithoutDraco = "this gltf-psplit was built without libdraco";

// Uses CUDA if there is a device and enough work for it, the CPU for what CUDA does not decode, and libdraco
// for what neither decodes, if it is there: streams of versions before 2.2. Looks for a device only once there
// is enough work.
DecodeBackend fastest_backend(uint64_t gpu_memory) {
  struct Cuda {
    std::once_flag looked_for;
    std::atomic<bool> is_started = false;
    std::optional<DecodeBackend> backend;
  };
  return {"auto", [cuda = std::make_shared<Cuda>(), gpu_memory, cpu = cpu_backend(), draco = draco_backend()](
                      std::span<const DecodeTask> tasks, const BuffersFor& buffers_for, const ThreadPool& pool,
                      const Watch& watch) {
            std::vector<const DecodeBackend*> backends{&cpu};
            if (has_draco()) backends.push_back(&draco);
            const bool is_started = cuda->is_started.load(std::memory_order_relaxed);
            if (is_worth_a_gpu(tasks, static_cast<size_t>(pool.thread_count()), is_started)) {
              std::call_once(cuda->looked_for, [&] {
                if (cuda_available(nullptr)) cuda->backend = cuda_backend(gpu_memory);
                cuda->is_started = true;
              });
              if (cuda->backend) backends.insert(backends.begin(), &*cuda->backend);
            }
            std::vector<Status> statuses = backends[0]->decode_into(tasks, buffers_for, pool, watch);
            for (size_t next = 1; next < backends.size(); ++next) {
              std::vector<size_t> left;
              std::vector<DecodeTask> tasks_left;
              for (size_t i = 0; i < tasks.size(); ++i) {
                // A device may run out of memory when the host does not.
                const StatusCode code = statuses[i].code();
                if (code != StatusCode::kUnsupported && code != StatusCode::kRuntimeFailure) continue;
                left.push_back(i);
                tasks_left.push_back(tasks[i]);
              }
              if (left.empty()) break;
              const auto buffers_left = [&](size_t n, uint32_t points, uint32_t faces) {
                return buffers_for(left[n], points, faces);
              };
              std::vector<Status> decoded =
                  backends[next]->decode_into(tasks_left, buffers_left, pool, {{}, watch.stop});
              for (size_t n = 0; n < left.size(); ++n) statuses[left[n]] = std::move(decoded[n]);
            }
            return statuses;
          }};
}

}  // namespace

// The device's times were measured on an H200 alone, and processors differ. A model that may be wrong by a
// factor of 2 must promise half of the CPU's time.
bool is_worth_a_gpu(std::span<const DecodeTask> tasks, size_t thread_count, bool is_started) {
  // Nanoseconds. Measured on one thread of an x86-64 at 4 GHz (docs/performance.md).
  constexpr double kCpuFace = 20;
  // Measured (docs/benchmarks.md): all faces of large batches, with planning and upload; the faces of the
  // largest stream, which are one chain of steps; and a byte of results on its way to the host's memory.
  constexpr double kDeviceFace = 0.75, kChainFace = 650, kResultByte = 0.065;
  // Assumed: the first use of a device.
  constexpr double kStart = 300e6;
  double faces = 0, largest = 0, streams = 0, result_bytes = 0;
  for (const DecodeTask& task : tasks) {
    const PatchContainer& container = *task.container;
    for (const StreamEntry& entry : container.entries) largest = std::max<double>(largest, entry.face_count);
    faces += container.face_count();
    streams += static_cast<double>(container.entries.size());
    result_bytes += 12.0 * container.face_count();
    for (const AttributeRequest& request : task.requests)
      result_bytes += static_cast<double>(request.value_bytes()) * container.point_count();
  }
  const double threads = std::max(1.0, std::min(static_cast<double>(thread_count), streams));
  const double cpu = std::max(kCpuFace * faces / threads, kCpuFace * largest);
  const double device = (is_started ? 0 : kStart) + kResultByte * result_bytes +
                        std::max(kDeviceFace * faces, kChainFace * largest);
  return 2 * device < cpu;
}

void add_backend_options(CLI::App& command, BackendChoice& choice) {
  add_choice_option(command, "--backend", choice.name, {"auto", "cuda", "cpu", "draco"},
                    "Decoder. auto: the fastest that is available; draco: stock libdraco")
      ->check(refuse_missing_draco);
  add_size_option(command, "--gpu-memory", choice.gpu_memory,
                  "Maximum device memory for the CUDA decoder, such as 512MB or 4GB. Assets that need more are "
                  "decoded in parts, with the same result. Default: all free memory");
}

std::string refuse_missing_draco(const std::string& name) {
  return name == "draco" && !has_draco() ? kWithoutDraco : "";
}

DecodeBackend find_backend(const BackendChoice& choice) {
  if (choice.name == "cuda") return cuda_backend(choice.gpu_memory);
  if (choice.name == "cpu") return cpu_backend();
  return choice.name == "draco" ? draco_backend() : fastest_backend(choice.gpu_memory);
}

DescribeStream find_describer(const std::string& name) {
  if (name == "cpu") return describe_stream;
  if (name == "draco") return describe_draco_stream;
  return [](std::span<const uint8_t> stream) -> Expected<StreamDescription> {
    Expected<StreamDescription> description = describe_stream(stream);
    if (description || description.status().code() != StatusCode::kUnsupported) return description;
    if (has_draco()) return describe_draco_stream(stream);
    const Status& status = description.status();
    return unsupported(status.message() + "; " + kWithoutDraco + ", which may decode it");
  };
}

}  // namespace psplit
