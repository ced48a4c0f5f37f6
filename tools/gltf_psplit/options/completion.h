// Completion scripts of shells, made of the options of the command line.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace psplit {

enum class Shell { kBash, kZsh, kFish };

// A script that completes the verbs of the app, their options, and the values that options name. What else
// options and verbs take are files.
std::string completion_script(const CLI::App& app, Shell shell);

}  // namespace psplit
