#include <CLI/CLI.hpp>
#include <vector>

#include "tools/gltf_psplit/options/help_text.h"
#include "tools/gltf_psplit/report/text_layout.h"

namespace psplit {
namespace {

// An option, or a subcommand.
struct Word {
  std::vector<std::string> names;  // with dashes
  std::string meaning;
  bool takes_value = false;
  std::vector<std::string> values;  // if these are all that it takes
};

struct Command {
  std::string path;         // "batch plan"; empty for the app
  std::vector<Word> parts;  // its subcommands
  std::vector<Word> options;
  std::vector<std::string> values;  // that its words without a name take
};

std::string first_sentence(const std::string& text) { return text.substr(0, text.find(". ")); }

// CLI11 calls the type of an option with a list of values "NAME:{a,b}".
std::vector<std::string> values_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const size_t open = type.find('{'), close = type.find('}');
  if (open == std::string::npos || close == std::string::npos || close < open) return {};
  return CLI::detail::split(type.substr(open + 1, close - open - 1), ',');
}

std::vector<CLI::App*> parts_of(const CLI::App& app) {
  return const_cast<CLI::App&>(app).get_subcommands([](CLI::App*) { return true; });
}

void collect(const CLI::App& app, const std::string& path, std::vector<Command>& commands) {
  Command command{path, {}, {}, {}};
  for (const CLI::Option* option : app.get_options()) {
    // Only flags have no type.
    Word word{
        {}, first_sentence(option->get_description()), !option->get_type_name().empty(), values_of(*option)};
    for (const std::string& name : option->get_snames()) word.names.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) word.names.push_back("--" + name);
    if (word.names.empty())
      command.values.insert(command.values.end(), word.values.begin(), word.values.end());
    else
      command.options.push_back(std::move(word));
  }
  const std::vector<CLI::App*> parts = parts_of(app);
  for (const CLI::App* part : parts)
    command.parts.push_back({{part->get_name()}, first_sentence(part->get_description()), false, {}});
  commands.push_back(std::move(command));
  for (const CLI::App* part : parts)
    collect(*part, path + (path.empty() ? "" : " ") + part->get_name(), commands);
}

std::vector<std::string> names_of(const std::vector<Word>& words) {
  std::vector<std::string> names;
  for (const Word& word : words) names.insert(names.end(), word.names.begin(), word.names.end());
  return names;
}

// Puts a text in single quotes. fish escapes a quote within them; other shells close them before it.
std::string quoted(std::string text, bool is_fish) {
  for (size_t at = 0; (at = text.find_first_of(is_fish ? "\\'" : "'", at)) != std::string::npos;) {
    const std::string escaped = is_fish ? "\\" + text.substr(at, 1) : "'\\''";
    text.replace(at, 1, escaped);
    at += escaped.size();
  }
  return "'" + text + "'";
}

// "  case WORD in" and so on: which verb the words before the cursor name, and which values an option takes.
std::string cases(const std::vector<Command>& commands, const char* one_word, const char* previous) {
  std::string text = std::string("    case \"$verb ") + one_word + "\" in\n";
  for (const Command& command : commands)
    for (const Word& part : command.parts)
      text += "      '" + command.path + " " + part.names.front() + "') verb='" +
              (command.path.empty() ? "" : command.path + " ") + part.names.front() + "' ;;\n";
  text += std::string("    esac\n  done\n  case \"$verb:") + previous + "\" in\n";
  for (const Command& command : commands)
    for (const Word& option : command.options) {
      if (!option.takes_value) continue;
      std::vector<std::string> patterns;
      for (const std::string& name : option.names) patterns.push_back("'" + command.path + ":" + name + "'");
      text += "    " + joined(patterns, "|") + ") is_value=1; found=(" + joined(option.values, " ") + ") ;;\n";
    }
  return text + "  esac\n";
}

