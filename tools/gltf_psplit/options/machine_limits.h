// The processors and the memory that this process may use, which a container's cgroup may limit.
#pragma once

#include <cstdint>
#include <filesystem>

namespace psplit {

struct CgroupLimits {
  double processors = 0;  // the quota of CPU time, in processors; 0: no limit
  uint64_t memory = 0;    // bytes; 0: no limit
};

// The limits of this process's cgroup and of all cgroups above it, of version 1 or 2. `root` replaces "/", for
// tests. Files that are missing or unreadable limit nothing.
CgroupLimits cgroup_limits(const std::filesystem::path& root = "/");

// The number of threads for -j 0: as many as the machine runs at once, but no more than the quota, rounded up.
int default_thread_count(const CgroupLimits& limits);
// The default of --memory: nine tenths of what the cgroup allows and of what the machine has. 0 if both are
// unknown.
uint64_t default_memory(const CgroupLimits& limits);

}  // namespace psplit
