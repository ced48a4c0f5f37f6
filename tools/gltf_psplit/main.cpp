#include "psplit/version.h"
#include "system/operating_system.h"
#include "tools/gltf_psplit/commands/commands.h"

int main(int argc, char** argv) {
  std::vector<char*> words = psplit::start_command(argc, argv);
  return psplit::run_command_line(static_cast<int>(words.size()), words.data(), PSPLIT_VERSION_TEXT);
}
