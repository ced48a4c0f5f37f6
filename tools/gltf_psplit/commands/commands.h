// The subcommands of gltf-psplit: add_<name>_command is in command_<name>.cpp.
#pragma once

#include <functional>

#include "psplit/base.h"
#include "tools/gltf_psplit/options/session.h"

namespace CLI {
class App;
}

namespace psplit {

// Parses the command line and runs its subcommand. Results go to stdout, everything else to stderr. Returns the
// exit code, which is a StatusCode. Does not throw.
int run_command_line(int argc, char** argv, const char* version = "unknown");

using Action = std::function<Status(const Session&)>;

// Each function adds the options of a subcommand. A command line that names the subcommand sets `action` while
// it is parsed.
void add_encode_command(CLI::App& command, Action& action);
void add_batch_command(CLI::App& command, Action& action);
void add_decode_command(CLI::App& command, Action& action);
void add_expand_command(CLI::App& command, Action& action);
void add_inspect_command(CLI::App& command, Action& action);
void add_validate_command(CLI::App& command, Action& action);
void add_compare_command(CLI::App& command, Action& action);
void add_diff_command(CLI::App& command, Action& action);
void add_generate_command(CLI::App& command, Action& action);

}  // namespace psplit
