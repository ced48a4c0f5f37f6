#include "tools/gltf_psplit/commands/commands.h"

int main(int argc, char** argv) { return psplit::run_command_line(argc, argv, PSPLIT_VERSION); }