std::string bash_script(const std::vector<Command>& commands) {
  std::string text =
      "# Completion of gltf-psplit for bash.\n"
      "_gltf_psplit() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} verb='' is_value='' "
      "found=() i\n"
      "  [ \"$word\" = = ] && word=\n"
      "  [ \"$previous\" = = ] && previous=${COMP_WORDS[COMP_CWORD-2]}\n"
      "  for ((i = 1; i < COMP_CWORD; ++i)); do\n" +
      cases(commands, "${COMP_WORDS[i]}", "$previous") +
      "  if [ -z \"$is_value\" ]; then\n"
      "    case \"$verb:$word\" in\n";
  for (const Command& command : commands) {
    std::vector<std::string> words = names_of(command.parts);
    words.insert(words.end(), command.values.begin(), command.values.end());
    text += "      '" + command.path + ":-'*) found=(" + joined(names_of(command.options), " ") + ") ;;\n";
    text += "      '" + command.path + ":'*) found=(" + joined(words, " ") + ") ;;\n";
  }
  return text +
         "    esac\n"
         "  fi\n"
         "  COMPREPLY=($(compgen -W \"${found[*]}\" -- \"$word\"))\n"
         "}\n"
         "complete -o default -F _gltf_psplit gltf-psplit\n";
}

// "name:meaning", for _describe.
std::string described(const std::vector<Word>& words) {
  std::string text;
  for (const Word& word : words)
    for (const std::string& name : word.names) text += " " + quoted(name + ":" + word.meaning, false);
  return text;
}

std::string zsh_script(const std::vector<Command>& commands) {
  std::string text =
      "#compdef gltf-psplit\n"
      "# Completion of gltf-psplit for zsh.\n"
      "_gltf_psplit() {\n"
      "  local verb='' is_value='' i\n"
      "  local -a found\n"
      "  for ((i = 2; i < CURRENT; ++i)); do\n" +
      cases(commands, "${words[i]}", "${words[CURRENT-1]}") +
      "  if [ -n \"$is_value\" ]; then\n"
      "    if ((${#found})); then compadd -- $found; else _files; fi\n"
      "    return\n"
      "  fi\n"
      "  case \"$verb:$PREFIX\" in\n";
  for (const Command& command : commands) {
    text += "    '" + command.path + ":-'*) found=(" + described(command.options) + ") ;;\n";
    text += "    '" + command.path + ":'*) found=(" + described(command.parts);
    for (const std::string& value : command.values) text += " " + value;
    text += ") ;;\n";
  }
  return text +
         "  esac\n"
         "  ((${#found})) && _describe -o word found\n"
         "  [[ $PREFIX == -* ]] || [ -z \"$verb\" ] || _files\n"
         "}\n"
         "if [ \"$funcstack[1]\" = _gltf-psplit ]; then _gltf_psplit; else compdef _gltf_psplit gltf-psplit; "
         "fi\n";
}

// Whether the words before the cursor name the command and none of its subcommands.
std::string fish_condition(const Command& command) {
  if (command.path.empty()) return "__fish_use_subcommand";
  std::string text;
  for (const std::string& verb : CLI::detail::split(command.path, ' '))
    text += (text.empty() ? "" : "; and ") + ("__fish_seen_subcommand_from " + verb);
  const std::vector<std::string> parts = names_of(command.parts);
  return parts.empty() ? text : text + "; and not __fish_seen_subcommand_from " + joined(parts, " ");
}

std::string fish_script(const std::vector<Command>& commands) {
  std::string text = "# Completion of gltf-psplit for fish.\n";
  for (const Command& command : commands) {
    const std::string line = "complete -c gltf-psplit -n " + quoted(fish_condition(command), true);
    for (const Word& part : command.parts)
      text += line + (command.path.empty() ? " -f" : "") + " -a " + part.names.front() + " -d " +
              quoted(part.meaning, true) + "\n";
    if (!command.values.empty()) text += line + " -f -a " + quoted(joined(command.values, " "), true) + "\n";
    for (const Word& option : command.options) {
      text += line;
      for (const std::string& name : option.names)
        text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (option.takes_value)
        text += option.values.empty() ? " -r" : " -x -a " + quoted(joined(option.values, " "), true);
      text += " -d " + quoted(option.meaning, true) + "\n";
    }
  }
  return text;
}

}  // namespace

std::string completion_script(const CLI::App& app, Shell shell) {
  std::vector<Command> commands;
  collect(app, "", commands);
  return shell == Shell::kBash  ? bash_script(commands)
         : shell == Shell::kZsh ? zsh_script(commands)
                                : fish_script(commands);
}

}  // namespace psplit
