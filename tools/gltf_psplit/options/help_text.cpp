#include "tools/gltf_psplit/options/help_text.h"

#include <CLI/CLI.hpp>

#include "tools/gltf_psplit/report/exit_codes.h"
#include "tools/gltf_psplit/report/text_layout.h"

namespace psplit {
namespace {

constexpr size_t kWidth = 80;
constexpr size_t kColumn = 30;  // where descriptions begin

// "{text,json}" of what CLI11 calls "FORM:{text,json}", "BITS" of "BITS:INT in [1 - 30]".
std::string value_name(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const size_t colon = type.find(':');
  if (colon == std::string::npos) return type;
  return type.compare(colon + 1, 1, "{") == 0 ? type.substr(colon + 1) : type.substr(0, colon);
}

// " (1 to 30)" of "BITS:INT in [1 - 30]".
std::string value_range(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const size_t begin = type.find(" in ["), dash = type.find(" - ", begin), end = type.find(']', begin);
  if (begin == std::string::npos || dash == std::string::npos || end == std::string::npos) return "";
  return " (" + type.substr(begin + 5, dash - begin - 5) + " to " + type.substr(dash + 3, end - dash - 3) + ")";
}

class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* command, std::string name, CLI::AppFormatMode mode) const override {
    std::string text = CLI::Formatter::make_help(command, std::move(name), mode);
    // Between groups CLI11 puts two empty lines.
    for (size_t at = 0; (at = text.find("\n\n\n", at)) != std::string::npos;) text.erase(at, 1);
    return text;
  }

  std::string make_option(const CLI::Option* option, bool is_positional) const override {
    std::string name = make_option_name(option, is_positional);
    const bool takes_values = option->get_type_size() != 0;
    if (takes_values && !is_positional) {
      name += " " + value_name(*option);
      if (!option->get_default_str().empty()) name += "=" + option->get_default_str();
    }
    const bool repeats = option->get_expected_max() == CLI::detail::expected_max_vector_size;
    if (repeats && is_positional) name += " ...";
    return entry(name, option->get_description() + value_range(*option));
  }

  std::string make_subcommand(const CLI::App* command) const override {
    return entry(command->get_name(), command->get_description());
  }

  std::string make_description(const CLI::App* command) const override {
    return wrap_text(command->get_description() + ".", kWidth, 0) + "\n\n";
  }

 private:
  static std::string entry(const std::string& name, const std::string& description) {
    std::string line = "  " + name;
    if (line.size() + 2 > kColumn)
      line += "\n" + std::string(kColumn, ' ');
    else
      line.resize(kColumn, ' ');
    return line + wrap_text(description, kWidth - kColumn, kColumn) + "\n";
  }
};

}  // namespace

std::shared_ptr<CLI::FormatterBase> help_formatter() { return std::make_shared<HelpFormatter>(); }

void add_examples(CLI::App& command, const std::vector<Example>& examples) {
  std::string text = "Examples:\n";
  for (const Example& example : examples)
    text += "  " + example.command_line + "\n      " + wrap_text(example.meaning, kWidth - 6, 6) + "\n";
  command.footer(text + "\n" + exit_codes_help());
}

}  // namespace psplit
