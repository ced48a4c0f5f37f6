// gltf-psplit: what main() runs, callable from tests.
#pragma once

namespace psplit {

// Results go to stdout, everything else to stderr. Returns the exit code: a StatusCode. Throws nothing.
int run_command_line(int argc, char** argv, const char* version = "unknown");

}  // namespace psplit
