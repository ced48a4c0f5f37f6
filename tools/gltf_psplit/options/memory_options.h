// --memory and --temporary of commands that decode: how much memory they take.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "gltf_ext/primitive/memory_limit.h"

namespace CLI {
class App;
}

namespace psplit {

struct MemoryChoice {
  uint64_t bytes = 0;     // 0: as the container or the machine allows
  std::string temporary;  // the folder of temporary files; empty: the output's, or the system's
};

// `choice` must outlive the parse. `more` is the rest of the help text of --memory.
void add_memory_options(CLI::App& command, MemoryChoice& choice, const std::string& more);

// The folder of temporary files: `wanted`; if that is empty, the folder of the output, or the system's folder
// of temporary files for "-".
std::filesystem::path temporary_folder(const std::string& wanted, const std::string& output);

// The limit for primitives. `output` is the path of the asset that the command writes, or "-".
MemoryLimit memory_limit(const MemoryChoice& choice, const std::string& output = "-");

}  // namespace psplit
