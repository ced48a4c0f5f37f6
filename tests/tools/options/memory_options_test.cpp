#include "tools/gltf_psplit/options/memory_options.h"

#include <stdlib.h>

#include "system/operating_system.h"
#include "tests/support/environment.h"
#include "tests/support/test_folder.h"
#include "tests/tools/run_command.h"

namespace psplit {
namespace {

// Sets the system's folder for temporary files for one test.
class TemporaryDirectory {
 public:
  explicit TemporaryDirectory(const std::string& folder) {
    const char* const before = getenv(name_);
    if (before != nullptr) before_ = before;
    set_variable(name_, folder.c_str());
  }
  ~TemporaryDirectory() { set_variable(name_, before_ ? before_->c_str() : nullptr); }

 private:
  const char* const name_ = is_posix() ? "TMPDIR" : "TMP";
  std::optional<std::string> before_;
};

TEST(MemoryOptions, TemporaryFilesAreBesideTheOutputOrInTheSystemsFolder) {
  const TestFolder folder, other;
  const TemporaryDirectory set(folder.path().string());
  if (is_in_memory(folder.path())) GTEST_SKIP() << "the folder of tests is in memory";
  // The system may end the name of its folder with a separator.
  EXPECT_EQ(temporary_folder("", "-") / "", folder.path() / "");
  EXPECT_EQ(temporary_folder("", (other / "a.glb").string()), other.path());
  EXPECT_EQ(temporary_folder("", "a.glb"), ".");
  EXPECT_EQ(temporary_folder("wanted", (other / "a.glb").string()), "wanted");
}

TEST(MemoryOptions, TemporaryFilesAreNotInMemory) {
  const std::filesystem::path memory = "/dev/shm", disk = "/var/tmp";
  if (!is_in_memory(memory) || is_in_memory(disk) || !may_write_into(memory) || !may_write_into(disk))
    GTEST_SKIP() << "/dev/shm is not a folder in memory, or /var/tmp is one";
  const TestFolder folder;
  const TemporaryDirectory set(memory.string());
  EXPECT_EQ(temporary_folder("", "-"), disk);
  EXPECT_EQ(temporary_folder("", "/dev/shm/a.glb"), disk);
  EXPECT_EQ(temporary_folder("/dev/shm", "-"), memory);
  const TemporaryDirectory missing((folder / "missing").string());
  EXPECT_EQ(temporary_folder("", "-"), disk);
}

TEST(MemoryOptions, EveryCommandNamesTheFolder) {
  for (const std::string command : {"encode", "decode", "validate", "diff"}) {
    const std::string help = run_command({command, "--help"}).out;
    EXPECT_TRUE(contains(help, "--temporary FOLDER")) << command;
    EXPECT_TRUE(contains(help, "/var/tmp")) << command;
  }
}

}  // namespace
}  // namespace psplit
