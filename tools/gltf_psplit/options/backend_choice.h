// --backend and --gpu-memory: which decoder a command uses.
#pragma once

#include <span>
#include <string>

#include "psplit/decode.h"

namespace CLI {
class App;
}

namespace psplit {

struct BackendChoice {
  std::string name = "auto";
  uint64_t gpu_memory = 0;  // bytes of device memory that the CUDA decoder may take; 0: all that is free
};

// Adds --backend and --gpu-memory. `choice` must outlive the parse.
void add_backend_options(CLI::App& command, BackendChoice& choice);

// Why an option cannot take `name`; empty if it can: "draco" names libdraco, which a build may be without.
std::string refuse_missing_draco(const std::string& name);

// `choice.name` is one of the names that add_backend_options accepts.
DecodeBackend find_backend(const BackendChoice& choice);

// Whether a device would decode the tasks, to the host's memory, in less time than `thread_count` threads of
// the CPU. `is_started`: it was used before. If not, `auto` uses the CPU.
bool is_worth_a_gpu(std::span<const DecodeTask> tasks, size_t thread_count, bool is_started);

// Describes streams with the decoder of the named backend. `auto` falls back to libdraco, if it is there, for
// streams that the core does not support.
DescribeStream find_describer(const std::string& name);

}  // namespace psplit
