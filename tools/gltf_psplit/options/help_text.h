// The layout of --help: as wide as the terminal, from 40 to 80 columns, with examples at the end.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace CLI {
class App;
class FormatterBase;
}  // namespace CLI

namespace psplit {

std::shared_ptr<CLI::FormatterBase> help_formatter();

// Adds what follows the options: example command lines with their meanings, and the exit codes.
struct Example {
  std::string command_line, meaning;
};
void add_examples(CLI::App& command, const std::vector<Example>& examples);

}  // namespace psplit
