// How --help looks: 80 columns, and examples at its end.
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

// What stands below the options: command lines with what each does, and exit codes.
struct Example {
  std::string command_line, meaning;
};
void add_examples(CLI::App& command, const std::vector<Example>& examples);

}  // namespace psplit
