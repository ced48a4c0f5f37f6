// The environment of a test.
#pragma once

namespace psplit {

// Sets a variable of the environment; null removes it.
void set_variable(const char* name, const char* value);

// Whether the system is one of POSIX. There a test can make symbolic links, give files permissions and names of
// all characters, and run a shell.
bool is_posix();

// A file that is always empty, and that takes all that is written.
const char* null_device();

}  // namespace psplit
