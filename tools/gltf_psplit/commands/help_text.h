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

// Words of `text` in lines of at most `width` columns; every line but the first begins with `indent` spaces.
std::string wrap_text(const std::string& text, size_t width, size_t indent);

std::shared_ptr<CLI::FormatterBase> help_formatter();

// What stands below the options: command lines with what each does, and exit codes.
struct Example {
  std::string command_line, meaning;
};
void add_examples(CLI::App& command, const std::vector<Example>& examples);

}  // namespace psplit
