// gltf-psplit batch, batch plan and batch merge: the options; batch/batch.h does the work.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <map>
#include <memory>

#include "system/child_process.h"
#include "tools/gltf_psplit/batch/batch.h"
#include "tools/gltf_psplit/commands/commands.h"
#include "tools/gltf_psplit/files/asset_output.h"
#include "tools/gltf_psplit/options/count_option.h"
#include "tools/gltf_psplit/options/encode_options.h"
#include "tools/gltf_psplit/options/file_options.h"
#include "tools/gltf_psplit/options/help_text.h"
#include "tools/gltf_psplit/options/session.h"

namespace psplit {
namespace {

const std::map<std::string, BatchVerb> kVerbs{{"encode", BatchVerb::kEncode},
                                              {"decode", BatchVerb::kDecode},
                                              {"validate", BatchVerb::kValidate},
                                              {"diff", BatchVerb::kDiff}};

struct BatchCommandArguments {
  BatchArguments batch;
  std::string form = "glb", verb = "encode", shard, progress = "bar", plan;
  bool with_hashes = false;
  std::function<void()> resolve;            // completes the encode options
  std::vector<const CLI::Option*> planned;  // options that a plan keeps
};

void add_inputs(CLI::App& command, BatchArguments& batch) {
  command.add_option("IN", batch.request.words,
                     "The inputs: files in a format that encode reads; folders, for all such files below them; "
                     "quoted patterns (*, ?, [], and ** for any number of folders); @FILE, a list with one of "
                     "these on each line and comments after #");
}

void add_output_folder(CLI::App& command, const std::string& names, BatchArguments& batch) {
  add_word_option(command, names, batch.folder, "DIR",
                  "Folder for the outputs, which keep the relative paths of the inputs");
}

void add_base(CLI::App& command, BatchArguments& batch) {
  add_word_option(command, "--base", batch.request.base, "DIR",
                  "Folder to which the paths of the inputs are relative. Default: the deepest folder that "
                  "holds all inputs");
}

// The options that all shards must agree on.
void add_planned_options(CLI::App& command, BatchCommandArguments& arguments) {
  const std::vector<CLI::Option*> before = command.get_options();
  add_choice_option(
      command, "--command", arguments.verb, {"encode", "decode", "validate", "diff"},
      "What to do with each asset: encode, decode to plain glTF, validate, or compare the input with "
      "its output in --out-dir, as `diff IN OUT` does");
  add_form_option(command, arguments.form);
  arguments.resolve = add_encode_options(command, arguments.batch.encode);
  add_images_option(command, arguments.batch.write);
  for (const CLI::Option* option : command.get_options())
    if (std::find(before.begin(), before.end(), option) == before.end()) arguments.planned.push_back(option);
}

// The words of the command line that set options of the plan.
std::vector<std::string> planned_words(const BatchCommandArguments& arguments) {
  std::vector<std::string> words;
  for (const CLI::Option* option : arguments.planned) {
    const std::string name = "--" + option->get_lnames().front();
    if (option->count() > 0 && option->get_type_size() == 0) words.push_back(name);
    if (option->get_type_size() == 0) continue;
    for (const std::string& value : option->results()) words.push_back(name + "=" + value);
  }
  return words;
}

// Takes the options out of a plan's head. `batch plan` wrote it, or the user did.
Status apply_plan(BatchCommandArguments& arguments, const Session& session) {
  const Expected<Manifest> manifest = Manifest::open(arguments.batch.manifest);
  if (!manifest) return manifest.status();
  if (!manifest->head()) return {};
  const Place place{.file = arguments.batch.manifest};
  if (manifest->head()->version != session.version)
    return wrong_usage("was planned by gltf-psplit " + manifest->head()->version + ", and this is " +
                           session.version + ": outputs may differ, so plan again",
                       place);
  if (const std::vector<std::string> words = planned_words(arguments); !words.empty())
    return wrong_usage(words.front().substr(0, words.front().find('=')) +
                           " must be given to `batch plan`, because all shards share it",
                       place);
  CLI::App app;
  BatchCommandArguments planned;
  add_planned_options(app, planned);
  try {
    std::vector<std::string> words = manifest->head()->options;
    std::reverse(words.begin(), words.end());  // as CLI11 takes them
    app.parse(words);
  } catch (const CLI::ParseError& error) {
    return wrong_usage(std::string("has invalid options: ") + error.what(), place);
  }
  planned.resolve();
  arguments.verb = planned.verb;
  arguments.batch.encode.options = planned.batch.encode.options;
  arguments.batch.encode.origin = planned.batch.encode.origin;
  arguments.batch.write = planned.batch.write;
  return {};
}

void add_job_options(CLI::App& command, BatchCommandArguments& arguments) {
  BatchArguments& batch = arguments.batch;
  const std::string group = "Jobs";
  add_word_option(command, "--manifest", batch.manifest, "FILE",
                  "Take the assets from FILE, a manifest of `batch plan`")
      ->group(group);
  add_word_option(
      command, "--shard", arguments.shard, "I/N",
      "Work on one of N shards: I/N, with I from 0 to N - 1. auto: take I and N from the Slurm or AWS Batch "
      "array that runs this task; auto/N: take only I, also from an Indexed Job of Kubernetes")
      ->group(group);
  command.add_flag("--dry-run", batch.dry_run, "Only list what would be done")->group(group);
  command
      .add_flag("--force", batch.force, "Also redo outputs that are up to date, and replace read-only outputs")
      ->group(group);
  command
      .add_flag("--prune", batch.prune,
                "Only list the outputs that batch made from inputs that no longer exist; with --force, remove "
                "them. Outputs that changed since are kept")
      ->group(group);
  command
      .add_flag("--summary", batch.summarize,
                "Print one summary line on stderr at the end, even with -q: for the logs of array jobs")
      ->group(group);
  command
      .add_option("--max-failures", batch.max_failures,
                  "Succeed even if up to N assets fail for a cause that will not pass")
      ->capture_default_str()
      ->type_name("N")
      ->group(group);
  command.add_option("--timeout", batch.timeout_s, "Abandon an asset after SECONDS")
      ->check(CLI::Range(0.001, 604800.0))
      ->type_name("SECONDS")
      ->group(group);
  add_size_option(command, "--memory", batch.memory,
                  "Start assets only while all running ones are expected to fit into SIZE, such as 8GB; a "
                  "larger one runs alone. Default: nine tenths of the memory of the container or the machine")
      ->group(group);
  add_choice_option(command, "--progress", arguments.progress, {"bar", "json"},
                    "bar: a progress bar if stderr is a terminal. json: a line of JSON on stdout for each "
                    "asset, as soon as it ends")
      ->group(group);
}

void add_staging_options(CLI::App& command, StagingCommands& staging) {
  const std::string group = "Object storage", first = place_of_argument(1), second = place_of_argument(2);
  add_word_option(command, "--fetch", staging.fetch, "CMD",
                  "Shell command that brings input " + first + " to file " + second +
                      ", and also the files below its folder that it "
                      "refers to: buffers, materials, textures. It is not tried again if it exits with 66 (no "
                      "such input) or 77 (no permission). Needs --manifest")
      ->group(group);
  add_word_option(
      command, "--store", staging.store, "CMD",
      "Shell command that takes file " + first + " away as output " + second + ". The same exit codes")
      ->group(group);
  add_word_option(command, "--fetch-output", staging.fetch_output, "CMD",
                  "Shell command that brings output " + first + " back to file " + second +
                      ". Each output is then checked after --store, "
                      "and in the next run")
      ->group(group);
  add_word_option(command, "--stage", staging.folder, "DIR",
                  "Local folder for the files of these commands. Default: a folder below --out-dir")
      ->group(group);
}

void add_batch_report_option(CLI::App& command, BatchArguments& batch) {
  add_word_option(
      command, "--report", batch.report, "FILE",
      "Write a report of all assets as JSON; - is stdout. Default: stdout, unless it is a terminal, a "
      "shard is chosen, or progress is JSON");
}

// What the options say together.
Status check_batch(const BatchCommandArguments& arguments) {
  const BatchArguments& batch = arguments.batch;
  if (batch.folder.empty()) return wrong_usage("--out-dir is required");
  if (batch.manifest.empty() == batch.request.words.empty())
    return wrong_usage(batch.manifest.empty() ? "there is no input: name files, or --manifest FILE"
                                              : "--manifest excludes other inputs");
  if (batch.manifest.empty() && !batch.staging.fetch.empty()) return wrong_usage("--fetch needs --manifest");
  if (batch.progress_as_json && batch.report == "-")
    return wrong_usage("--progress json and --report - cannot both write to stdout");
  if (!batch.staging.fetch_output.empty() && batch.staging.store.empty() && batch.verb != BatchVerb::kDiff)
    return wrong_usage("--fetch-output needs --store");
  if (batch.prune && (!batch.manifest.empty() || batch.shard || batch.staging.any() || !batch.report.empty()))
    return wrong_usage(
        "--prune takes files and patterns, and no --manifest, --shard, --report, --fetch or --store");
  const bool writes_images = batch.write.images && *batch.write.images != ImagePlacement::kEmbed;
  if (!batch.staging.store.empty() && writes_images) return wrong_usage("--store needs --images embed");
  return {};
}

Status run(BatchCommandArguments& arguments, const Session& session) {
  BatchArguments& batch = arguments.batch;
  if (batch.manifest == "-") return wrong_usage("--manifest must be a file, because all shards read it");
  if (!batch.manifest.empty())
    if (Status status = apply_plan(arguments, session); !status.ok()) return status;
  batch.verb = kVerbs.at(arguments.verb);
  batch.progress_as_json = arguments.progress == "json";
  if (!arguments.shard.empty()) {
    const Expected<Shard> shard =
        parse_shard(arguments.shard, [](const char* name) { return std::getenv(name); });
    if (!shard) return shard.status();
    batch.shard = *shard;
  }
  if (Status status = check_batch(arguments); !status.ok()) return status;
  return batch.prune ? prune_outputs(batch, session) : run_batch(batch, session);
}

void complete(BatchCommandArguments& arguments) {
  BatchArguments& batch = arguments.batch;
  batch.request.folder = batch.folder;
  batch.request.extension = "." + arguments.form;
  if (arguments.resolve) arguments.resolve();
}

void add_plan_command(CLI::App& batch, Action& action) {
  auto arguments = std::make_shared<BatchCommandArguments>();
  CLI::App& command = *batch.add_subcommand(
      "plan", "Write a manifest: a line of JSON for each asset, and the options that all shards share");
  add_inputs(command, arguments->batch);
  command.get_option("IN")->required();
  add_output_folder(command, "--out-dir", arguments->batch);
  command.get_option("--out-dir")->required();
  add_word_option(command, "-o,--output", arguments->plan, "FILE", "The manifest; - is stdout")->required();
  add_base(command, arguments->batch);
  command.add_flag("--hash", arguments->with_hashes,
                   "Add a hash of each input, which --fetch then checks. This reads all inputs");
  add_planned_options(command, *arguments);
  group_encode_options(command);
  add_examples(command, {{"gltf-psplit batch plan 'assets/**/*.glb' --out-dir out -o plan.jsonl",
                          "plan once, before the shards run"}});
  command.callback([arguments, &action] {
    complete(*arguments);
    action = [arguments](const Session& session) {
      arguments->batch.verb = kVerbs.at(arguments->verb);
      return plan_into_file(arguments->batch, planned_words(*arguments), arguments->with_hashes,
                            arguments->plan, session);
    };
  });
}

void add_merge_command(CLI::App& batch, Action& action) {
  auto arguments = std::make_shared<BatchCommandArguments>();
  CLI::App& command = *batch.add_subcommand(
      "merge", "Join the records and the reports of all shards; while they run, show their progress");
  command.add_option("DIR", arguments->batch.folder, "The --out-dir of the shards")->required();
  add_word_option(
      command, "--report", arguments->batch.report, "FILE",
      "Write a report of all assets as JSON; - is stdout. Default: stdout, unless it is a terminal");
  command
      .add_option("--max-failures", arguments->batch.max_failures,
                  "Succeed even if up to N assets failed for a cause that will not pass")
      ->capture_default_str()
      ->type_name("N");
  add_examples(command, {{"gltf-psplit batch merge out --report report.json", "after all shards have ended"}});
  command.callback([arguments, &action] {
    complete(*arguments);
    action = [arguments](const Session& session) { return merge_batch(arguments->batch, session); };
  });
}

}  // namespace

void add_batch_command(CLI::App& command, Action& action) {
  auto arguments = std::make_shared<BatchCommandArguments>();
  add_inputs(command, arguments->batch);
  add_output_folder(command, "-o,--out-dir", arguments->batch);
  add_base(command, arguments->batch);
  add_planned_options(command, *arguments);
  add_batch_report_option(command, arguments->batch);
  add_job_options(command, *arguments);
  add_staging_options(command, arguments->batch.staging);
  group_encode_options(command);
  add_plan_command(command, action);
  add_merge_command(command, action);
  add_examples(command,
               {{"gltf-psplit batch 'assets/**/*.glb' -o out",
                 "encode all files below assets, into the same folders below out"},
                {"gltf-psplit batch a.glb b.ply -o out --report report.json", "write a report of every asset"},
                {"gltf-psplit batch @list.txt -o out --as gltf", "take files and patterns from a list"},
                {"gltf-psplit batch --manifest plan.jsonl -o out --shard auto",
                 "in a task of an array: work on its part of what `batch plan` planned"}});
  command.callback([arguments, &command, &action] {
    if (!command.get_subcommands().empty()) return;
    complete(*arguments);
    action = [arguments](const Session& session) { return run(*arguments, session); };
  });
}

}  // namespace psplit
