#include "tools/gltf_psplit/options/backend_choice.h"

#include <CLI/CLI.hpp>
#include <mutex>
#include <optional>

#include "decoder_cuda/psplit_cuda.h"
#include "encoder/draco/draco_backend.h"
#include "src/container/patch_container.h"
#include "src/cpu/cpu_backend.h"

namespace psplit {
namespace {

// Uses CUDA if there is a device and enough work for it, the CPU for what CUDA does not decode, and libdraco
// for what neither decodes: streams of versions before 2.2. Looks for a device only once there is enough work.
DecodeBackend fastest_backend(uint64_t gpu_memory) {
  struct Cuda {
    std::once_flag looked_for;
    std::optional<DecodeBackend> backend;
  };
  return {"auto", [cuda = std::make_shared<Cuda>(), gpu_memory, cpu = cpu_backend(), draco = draco_backend()](
                      std::span<const DecodeTask> tasks, const BuffersFor& buffers_for, const ThreadPool& pool,
                      const Watch& watch) {
            std::vector<const DecodeBackend*> backends{&cpu, &draco};
            if (is_worth_a_gpu(tasks)) {
              std::call_once(cuda->looked_for, [&] {
                if (cuda_available(nullptr)) cuda->backend = cuda_backend(gpu_memory);
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

// These limits are not measured. A device decodes one stream more slowly than a CPU core does, and its start
// takes longer than the CPU needs for some hundred kilobytes. Condensed streams do not count: the CPU has to
// expand them for a device, in about the time that it decodes them in.
bool is_worth_a_gpu(std::span<const DecodeTask> tasks) {
  constexpr size_t kFewestStreams = 64, kFewestBytes = size_t{256} << 10;
  size_t bytes = 0, streams = 0;
  for (const DecodeTask& task : tasks) {
    if (task.container->condensed_count() > 0) continue;
    bytes += task.container->bytes.size();
    streams += task.container->entries.size();
  }
  return bytes >= kFewestBytes && streams >= kFewestStreams;
}

void add_backend_options(CLI::App& command, BackendChoice& choice) {
  command
      .add_option("--backend", choice.name,
                  "Decoder. auto: the fastest that is available; draco: stock libdraco")
      ->check(CLI::IsMember({"auto", "cuda", "cpu", "draco"}))
      ->capture_default_str()
      ->type_name("NAME");
  command
      .add_option(
          "--gpu-memory", choice.gpu_memory,
          "Most memory that the CUDA decoder may use on its device, such as 512MB or 4GB. What needs more is "
          "decoded in parts, with the same result. Default: all free memory")
      ->check(
          [](const std::string& text) { return std::string(text.starts_with('-') ? "must be positive" : ""); })
      ->transform(CLI::AsSizeValue(false))
      ->type_name("SIZE");
}

DecodeBackend find_backend(const BackendChoice& choice) {
  if (choice.name == "cuda") return cuda_backend(choice.gpu_memory);
  if (choice.name == "cpu") return cpu_backend();
  return choice.name == "draco" ? draco_backend() : fastest_backend(choice.gpu_memory);
}

DescribeStream find_describer(const std::string& name) {
  if (name == "cpu") return describe_stream;
  if (name == "draco") return describe_draco_stream;
  return [](std::span<const uint8_t> stream) {
    Expected<StreamDescription> description = describe_stream(stream);
    if (description || description.status().code() != StatusCode::kUnsupported) return description;
    return describe_draco_stream(stream);
  };
}

}  // namespace psplit
