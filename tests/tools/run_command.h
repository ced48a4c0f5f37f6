// Runs gltf-psplit inside a test. It must not run in two threads at once: it redirects stdout and stderr.
#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/test_folder.h"
#include "tools/gltf_psplit/commands/command_line.h"

namespace psplit {

struct CommandOutcome {
  int code = -1;         // the exit code
  std::string out, err;  // what the command printed
};

// `words` follow the name of the command.
inline CommandOutcome run_command(std::vector<std::string> words) {
  words.insert(words.begin(), "gltf-psplit");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  CommandOutcome outcome;
  outcome.code = run_command_line(static_cast<int>(argv.size()), argv.data(), "1.2.3");
  outcome.out = testing::internal::GetCapturedStdout();
  outcome.err = testing::internal::GetCapturedStderr();
  return outcome;
}

// The same with the file `input` as stdin.
inline CommandOutcome run_command_on(const std::string& input, std::vector<std::string> words) {
  EXPECT_NE(std::freopen(input.c_str(), "rb", stdin), nullptr);
  CommandOutcome outcome = run_command(std::move(words));
  EXPECT_NE(std::freopen("/dev/null", "rb", stdin), nullptr);
  return outcome;
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

inline std::string read_bytes(const std::filesystem::path& path) {
  std::ostringstream bytes;
  bytes << std::ifstream(path, std::ios::binary).rdbuf();
  return bytes.str();
}

// A test with a folder of its own.
class CommandTest : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  size_t file_count() const {
    return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder_), {}));
  }

  // Keeps what the command printed in out_ and err_, and returns its exit code.
  int run(std::vector<std::string> words) {
    CommandOutcome outcome = run_command(std::move(words));
    out_ = std::move(outcome.out);
    err_ = std::move(outcome.err);
    return outcome.code;
  }

  TestFolder folder_;
  std::string out_, err_;
};

}  // namespace psplit
