#include "tools/gltf_psplit/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <new>
#include <span>
#include <string_view>

#include "gltf_ext/file_lock.h"
#include "tools/gltf_psplit/commands.h"

namespace psplit {
namespace {

struct CommonOptions {
  bool quiet = false;
  bool verbose = false;
  int thread_count = 0;
};

void add_common_options(CLI::App& command, CommonOptions& options) {
  command.set_help_flag("-h,--help", "Print this help and exit");
  CLI::Option* quiet = command.add_flag("-q,--quiet", options.quiet, "Print nothing on stderr but errors");
  command.add_flag("-v,--verbose", options.verbose, "Print more on stderr")->excludes(quiet);
  command.add_option("-j,--threads", options.thread_count, "Threads to use; 0 is as many as the machine has")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str()
      ->type_name("N");
}

// Words as a shell takes them: in quotes where it would read more in them than letters.
std::string shell_words(std::span<char* const> words) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./,=:+@%";
  std::string text;
  for (const char* const word : words) {
    std::string quoted(word);
    if (quoted.empty() || quoted.find_first_not_of(kPlain) != std::string::npos) {
      for (size_t at = 0; (at = quoted.find('\'', at)) != std::string::npos; at += 4)
        quoted.replace(at, 1, "'\\''");
      quoted = "'" + quoted + "'";
    }
    text += " " + quoted;
  }
  return text;
}

int run(int argc, char** argv, const char* version) {
  CLI::App app("Splits glTF meshes into Draco patches that decode in parallel, and joins them again.",
               "gltf-psplit");
  app.set_help_flag("-h,--help", "Print this help and exit");
  app.set_version_flag("--version", std::string("gltf-psplit ") + version);
  app.footer(exit_codes_help());
  app.require_subcommand(1);

  Action action;
  add_encode_command(app, action);
  add_batch_command(app, action);
  add_decode_command(app, action);
  add_inspect_command(app, action);
  add_validate_command(app, action);
  add_compare_command(app, action);
  add_generate_command(app, action);
  CommonOptions common;
  for (CLI::App* command : app.get_subcommands({})) add_common_options(*command, common);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // Help and version are "errors" of exit code 0; all others are usage errors, whatever CLI11 numbers them.
    if (error.get_exit_code() == 0) return app.exit(error, std::cout, std::cerr);
    const bool unknown = app.get_subcommands().empty() && !app.remaining().empty();
    const std::string message = unknown ? "no such subcommand: " + app.remaining().front() : error.what();
    const Log log(Verbosity::kNormal);
    log.error({StatusCode::kUsage, message});
    log.note("run with --help for more information");
    return static_cast<int>(StatusCode::kUsage);
  }

  const Verbosity verbosity = common.quiet     ? Verbosity::kQuiet
                              : common.verbose ? Verbosity::kVerbose
                                               : Verbosity::kNormal;
  const Session session(verbosity, common.thread_count, version,
                        "gltf-psplit" + shell_words({argv + 1, static_cast<size_t>(std::max(argc, 1) - 1)}));
  const Status status = action(session);
  if (!status.ok()) session.log.error(status);
  return static_cast<int>(status.code());
}

}  // namespace

int run_command_line(int argc, char** argv, const char* version) {
  let_writes_past_size_limit_fail();
  const Log log(Verbosity::kNormal);
  try {
    return run(argc, argv, version);
  } catch (const std::bad_alloc&) {
    log.error(runtime_failure("out of memory"));
  } catch (const std::exception& error) {
    log.error(runtime_failure(error.what()));
  }
  return static_cast<int>(StatusCode::kRuntimeFailure);
}

}  // namespace psplit
