// --memory and --temporary of commands that decode: how much memory they take.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "psplit/document.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace psplit {

struct MemoryChoice {
  uint64_t bytes = 0;     // 0: as the container or the machine allows
  std::string temporary;  // the folder of temporary files; empty: the output's, or the system's
};

// --temporary. `folder` must outlive the parse.
CLI::Option* add_temporary_option(CLI::App& command, std::string& folder);

// `choice` must outlive the parse. `more` is the rest of the help text of --memory.
void add_memory_options(CLI::App& command, MemoryChoice& choice, const std::string& more);

// The folder of temporary files: `wanted`; if that is empty, the first folder of these that this process may
// write into and that is not in memory: the folder of the output (not for "-"), the system's folder of
// temporary files, /var/tmp. If there is none, the first of them.
std::filesystem::path temporary_folder(const std::string& wanted, const std::string& output);

// The folder for the content of pipes; empty if no memory is stated: then they are read into memory.
std::filesystem::path spool_folder(const MemoryChoice& choice, const std::string& output = "-");

// The limit for primitives. `output` is the path of the asset that the command writes, or "-".
MemoryLimit memory_limit(const MemoryChoice& choice, const std::string& output = "-");

}  // namespace psplit
