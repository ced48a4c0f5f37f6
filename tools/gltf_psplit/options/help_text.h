// What helps a user at the command line: --help, completion in shells, and "did you mean ...?".
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
class FormatterBase;
}  // namespace CLI

namespace psplit {

// Lays --help out as wide as the terminal, from 40 to 80 columns.
std::shared_ptr<CLI::FormatterBase> help_formatter();

// Adds what follows the options: example command lines with their meanings, and the exit codes.
struct Example {
  std::string command_line, meaning;
};
void add_examples(CLI::App& command, const std::vector<Example>& examples);

enum class Shell { kBash, kZsh, kFish };

// A script that completes the verbs of the app, their options, and the values that options name. What else
// options and verbs take are files.
std::string completion_script(const CLI::App& app, Shell shell);

// The number of letters to insert, delete, replace or swap with their neighbour to turn one word into the
// other.
size_t edit_distance(std::string_view a, std::string_view b);

// The candidate nearest to `word`, or the first of several that are equally near. A candidate is near if
// `word`, of three letters at least, is its beginning, or if at most a third of the letters of `word` would
// change. Empty if no candidate is near.
std::string nearest_word(std::string_view word, std::span<const std::string> candidates);

// "; did you mean encode?"; empty if no candidate is near.
std::string suggestion(std::string_view word, std::span<const std::string> candidates);

}  // namespace psplit
