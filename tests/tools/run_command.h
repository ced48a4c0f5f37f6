// gltf-psplit run inside a test, with what it prints.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tools/gltf_psplit/commands/command_line.h"

namespace psplit {

struct CommandOutcome {
  int code = -1;
  std::string out, err;
};

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

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace psplit
