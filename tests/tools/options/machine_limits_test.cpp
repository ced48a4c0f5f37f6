#include "tools/gltf_psplit/options/machine_limits.h"

#include <fstream>
#include <string>
#include <thread>

#include "tests/support/environment.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

class MachineLimits : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
  }
  TestFolder folder_;
};

TEST_F(MachineLimits, AreThoseOfAllGroupsAboveOfVersion2) {
  write("proc/self/cgroup", "0::/kubepods/pod\n");
  EXPECT_EQ(cgroup_limits(folder_).memory, 0u);
  write("sys/fs/cgroup/kubepods/pod/cpu.max", "250000 100000\n");
  write("sys/fs/cgroup/kubepods/pod/memory.max", "max\n");
  write("sys/fs/cgroup/kubepods/cpu.max", "max 100000\n");
  write("sys/fs/cgroup/kubepods/memory.max", "2000000000\n");
  EXPECT_EQ(cgroup_limits(folder_).processors, 2.5);
  EXPECT_EQ(cgroup_limits(folder_).memory, 2000000000u);
  EXPECT_EQ(default_memory(cgroup_limits(folder_)), 1800000000u);
}

TEST_F(MachineLimits, AreReadAlsoOfVersion1AndOfAContainersRoot) {
  write("proc/self/cgroup", "5:memory:/docker/x\n4:cpu,cpuacct:/docker/x\n1:name=systemd:/docker/x\n");
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  write("sys/fs/cgroup/cpu,cpuacct/cpu.cfs_quota_us", "-1\n");
  write("sys/fs/cgroup/cpu,cpuacct/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(cgroup_limits(folder_).processors, 0);
  EXPECT_EQ(cgroup_limits(folder_).memory, 0u);
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "1073741824\n");
  write("sys/fs/cgroup/cpu,cpuacct/cpu.cfs_quota_us", "50000\n");
  EXPECT_EQ(cgroup_limits(folder_).processors, 0.5);
  EXPECT_EQ(cgroup_limits(folder_).memory, 1073741824u);
}

// RHEL 7 says "cpuacct,cpu"; the folder is "cpu,cpuacct", with the links "cpu" and "cpuacct".
TEST_F(MachineLimits, AreFoundWhateverTheOrderOfControllers) {
  if (!is_posix()) GTEST_SKIP() << "no links";
  write("proc/self/cgroup", "4:cpuacct,cpu:/slice\n");
  write("sys/fs/cgroup/cpu,cpuacct/slice/cpu.cfs_quota_us", "150000\n");
  write("sys/fs/cgroup/cpu,cpuacct/slice/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(cgroup_limits(folder_).processors, 0);
  fs::create_directory_symlink("cpu,cpuacct", folder_ / "sys/fs/cgroup/cpu");
  EXPECT_EQ(cgroup_limits(folder_).processors, 1.5);
}

TEST_F(MachineLimits, ThreadsFollowTheQuotaUpToTheMachine) {
  const int machine = static_cast<int>(std::thread::hardware_concurrency());
  EXPECT_EQ(default_thread_count({}), machine);
  EXPECT_EQ(default_thread_count({.processors = 0.2}), 1);
  EXPECT_EQ(default_thread_count({.processors = 1000}), machine);
  EXPECT_GT(default_memory({}), 0u);
}

}  // namespace
}  // namespace psplit
