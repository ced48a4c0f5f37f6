#include "tests/tools/command_file.h"

namespace psplit {

const char* command_file() { return PSPLIT_COMMAND; }

}  // namespace psplit
