#include "tests/support/environment.h"

#include <stdlib.h>

namespace psplit {

void set_variable(const char* name, const char* value) { _putenv_s(name, value == nullptr ? "" : value); }

bool has_links() { return false; }

const char* null_device() { return "NUL"; }

}  // namespace psplit
