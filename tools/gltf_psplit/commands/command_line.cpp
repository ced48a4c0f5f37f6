#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <span>
#include <string_view>

#include "src/catch_exceptions.h"
#include "system/child_process.h"
#include "system/operating_system.h"
#include "tools/gltf_psplit/commands/commands.h"
#include "tools/gltf_psplit/files/output_checks.h"
#include "tools/gltf_psplit/files/text_output.h"
#include "tools/gltf_psplit/options/file_options.h"
#include "tools/gltf_psplit/options/help_text.h"
#include "tools/gltf_psplit/options/machine_limits.h"
#include "tools/gltf_psplit/options/session.h"
#include "tools/gltf_psplit/report/exit_codes.h"
#include "tools/gltf_psplit/report/log.h"
#include "tools/gltf_psplit/report/text_layout.h"

namespace psplit {
namespace {

struct CommonOptions {
  bool quiet = false;
  bool verbose = false;
  int thread_count = 0;
  bool force = false;
};

// These options are added to the app and to each subcommand, so that they may precede or follow the subcommand.
// CLI11's `excludes` would miss a -q before it and a -v after it; `run` checks that.
void add_common_options(CLI::App& command, CommonOptions& options) {
  constexpr const char* kGroup = "Common options";
  command.set_help_flag("-h,--help", "Print this help and exit")->group(kGroup);
  command.add_flag("-q,--quiet", options.quiet, "Print only errors on stderr")->group(kGroup);
  command.add_flag("-v,--verbose", options.verbose, "Print details on stderr")->group(kGroup);
  command
      .add_option("-j,--threads", options.thread_count,
                  "Number of threads; 0: the number of processors, or the CPU quota of a container")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str()
      ->type_name("N")
      ->group(kGroup);
}

// Of every command that has an output.
void add_force_option(CLI::App& command, bool& force) {
  const CLI::Option* output = command.get_option_no_throw("--output");
  if (output == nullptr) return;
  // Reports and pictures never replace an input.
  const bool makes_asset = output->get_positional() && command.get_option_no_throw("IN") != nullptr;
  command.add_flag(
      "-f,--force", force,
      makes_asset ? "Replace the output even if it is a file of the input, or read-only. Any other file of "
                    "that name is replaced without this option"
                  : "Replace the output even if it is read-only");
}

// "/home/someone/dragon.ply" becomes "dragon.ply", and "--output=../page.html" becomes "--output=page.html":
// others read the report, and the user's folders are private.
std::string without_folder(const std::string& word) {
  const size_t equals = word.starts_with("--") ? word.find('=') : std::string::npos;
  const bool is_short_option = word.size() > 2 && word[0] == '-' && word[1] != '-';  // "-o../page.html"
  const size_t begin = equals != std::string::npos ? equals + 1 : is_short_option ? 2 : 0;
  // "/", and on Windows also "\\".
  const char separators[] = {'/', static_cast<char>(std::filesystem::path::preferred_separator), '\0'};
  const size_t last = word.find_last_not_of(separators);
  if (last == std::string::npos || last < begin) return word;
  const size_t slash = word.find_last_of(separators, last);
  if (slash == std::string::npos || slash < begin) return word;
  return word.substr(0, begin) + word.substr(slash + 1);
}

// The words of a command line, quoted where a shell would interpret a character.
std::string shell_words(std::span<char* const> words) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./,=:+@%";
  std::string text;
  for (const char* const word : words) {
    std::string quoted = without_folder(word);
    if (quoted.empty() || quoted.find_first_not_of(kPlain) != std::string::npos) {
      for (size_t at = 0; (at = quoted.find('\'', at)) != std::string::npos; at += 4)
        quoted.replace(at, 1, "'\\''");
      quoted = "'" + quoted + "'";
    }
    text += " " + quoted;
  }
  return text;
}

std::vector<std::string> verbs_of(const CLI::App& app) {
  std::vector<std::string> verbs;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    verbs.push_back(command->get_name());
  return verbs;
}

std::vector<std::string> options_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

// The subcommand of the command line, or its own subcommand; the app itself if there is none.
const CLI::App& parsed_command(const CLI::App& app) {
  const std::vector<CLI::App*> parsed = app.get_subcommands();
  return parsed.empty() ? app : parsed_command(*parsed.front());
}

std::string no_such_verb(const CLI::App& app, const std::string& word) {
  return "unknown subcommand: " + word + suggestion(word, verbs_of(app));
}

// The error of a command line. An unknown option is reported first, because missing or superfluous words often
// follow from it.
std::string usage_message(const CLI::App& app, const CLI::ParseError& error) {
  const bool unknown_words = error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError) ||
                             error.get_exit_code() == static_cast<int>(CLI::ExitCodes::RequiredError);
  if (!unknown_words) return error.what();
  const std::vector<CLI::App*> parsed = app.get_subcommands();
  const CLI::App& command = parsed_command(app);
  const std::vector<std::string> words = app.remaining(/*recurse=*/true);
  if (command.get_name() == "compare" && !words.empty() && !words.front().starts_with('-'))
    return "compare measures one file; `gltf-psplit diff A B` tells whether two files hold the same meshes";
  for (const std::string& word : words) {
    if (!word.starts_with('-') || word == "-" || word == "--") continue;
    const std::string name = word.substr(0, word.find('='));
    return "unknown option: " + name + suggestion(name, options_of(command));
  }
  if (parsed.empty() && !app.remaining().empty()) return no_such_verb(app, app.remaining().front());
  if (parsed.empty()) return "the subcommand is missing; it is one of " + joined(verbs_of(app));
  return error.what();
}

