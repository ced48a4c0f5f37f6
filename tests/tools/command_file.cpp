#include "tests/tools/command_file.h"

#include <gtest/gtest.h>

#include "system/child_process.h"
#include "system/operating_system.h"

namespace psplit {

const char* command_file() { return PSPLIT_COMMAND; }

namespace {

// The runner is not the command, but runs its code: streams of bytes, and the command as the worker of a batch.
class AsCommand : public testing::Environment {
  void SetUp() override {
    char* no_words[] = {nullptr};
    start_command(0, no_words);
    set_child_program(command_file());
  }
};
[[maybe_unused]] const testing::Environment* const as_command =
    testing::AddGlobalTestEnvironment(new AsCommand);

}  // namespace

}  // namespace psplit
