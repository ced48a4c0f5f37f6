// Runs gltf-psplit inside a test. It must not run in two threads at once: it redirects stdout and stderr.
#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "psplit/encode.h"
#include "tests/support/environment.h"
#include "tests/support/expect.h"
#include "tests/support/test_folder.h"
#include "tools/gltf_psplit/commands/commands.h"

namespace psplit {

// Why a test is skipped.
inline constexpr const char* kNoDraco = "built without libdraco";

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

// As above, with the file `input` as stdin.
inline CommandOutcome run_command_on(const std::string& input, std::vector<std::string> words) {
  EXPECT_NE(std::freopen(input.c_str(), "rb", stdin), nullptr);
  CommandOutcome outcome = run_command(std::move(words));
  EXPECT_NE(std::freopen(null_device(), "rb", stdin), nullptr);
  return outcome;
}

inline std::string read_bytes(const std::filesystem::path& path) {
  std::ostringstream bytes;
  bytes << std::ifstream(path, std::ios::binary).rdbuf();
  return bytes.str();
}

// A test with a folder of its own.
class CommandTest : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_ / name).make_preferred().string(); }
  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  size_t file_count() const {
    return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder_), {}));
  }

  // Whether the command said that its build lacks a library.
  bool lacks_library() const { return err_.find("was built without") != std::string::npos; }

  // Keeps what the command printed in out_ and err_, and returns its exit code.
  int run(std::vector<std::string> words) {
    CommandOutcome outcome = run_command(std::move(words));
    out_ = std::move(outcome.out);
    err_ = std::move(outcome.err);
    return outcome.code;
  }
  // The command must succeed. Returns what it wrote to stdout.
  std::string must_run(std::vector<std::string> words, const char* file = __builtin_FILE(),
                       int line = __builtin_LINE()) {
    const std::string verb = words.front();
    must(run(std::move(words)) == 0 ? Status() : runtime_failure(verb + ": " + out_ + err_), file, line);
    return out_;
  }
  // The command fails with this exit code, and says this on stderr.
  void fails(int code, std::vector<std::string> words, const std::string& what,
             const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
    const testing::ScopedTrace trace(file, line, words.front());
    EXPECT_EQ(run(std::move(words)), code) << err_;
    EXPECT_TRUE(contains(err_, what));
  }
  // What the command, which must succeed, wrote to stdout.
  nlohmann::json json_of(std::vector<std::string> words, const char* file = __builtin_FILE(),
                         int line = __builtin_LINE()) {
    return nlohmann::json::parse(must_run(std::move(words), file, line));
  }
  // A JSON file of the test's folder.
  nlohmann::json read_json(const std::string& name) const {
    return nlohmann::json::parse(read_bytes(path(name)));
  }

  TestFolder folder_;
  std::string out_, err_;
};

}  // namespace psplit
