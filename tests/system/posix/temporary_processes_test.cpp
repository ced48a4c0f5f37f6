// Temporary files of processes that live, have ended, or get a signal.
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <string>

#include "system/files.h"
#include "system/io_error.h"
#include "system/operating_system.h"
#include "system/temporary_file.h"
#include "tests/support/child.h"
#include "tests/system/temporary_files.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

class TemporaryProcesses : public TemporaryFilesTest {};

TEST_F(TemporaryProcesses, WhatADeadWriterLeftGoes) {
  const fs::path target = folder_ / "x.glb";
  run_in_child([&] {
    const TemporaryFile file(target);
    return std::fputs("half", file.file()) >= 0 && std::fflush(file.file()) == 0 ? (_exit(0), 0) : 1;
  });
  ASSERT_EQ(file_count(), 1);
  EXPECT_TRUE(is_temporary_name(*fs::directory_iterator(folder_)));
  ASSERT_TRUE(write_file(folder_ / "another.glb", {bytes_}).ok());
  EXPECT_EQ(file_count(), 1);
  EXPECT_TRUE(fs::exists(folder_ / "another.glb"));
}

TEST_F(TemporaryProcesses, WhatALiveWriterHasStays) {
  TemporaryFile mine(folder_ / "x.glb");
  ASSERT_TRUE(mine.is_open());
  EXPECT_EQ(run_in_child([&] {
              remove_dead_temporaries(folder_);
              return fs::exists(mine.path()) ? 0 : 1;
            }),
            0);
  remove_dead_temporaries(folder_);
  EXPECT_TRUE(fs::exists(mine.path()));
  EXPECT_TRUE(mine.rename_to(folder_ / "x.glb").ok());
  EXPECT_EQ(file_count(), 1);
}

TEST_F(TemporaryProcesses, ASignalRemovesThem) {
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
    const int code = run_in_child([&] {
      if (std::freopen("/dev/null", "w", stderr) == nullptr) return 1;
      const StopEndsProcess stop_ends_process;
      const TemporaryFile one(folder_ / "x.glb"), two(folder_ / "y.glb");
      TemporaryFile done(folder_ / "z.glb");
      if (file_count() != 3 || !done.rename_to(folder_ / "z.glb").ok()) return 2;
      std::raise(signal);
      return 3;
    });
    EXPECT_EQ(code, kExitMayPass);
    EXPECT_EQ(file_count(), 1);
    EXPECT_TRUE(fs::remove(folder_ / "z.glb"));
  }
  // What the process ignores, as nohup makes it do, does not end it.
  EXPECT_EQ(run_in_child([] {
              std::signal(SIGHUP, SIG_IGN);
              const StopEndsProcess stop_ends_process;
              std::raise(SIGHUP);
              return 7;
            }),
            7);
}

TEST_F(TemporaryProcesses, TheLimitOnAFilesSizeIsAnErrorAndLeavesNothing) {
  const int code = run_in_child([&] {
    let_writes_past_size_limit_fail();
    const rlimit limit{4096, 4096};
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0) return 1;
    const Status status = write_file(folder_ / "x.glb", {bytes_});
    return status.code() == StatusCode::kIo && status.message().find("too large") != std::string::npos ? 0 : 2;
  });
  EXPECT_EQ(code, 0);
  EXPECT_EQ(file_count(), 0);
}

}  // namespace
}  // namespace psplit
