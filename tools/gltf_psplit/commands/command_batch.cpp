// gltf-psplit batch: the options; batch/batch.h does the work.
#include <CLI/CLI.hpp>
#include <memory>

#include "tools/gltf_psplit/batch/batch.h"
#include "tools/gltf_psplit/commands/commands.h"
#include "tools/gltf_psplit/files/asset_output.h"
#include "tools/gltf_psplit/options/encode_options.h"
#include "tools/gltf_psplit/options/help_text.h"
#include "tools/gltf_psplit/options/session.h"

namespace psplit {
namespace {

struct Arguments {
  BatchArguments batch;
  std::string form = "glb";
};

}  // namespace

void add_batch_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App& command =
      *app.add_subcommand("batch", "Split many assets; a second run repeats only those that changed");
  command
      .add_option("IN", arguments->batch.request.words,
                  "The inputs: files that encode reads; patterns in quotes (*, ?, [], and ** for any number "
                  "of folders); @FILE, a list of both with one on each line")
      ->required();
  command
      .add_option("-o,--out-dir", arguments->batch.folder,
                  "Folder for the outputs, which keep the relative paths of the inputs")
      ->required()
      ->type_name("DIR");
  command
      .add_option("--base", arguments->batch.request.base,
                  "Folder that the paths of the inputs are relative to. Default: the deepest folder that holds "
                  "all inputs")
      ->type_name("DIR");
  command.add_option("--as", arguments->form, "Format of the outputs")
      ->check(CLI::IsMember({"glb", "gltf"}))
      ->capture_default_str()
      ->type_name("FORM");
  const auto resolve = add_encode_options(command, arguments->batch.encode);
  add_images_option(command, arguments->batch.write);
  command
      .add_option("--report", arguments->batch.report,
                  "Write a report of all assets as JSON; - is stdout. Default: stdout, unless it is a terminal")
      ->type_name("FILE");
  group_encode_options(command);
  add_examples(command,
               {{"gltf-psplit batch 'assets/**/*.glb' -o out",
                 "encode all files below assets, into the same folders below out"},
                {"gltf-psplit batch a.glb b.ply -o out --report report.json", "write a report of every asset"},
                {"gltf-psplit batch @list.txt -o out --as gltf", "take files and patterns from a list"}});
  command.callback([arguments, resolve, &action] {
    resolve();
    arguments->batch.request.folder = arguments->batch.folder;
    arguments->batch.request.extension = "." + arguments->form;
    action = [arguments](const Session& session) { return run_batch(arguments->batch, session); };
  });
}

}  // namespace psplit
