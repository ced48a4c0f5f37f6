#include "tests/support/environment.h"

#include <stdlib.h>

namespace psplit {

void set_variable(const char* name, const char* value) { _putenv_s(name, value == nullptr ? "" : value); }

bool is_posix() { return false; }

const char* null_device() { return "NUL"; }

}  // namespace psplit
