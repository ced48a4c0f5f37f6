#include "tools/gltf_psplit/commands/command_line.h"

int main(int argc, char** argv) { return psplit::run_command_line(argc, argv, PSPLIT_VERSION); }