void add_help_command(CLI::App& command, Action& action) {
  CLI::App& app = *command.get_parent();
  auto verb = std::make_shared<std::string>();
  command.add_option("SUBCOMMAND", *verb, "A subcommand; without it, the list of subcommands is printed");
  add_examples(command, {{"gltf-psplit help encode", "show all options of encode"}});
  command.callback([verb, &app, &action] {
    action = [verb, &app](const Session&) -> Status {
      const std::vector<std::string> verbs = verbs_of(app);
      // App::help() would print the help of the parsed subcommand, which is `help`.
      if (verb->empty())
        return write_text("-",
                          app.get_formatter()->make_help(&app, app.get_name(), CLI::AppFormatMode::Normal));
      if (std::ranges::find(verbs, *verb) == verbs.end()) return wrong_usage(no_such_verb(app, *verb));
      return write_text("-", app.get_subcommand(*verb)->help(app.get_name()));
    };
  });
}

void add_completion_command(CLI::App& command, Action& action) {
  CLI::App& app = *command.get_parent();
  struct Arguments {
    std::string shell, output = "-";
  };
  auto arguments = std::make_shared<Arguments>();
  static const std::map<std::string, Shell> kShells{
      {"bash", Shell::kBash}, {"fish", Shell::kFish}, {"zsh", Shell::kZsh}};
  command.add_option("SHELL", arguments->shell, "bash, zsh or fish")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  add_word_option(command, "-o,--output", arguments->output, "FILE", "Write to FILE instead of stdout");
  add_examples(command,
               {{"gltf-psplit completion bash > gltf-psplit.bash",
                 "write the script; `. ./gltf-psplit.bash` loads it. An installation has it already"}});
  command.callback([arguments, &app, &action] {
    action = [arguments, &app](const Session& session) {
      if (Status status = check_output_place(arguments->output, session.force); !status.ok()) return status;
      return write_text(arguments->output, completion_script(app, kShells.at(arguments->shell)),
                        session.if_read_only());
    };
  });
}

void add_version_command(CLI::App& command, Action& action) {
  command.callback([&action] {
    action = [](const Session& session) { return write_text("-", "gltf-psplit " + session.version + "\n"); };
  });
}

struct Subcommand {
  const char* name;
  const char* description;
  void (*add_options)(CLI::App& command, Action& action);
};
constexpr Subcommand kSubcommands[] = {
    {"encode", "Split the meshes of an asset into Draco patches", add_encode_command},
    {"batch", "Split many assets; a second run repeats only those that changed", add_batch_command},
    {"decode", "Decode patches and stock Draco into plain or stock Draco glTF, or a mesh file",
     add_decode_command},
    {"expand", "Restore the Draco streams of condensed patches, bit for bit", add_expand_command},
    {"inspect", "List the patches and Draco streams of assets, with their sizes", add_inspect_command},
    {"validate", "Check assets against every rule of the extension", add_validate_command},
    {"compare", "Measure patches, stock Draco and meshoptimizer on the same meshes", add_compare_command},
    {"diff",
     "Test whether two assets hold the same meshes, up to order and quantization. If not, list the differences "
     "and exit with 7",
     add_diff_command},
    {"generate", "Make a sample mesh. The same options always make the same mesh", add_generate_command},
    {"completion", "Print a script that completes words in a shell", add_completion_command},
    {"help", "Print the help of a subcommand, or the list of subcommands", add_help_command},
    {"version", "Print the version", add_version_command},
};

