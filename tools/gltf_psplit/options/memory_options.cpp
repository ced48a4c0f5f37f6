#include "tools/gltf_psplit/options/memory_options.h"

#include <CLI/CLI.hpp>

#include "tools/gltf_psplit/options/count_option.h"
#include "tools/gltf_psplit/options/machine_limits.h"

namespace psplit {

void add_memory_options(CLI::App& command, MemoryChoice& choice, const std::string& more) {
  constexpr const char* kGroup = "Memory";
  add_size_option(command, "--memory", choice.bytes,
                  "Take about SIZE of memory for meshes in patches, such as 4GB. " + more +
                      " Default: nine tenths of what the container or the machine has")
      ->group(kGroup);
  command.add_option("--temporary", choice.temporary, "The folder of temporary files, which have no names")
      ->check(CLI::ExistingDirectory)
      ->type_name("FOLDER")
      ->group(kGroup);
}

std::filesystem::path temporary_folder(const std::string& wanted, const std::string& output) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path folder = !wanted.empty() ? fs::path(wanted)
                          : output == "-" ? fs::temp_directory_path(error)
                                          : fs::path(output).parent_path();
  return folder.empty() ? "." : folder;
}

MemoryLimit memory_limit(const MemoryChoice& choice, const std::string& output) {
  return {choice.bytes != 0 ? choice.bytes : default_memory(cgroup_limits()),
          temporary_folder(choice.temporary, output)};
}

}  // namespace psplit
