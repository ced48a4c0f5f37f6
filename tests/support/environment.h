// The environment of a test.
#pragma once

namespace psplit {

// Sets a variable of the environment; null removes it.
void set_variable(const char* name, const char* value);

// Whether a test can make symbolic links, and give files the permissions of POSIX.
bool has_links();

// A file that is always empty, and that takes all that is written.
const char* null_device();

}  // namespace psplit
