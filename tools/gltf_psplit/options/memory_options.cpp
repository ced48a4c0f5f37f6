#include "tools/gltf_psplit/options/memory_options.h"

#include <CLI/CLI.hpp>

#include "tools/gltf_psplit/options/machine_limits.h"

namespace psplit {

void add_memory_options(CLI::App& command, MemoryChoice& choice, const std::string& more) {
  constexpr const char* kGroup = "Memory";
  command
      .add_option("--memory", choice.bytes,
                  "Take about SIZE of memory for meshes in patches, such as 4GB. " + more +
                      " Default: nine tenths of what the container or the machine has")
      ->check(
          [](const std::string& text) { return std::string(text.starts_with('-') ? "must be positive" : ""); })
      ->transform(CLI::AsSizeValue(false))
      ->type_name("SIZE")
      ->group(kGroup);
  command.add_option("--temporary", choice.temporary, "The folder of temporary files, which have no names")
      ->check(CLI::ExistingDirectory)
      ->type_name("FOLDER")
      ->group(kGroup);
}

MemoryLimit memory_limit(const MemoryChoice& choice, const std::string& output) {
  namespace fs = std::filesystem;
  MemoryLimit limit;
  limit.bytes = choice.bytes != 0 ? choice.bytes : default_memory(cgroup_limits());
  std::error_code error;
  if (!choice.temporary.empty())
    limit.folder = choice.temporary;
  else if (output == "-")
    limit.folder = fs::temp_directory_path(error);
  else
    limit.folder = fs::path(output).parent_path();
  if (limit.folder.empty()) limit.folder = ".";
  return limit;
}

}  // namespace psplit
