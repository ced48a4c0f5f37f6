// gltf-psplit batch: many assets, each as `encode` would, on one pool of threads.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <new>
#include <thread>

#include "gltf_ext/convert/validate.h"
#include "gltf_ext/files/content_hash.h"
#include "tools/gltf_psplit/batch/batch.h"
#include "tools/gltf_psplit/commands/commands.h"
#include "tools/gltf_psplit/files/asset_output.h"
#include "tools/gltf_psplit/options/encode_options.h"
#include "tools/gltf_psplit/options/help_text.h"
#include "tools/gltf_psplit/options/session.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  BatchArguments batch;
  std::string form = "glb";
};

}  // namespace

void add_batch_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App& command = *app.add_subcommand("batch", "Split many assets, and again only those that changed");
  command
      .add_option(
          "IN", arguments->batch.request.words,
          "Files that encode reads, patterns in quotes (*, ?, [] and ** for any folders), and @FILE, a list of "
          "both, one a line")
      ->required();
  command
      .add_option("-o,--out-dir", arguments->batch.folder,
                  "Folder for the results, which keep their relative paths")
      ->required()
      ->type_name("DIR");
  command
      .add_option("--base", arguments->batch.request.base,
                  "What paths below DIR are relative to; by default the deepest folder that all inputs are in")
      ->type_name("DIR");
  command.add_option("--as", arguments->form, "Form of the results")
      ->check(CLI::IsMember({"glb", "gltf"}))
      ->capture_default_str()
      ->type_name("FORM");
  const auto resolve = add_encode_options(command, arguments->batch.encode);
  add_images_option(command, arguments->batch.write);
  command
      .add_option("--report", arguments->batch.report,
                  "Where the report of all assets goes, as JSON; - is stdout, and the default unless that is a "
                  "terminal")
      ->type_name("FILE");
  group_encode_options(command);
  add_examples(
      command,
      {{"gltf-psplit batch 'assets/**/*.glb' -o out", "all below assets, in the same folders below out"},
       {"gltf-psplit batch a.glb b.ply -o out --report report.json", "with a report of every asset"},
       {"gltf-psplit batch @list.txt -o out --as gltf", "files and patterns from a list"}});
  command.callback([arguments, resolve, &action] {
    resolve();
    arguments->batch.request.folder = arguments->batch.folder;
    arguments->batch.request.extension = "." + arguments->form;
    action = [arguments](const Session& session) { return run_batch(arguments->batch, session); };
  });
}

}  // namespace psplit
