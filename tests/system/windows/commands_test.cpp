// Commands of cmd.exe.
#include <gtest/gtest.h>

#include <csignal>

#include "system/child_process.h"
#include "tests/support/expect.h"

namespace psplit {
namespace {

CommandEnd run(const std::string& command, const std::vector<std::string>& arguments = {}) {
  return must(run_shell(command, arguments));
}

TEST(Commands, TakeArgumentsInTheirQuotesOrOwn) {
  const std::string name = "a b&exit /b 3 & rem";
  for (const char* command : {"echo %2-%1", "echo %2-\"%1\"", "echo \"x\" %2-\"%1\""}) {
    const CommandEnd end = run(command, {name, "z"});
    EXPECT_EQ(end.number, 0) << command;
    EXPECT_TRUE(contains(end.last_lines, "\"z\"-\"" + name + "\"")) << end.last_lines;
  }
  EXPECT_TRUE(contains(run("echo \"<%1>\"", {name}).last_lines, "\"<" + name + ">\""));
  EXPECT_TRUE(contains(run("echo %%1 %2", {name}).last_lines, "%1 %2"));
  EXPECT_EQ(place_of_argument(2), "%2");
}

TEST(Commands, EndWithACodeOrAsTheSystemEndsThem) {
  EXPECT_FALSE(run("exit /b -1").by_signal);
  EXPECT_EQ(run("exit /b -1").number, -1);
  EXPECT_FALSE(run("exit /b 66").by_signal);
  const CommandEnd interrupted = run("exit /b -1073741510"), crashed = run("exit /b -1073741819");
  EXPECT_TRUE(interrupted.by_signal);
  EXPECT_EQ(interrupted.number, SIGINT);
  EXPECT_TRUE(crashed.by_signal);
  EXPECT_EQ(crashed.number, SIGSEGV);
}

}  // namespace
}  // namespace psplit
