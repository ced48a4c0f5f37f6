#include "tools/gltf_psplit/options/memory_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <vector>

#include "system/operating_system.h"
#include "tools/gltf_psplit/options/count_option.h"
#include "tools/gltf_psplit/options/machine_limits.h"

namespace psplit {
namespace {

constexpr const char* kGroup = "Memory";

}  // namespace

CLI::Option* add_temporary_option(CLI::App& command, std::string& folder) {
  return command
      .add_option("--temporary", folder,
                  "The folder of temporary files, which are unnamed, so that none is left if the command is "
                  "killed. Default: the first of the output's folder, TMPDIR or /tmp, and /var/tmp that is not "
                  "in memory (tmpfs)")
      ->check(CLI::ExistingDirectory)
      ->type_name("FOLDER")
      ->group(kGroup);
}

void add_memory_options(CLI::App& command, MemoryChoice& choice, const std::string& more) {
  add_size_option(command, "--memory", choice.bytes,
                  "Take about SIZE of memory for meshes in patches, such as 4GB. " + more +
                      " Default: nine tenths of the memory of the container or the machine")
      ->group(kGroup);
  add_temporary_option(command, choice.temporary);
}

std::filesystem::path temporary_folder(const std::string& wanted, const std::string& output) {
  namespace fs = std::filesystem;
  if (!wanted.empty()) return wanted;
  std::vector<fs::path> folders;
  if (output != "-") {
    const fs::path folder = fs::path(output).parent_path();
    folders.push_back(folder.empty() ? fs::path(".") : folder);
  }
  std::error_code error;
  if (fs::path folder = fs::temp_directory_path(error); !error) folders.push_back(std::move(folder));
  folders.emplace_back("/var/tmp");
  const auto found = std::ranges::find_if(
      folders, [](const fs::path& folder) { return may_write_into(folder) && !is_in_memory(folder); });
  return found == folders.end() ? folders.front() : *found;
}

std::filesystem::path spool_folder(const MemoryChoice& choice, const std::string& output) {
  return choice.bytes == 0 ? std::filesystem::path() : temporary_folder(choice.temporary, output);
}

MemoryLimit memory_limit(const MemoryChoice& choice, const std::string& output) {
  return {choice.bytes != 0 ? choice.bytes : default_memory(cgroup_limits()),
          temporary_folder(choice.temporary, output)};
}

}  // namespace psplit
