#include "tools/gltf_psplit/options/machine_limits.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "system/child_process.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// The first number of a file, or nothing if it begins with a word such as "max". `second` is the next number.
std::optional<double> first_number(const fs::path& path, double* second = nullptr) {
  std::ifstream file(path);
  double number = 0;
  if (!(file >> number)) return std::nullopt;
  if (second != nullptr) file >> *second;
  return number;
}

void limit_processors(CgroupLimits& limits, std::optional<double> quota, double period) {
  if (!quota || *quota <= 0 || period <= 0) return;
  const double processors = *quota / period;
  limits.processors = limits.processors == 0 ? processors : std::min(limits.processors, processors);
}

void limit_memory(CgroupLimits& limits, std::optional<double> bytes) {
  constexpr double kNoLimit = 1e18;  // version 1 writes a number near 2^63
  if (!bytes || *bytes <= 0 || *bytes >= kNoLimit) return;
  const auto memory = static_cast<uint64_t>(*bytes);
  limits.memory = limits.memory == 0 ? memory : std::min(limits.memory, memory);
}

void read_limits(CgroupLimits& limits, const fs::path& group) {
  double period = 0;
  const std::optional<double> quota = first_number(group / "cpu.max", &period);
  limit_processors(limits, quota, period);
  limit_memory(limits, first_number(group / "memory.max"));
  limit_processors(limits, first_number(group / "cpu.cfs_quota_us"),
                   first_number(group / "cpu.cfs_period_us").value_or(0));
  limit_memory(limits, first_number(group / "memory.limit_in_bytes"));
}

}  // namespace

CgroupLimits cgroup_limits(const fs::path& root) {
  CgroupLimits limits;
  std::ifstream groups(root / "proc/self/cgroup");
  // "0::/a/b" for version 2, "4:cpu,cpuacct:/a/b" for version 1.
  for (std::string line; std::getline(groups, line);) {
    const size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    // The folder may name the controllers in another order. Then each has a link with its own name.
    std::vector<std::string> folders{controllers};
    std::istringstream names(controllers);
    for (std::string name; std::getline(names, name, ',');) folders.push_back(name);
    for (const std::string& folder : folders) {
      const fs::path mount = root / "sys/fs/cgroup" / folder;
      // A container may see its cgroup as the root, so that the path names nothing: then only the root is read.
      for (fs::path group = fs::path(line.substr(second + 1)).relative_path();; group = group.parent_path()) {
        read_limits(limits, mount / group);
        if (group.empty()) break;
      }
    }
  }
  return limits;
}

int default_thread_count(const CgroupLimits& limits) {
  const int most = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return limits.processors == 0 ? most : std::clamp(static_cast<int>(std::ceil(limits.processors)), 1, most);
}

uint64_t default_memory(const CgroupLimits& limits) {
  const uint64_t machine = machine_memory();
  const uint64_t most = limits.memory == 0 ? machine
                        : machine == 0     ? limits.memory
                                           : std::min(machine, limits.memory);
  return most / 10 * 9;
}

}  // namespace psplit
