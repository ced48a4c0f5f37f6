// The command, for tests that run it as a process.
#pragma once

namespace psplit {

const char* command_file();

}  // namespace psplit
