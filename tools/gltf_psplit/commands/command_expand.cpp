// gltf-psplit expand: restores the Draco streams that `encode --condense` condensed.
#include <CLI/CLI.hpp>
#include <memory>

#include "gltf_ext/json/json.h"
#include "psplit/gltf.h"
#include "src/stopwatch.h"
#include "tools/gltf_psplit/commands/commands.h"
#include "tools/gltf_psplit/files/asset_output.h"
#include "tools/gltf_psplit/options/backend_choice.h"
#include "tools/gltf_psplit/options/file_options.h"
#include "tools/gltf_psplit/options/help_text.h"
#include "tools/gltf_psplit/options/session.h"
#include "tools/gltf_psplit/report/asset_bytes.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

struct ExpandArguments {
  std::string input, output, report;
  WriteOptions write;
};

std::string expand_summary(const ExpandReport& counts) {
  if (counts.to_patches + counts.to_draco == 0) return "nothing was expanded: no primitive is condensed";
  std::string text;
  if (counts.to_patches > 0) text = counted(counts.to_patches, "primitive") + " expanded to Draco patches";
  if (counts.to_draco > 0)
    text += (text.empty() ? "" : ", ") + counted(counts.to_draco, "primitive") + " to stock Draco";
  return text;
}

Json report_json(const ExpandArguments& arguments, const ExpandReport& counts, const AssetSizes& sizes,
                 double wall_ms, const Session& session) {
  return {{"input", arguments.input},
          {"output", arguments.output},
          {"files", sizes_json(sizes)},
          {"threads", session.pool.thread_count()},
          {"primitives", counts.primitives},
          {"expanded_to_patches", counts.to_patches},
          {"expanded_to_draco", counts.to_draco},
          {"streams", {{"input_bytes", counts.bytes_before}, {"output_bytes", counts.bytes_after}}},
          {"wall_ms", wall_ms}};
}

Status run_expand(const ExpandArguments& arguments, const Session& session) {
  const Stopwatch watch;
  WriteReport written;
  Expected<Document> document =
      read_for_output(arguments.input, arguments.output, arguments.report, session, written);
  if (!document) return document.status();
  AssetSizes sizes{bytes_on_disk(*document), {}};
  const Expected<ExpandReport> counts = expand_document(*document, find_backend({}), session.pool);
  if (!counts) return counts.status().at({.file = arguments.input});
  if (Status status = write_asset(*document, arguments.output, arguments.write, session, written); !status.ok())
    return status;
  sizes.output = bytes_on_disk(arguments.output);
  const double wall_ms = watch.ms();

  if (!arguments.report.empty()) {
    Json report = report_json(arguments, *counts, sizes, wall_ms, session);
    if (Status status = write_asset_report(std::move(report), arguments.report, session, written); !status.ok())
      return status;
  }
  session.log.note(
      written_text(arguments.output, sizes, expand_summary(*counts) + "; " + as_duration(wall_ms)));
  return {};
}

}  // namespace

void add_expand_command(CLI::App& command, Action& action) {
  auto arguments = std::make_shared<ExpandArguments>();
  add_input_option(command, arguments->input);
  add_output_option(command, arguments->output);
  add_images_option(command, arguments->write);
  add_report_option(command, arguments->report);
  add_examples(command, {{"gltf-psplit expand small.glb dragon.glb",
                          "Draco patches, for loaders that cannot read condensed ones: the file of encode "
                          "--no-condense, but without the effect of --always-patches"},
                         {"gltf-psplit expand small.glb draco.glb --report - | jq .streams",
                          "show the bytes before and after"}});
  command.callback([arguments, &action] {
    action = [arguments](const Session& session) { return run_expand(*arguments, session); };
  });
}

}  // namespace psplit
