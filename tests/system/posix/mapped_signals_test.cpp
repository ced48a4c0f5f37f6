// Signals that come of mapped files.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <string>
#include <vector>

#include "system/files.h"
#include "system/mapped_file.h"
#include "system/operating_system.h"
#include "tests/support/sanitizers.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

class MappedSignals : public testing::Test {
 protected:
  MappedSignals() { EXPECT_TRUE(write_file(path_, {std::vector<uint8_t>(200000)}).ok()); }

  struct Ending {
    int code;  // or minus the signal
    std::string text;
  };
  // What a new process writes to stderr, and how it ends.
  template <typename Act>
  static Ending in_process(const Act& act) {
    int ends[2];
    EXPECT_EQ(pipe(ends), 0);
    const pid_t child = fork();
    if (child == 0) {
      dup2(ends[1], STDERR_FILENO);
      const rlimit no_core{0, 0};
      setrlimit(RLIMIT_CORE, &no_core);
      act();
      _exit(0);
    }
    close(ends[1]);
    Ending ending;
    char block[512];
    for (ssize_t got; (got = read(ends[0], block, sizeof(block))) > 0;)
      ending.text.append(block, static_cast<size_t>(got));
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    ending.code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    return ending;
  }

  TestFolder folder_;
  const fs::path path_ = folder_ / "x.bin";
};

TEST_F(MappedSignals, AFileThatIsCutEndsTheProcessWithItsName) {
  const Ending ending = in_process([&] {
    const Expected<MappedFile> other = MappedFile::open(path_);
    const Expected<MappedFile> file = MappedFile::open(path_);
    fs::resize_file(path_, 10);
    std::fprintf(stderr, "%d", file->bytes()[190000]);
  });
  EXPECT_EQ(ending.code, kExitIo);
  EXPECT_EQ(ending.text, "gltf-psplit: error: " + path_.string() +
                             ": the file became shorter, or its device failed, while it was read\n");
}

// Sanitizers have a handler of their own.
#if !defined(PSPLIT_ASAN) && !defined(PSPLIT_TSAN)
TEST_F(MappedSignals, OtherSignalsGoToTheHandlerBefore) {
  EXPECT_EQ(in_process([&] {
              const Expected<MappedFile> file = MappedFile::open(path_);
              std::raise(SIGBUS);
            }).code,
            -SIGBUS);
  const Ending ending = in_process([&] {
    std::signal(SIGBUS, [](int) { _exit(7); });
    { const Expected<MappedFile> file = MappedFile::open(path_); }
    std::raise(SIGBUS);
  });
  EXPECT_EQ(ending.code, 7);
}
#endif

}  // namespace
}  // namespace psplit
