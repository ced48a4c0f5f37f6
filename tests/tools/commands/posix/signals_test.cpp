// A signal ends every verb with the code that the help names, and leaves no file.
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <thread>

#include "system/io_error.h"
#include "tests/support/child.h"
#include "tests/tools/run_command.h"
#include "tools/gltf_psplit/report/exit_codes.h"

namespace psplit {
namespace {

class Signals : public CommandTest {
 protected:
  void SetUp() override { ASSERT_EQ(mkfifo(path("pipe.glb").c_str(), 0600), 0); }

  // Runs the words in a new process, sends the signal once the process uses the pipe, and returns its exit
  // code; -1 if it did not end by itself.
  int stopped(std::vector<std::string> words, int signal, bool is_output) {
    const pid_t child = start_child([&] {
      ::signal(signal, SIG_DFL);  // a shell that runs the tests in its background ignores SIGINT
      std::vector<char*> argv{words.front().data()};
      for (std::string& word : words) argv.push_back(word.data());
      if (std::freopen(path("err.txt").c_str(), "w", stderr) == nullptr) return 99;
      return run_command_line(static_cast<int>(argv.size()), argv.data(), "1.2.3");
    });
    int pipe = -1;
    for (int i = 0; i < 30000 && pipe < 0; ++i) {  // a pipe opens for writing once there is a reader
      pipe = open(path("pipe.glb").c_str(), O_NONBLOCK | (is_output ? O_RDONLY : O_WRONLY));
      if (pipe < 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_GE(pipe, 0) << words.front();
    pollfd readable{pipe, POLLIN, 0};
    if (is_output) poll(&readable, 1, 30000);
    kill(child, signal);
    const int code = exit_code_of(child);
    close(pipe);
    return code;
  }
};

TEST_F(Signals, EndEveryVerbWithTheCodeOfWhatMayPass) {
  const std::string pipe = path("pipe.glb"), out = path("out.glb");
  write("a.glb", "");
  std::vector<std::vector<std::string>> commands = {
      {"encode", pipe, out}, {"decode", pipe, out},
      {"expand", pipe, out}, {"inspect", pipe},
      {"validate", pipe},    {"diff", pipe, path("a.glb")},
      {"compare", pipe},     {"encode", pipe, out, "--memory", "1GB"},
  };
  if (!has_draco()) std::erase(commands, std::vector<std::string>{"compare", pipe});
  for (const std::vector<std::string>& words : commands)
    for (const int signal : {SIGTERM, SIGINT}) {
      EXPECT_EQ(stopped(words, signal, false), exit_code(StatusCode::kMayPass)) << words.front();
      EXPECT_TRUE(contains(read_bytes(path("err.txt")), "error: stopped by a signal\n")) << words.front();
    }
  EXPECT_EQ(stopped({"generate", pipe, "--faces", "20k"}, SIGTERM, true), exit_code(StatusCode::kMayPass));
  EXPECT_EQ(file_count(), 3u) << "the pipe, the empty file and the messages";
}

}  // namespace
}  // namespace psplit
