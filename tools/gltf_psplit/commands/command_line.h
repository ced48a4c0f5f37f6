// The command gltf-psplit: main() and the tests call this function.
#pragma once

namespace psplit {

// Parses the command line and runs its subcommand. Results go to stdout, everything else to stderr. Returns the
// exit code, which is a StatusCode. Does not throw.
int run_command_line(int argc, char** argv, const char* version = "unknown");

}  // namespace psplit
