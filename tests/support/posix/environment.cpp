#include "tests/support/environment.h"

#include <stdlib.h>

namespace psplit {

void set_variable(const char* name, const char* value) {
  if (value == nullptr)
    unsetenv(name);
  else
    setenv(name, value, 1);
}

bool is_posix() { return true; }

const char* null_device() { return "/dev/null"; }

}  // namespace psplit