// To make all options takes milliseconds, as long as to encode a small asset. So only verbs that are among the
// words have them; the script for a shell needs all.
void add_commands(CLI::App& app, std::span<char* const> words, CommonOptions& common, Action& action) {
  const auto has_word = [&](std::string_view word) { return std::ranges::find(words, word) != words.end(); };
  const bool needs_all = has_word("completion");
  for (const auto& [name, description, add_options] : kSubcommands) {
    CLI::App& command = *app.add_subcommand(name, description);
    if (!needs_all && !has_word(name)) continue;
    add_options(command, action);
    for (CLI::App* part : command.get_subcommands({})) {
      add_force_option(*part, common.force);
      add_common_options(*part, common);
    }
    add_force_option(command, common.force);
    add_common_options(command, common);
  }
}

int run(int argc, char** argv, const char* version) {
  CLI::App app("Splits glTF meshes into Draco patches that decode in parallel, and joins them again",
               "gltf-psplit");
  app.allow_windows_style_options(false);  // "/a.glb" is a file
  app.formatter(help_formatter());
  app.set_version_flag("-V,--version", std::string("gltf-psplit ") + version, "Print the version and exit")
      ->group("Common options");
  // CLI11 names these groups in capitals from version 2.5 on. Subcommands take both names from the app.
  app.group("Subcommands")->option_defaults()->group("Options");
  app.require_subcommand(1);
  CommonOptions common;
  add_common_options(app, common);
  Action action;
  add_commands(app, {argv, static_cast<size_t>(argc)}, common, action);
  add_examples(app, {{"gltf-psplit encode dragon.ply dragon.glb", "split a mesh into patches"},
                     {"gltf-psplit decode dragon.glb plain.glb", "join the patches again, as plain glTF"},
                     {"gltf-psplit help encode", "show the options of a subcommand"}});

  try {
    app.parse(argc, argv);
    if (common.quiet && common.verbose) throw CLI::ExcludesError("--quiet", "--verbose");
  } catch (const CLI::ParseError& error) {
    // Help and version are "errors" with exit code 0. All others are usage errors, whatever their number in
    // CLI11.
    if (error.get_exit_code() == 0) return app.exit(error, std::cout, std::cerr);
    const Log log(Verbosity::kNormal);
    log.error(wrong_usage(usage_message(app, error)));
    std::string words;
    for (const CLI::App* command = &parsed_command(app); command != &app; command = command->get_parent())
      words = " " + command->get_name() + words;
    log.note("`gltf-psplit" + words + " --help` lists what is possible");
    return exit_code(StatusCode::kUsage);
  }

  const Verbosity verbosity = common.quiet     ? Verbosity::kQuiet
                              : common.verbose ? Verbosity::kVerbose
                                               : Verbosity::kNormal;
  const int threads = common.thread_count > 0 ? common.thread_count : default_thread_count(cgroup_limits());
  Session session(verbosity, threads, version,
                  "gltf-psplit" + shell_words({argv + 1, static_cast<size_t>(std::max(argc, 1) - 1)}));
  session.force = common.force;
  const Status status = action(session);
  if (!status.ok()) session.log.error(status);
  return exit_code(status.code());
}

}  // namespace

int run_command_line(int argc, char** argv, const char* version) {
  set_child_words({argv, argv + argc});
  let_writes_past_size_limit_fail();
  const StopEndsProcess stop_ends_process;
  const Log log(Verbosity::kNormal);
  const Expected<int> code = catch_exceptions([&]() -> Expected<int> { return run(argc, argv, version); });
  if (code) return *code;
  log.error(code.status());
  return exit_code(code.status().code());
}

}  // namespace psplit
