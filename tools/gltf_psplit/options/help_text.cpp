#include "tools/gltf_psplit/options/help_text.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "system/operating_system.h"
#include "tools/gltf_psplit/report/exit_codes.h"
#include "tools/gltf_psplit/report/text_layout.h"

namespace psplit {
namespace {

constexpr size_t kMostColumns = 80, kFewestColumns = 40;

// As wide as COLUMNS or the terminal says; otherwise 80 columns.
size_t help_width() {
  const char* const columns = std::getenv("COLUMNS");
  size_t width = 0;
  if (columns != nullptr) std::from_chars(columns, columns + std::strlen(columns), width);
  if (width == 0) width = terminal_columns(stdout);
  return width == 0 ? kMostColumns : std::clamp(width, kFewestColumns, kMostColumns);
}

// The column where descriptions begin. On a narrow terminal, names and descriptions are one below the other.
size_t description_column() { return help_width() < 72 ? 6 : 30; }

// CLI11's "FORM:{text,json}" becomes "{text,json}", and its "BITS:INT in [1 - 30]" becomes "BITS".
std::string value_name(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const size_t colon = type.find(':');
  if (colon == std::string::npos) return type;
  return type.compare(colon + 1, 1, "{") == 0 ? type.substr(colon + 1) : type.substr(0, colon);
}

// CLI11's "BITS:INT in [1 - 30]" becomes " (1 to 30)".
std::string value_range(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const size_t begin = type.find(" in ["), dash = type.find(" - ", begin), end = type.find(']', begin);
  if (begin == std::string::npos || dash == std::string::npos || end == std::string::npos) return "";
  return " (" + type.substr(begin + 5, dash - begin - 5) + " to " + type.substr(dash + 3, end - dash - 3) + ")";
}

// CLI11 2.5 and newer name, order and wrap the parts of a page in another way than older ones. Here the page is
// put together, and its parts are named, so that it does not depend on the version.
class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter() { label("POSITIONALS", "Positionals"); }

  std::string make_help(const CLI::App* command, std::string name, CLI::AppFormatMode mode) const override {
    std::string text = make_description(command) + make_usage(command, std::move(name)) + "\n" +
                       make_positionals(command) + "\n" + make_groups(command, mode) + "\n" +
                       make_subcommands(command, mode) + "\n" + command->get_footer() + "\n";
    // Leaves one empty line between groups.
    for (size_t at = 0; (at = text.find("\n\n\n", at)) != std::string::npos;) text.erase(at, 1);
    return text;
  }

  std::string make_usage(const CLI::App* command, std::string name) const override {
    std::string text = CLI::Formatter::make_usage(command, "");
    return text.insert(text.find(':') + 1, " " + name);
  }

  std::string make_option(const CLI::Option* option, bool is_positional) const override {
    std::string name = make_option_name(option, is_positional);
    const std::string value = value_name(*option);  // empty for a flag
    if (!value.empty() && !is_positional) {
      name += " " + value;
      if (!option->get_default_str().empty()) name += "=" + option->get_default_str();
    }
    const bool repeats = option->get_expected_max() == CLI::detail::expected_max_vector_size;
    if (repeats && is_positional) name += " ...";
    // An output may be named by its place or by an option.
    if (!is_positional && option->get_positional()) return entry(name, "Same as " + option->get_name(true));
    return entry(name, option->get_description() + value_range(*option));
  }

  std::string make_subcommand(const CLI::App* command) const override {
    return entry(command->get_name(), command->get_description());
  }

  std::string make_description(const CLI::App* command) const override {
    return wrap_text(command->get_description() + ".", help_width(), 0) + "\n\n";
  }

 private:
  static std::string entry(const std::string& name, const std::string& description) {
    const size_t column = description_column();
    std::string line = "  " + name;
    if (line.size() + 2 > column)
      line += "\n" + std::string(column, ' ');
    else
      line.resize(column, ' ');
    return line + wrap_text(description, help_width() - column, column) + "\n";
  }
};

}  // namespace

std::shared_ptr<CLI::FormatterBase> help_formatter() { return std::make_shared<HelpFormatter>(); }

void add_examples(CLI::App& command, const std::vector<Example>& examples) {
  std::string text = "Examples:\n";
  for (const Example& example : examples)
    text += "  " + example.command_line + "\n      " + wrap_text(example.meaning, help_width() - 6, 6) + "\n";
  command.footer(text + "\n" + exit_codes_help(help_width()));
}

// Optimal string alignment, row by row: https://en.wikipedia.org/wiki/Damerau-Levenshtein_distance
size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<size_t> two_above, above(b.size() + 1), row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) above[j] = j;
  for (size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t replaced = above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, replaced});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], two_above[j - 2] + 1);
    }
    two_above = above;
    std::swap(above, row);
  }
  return above[b.size()];
}

std::string nearest_word(std::string_view word, std::span<const std::string> candidates) {
  // The beginning of a word means that word, no matter how much is missing.
  constexpr size_t kLeastStart = 3;
  std::string nearest;
  size_t least = word.size() / 3 + 1;
  for (const std::string& candidate : candidates) {
    const bool is_start = word.size() >= kLeastStart && candidate.starts_with(word);
    const size_t distance = is_start ? 1 : edit_distance(word, candidate);
    if (distance >= least) continue;
    least = distance;
    nearest = candidate;
  }
  return nearest;
}

std::string suggestion(std::string_view word, std::span<const std::string> candidates) {
  const std::string nearest = nearest_word(word, candidates);
  return nearest.empty() ? "" : "; did you mean " + nearest + "?";
}

}  // namespace psplit
