// gltf-psplit encode: converts plain glTF or a mesh file to PSPLIT_mesh_draco_patches.
#include <CLI/CLI.hpp>
#include <memory>

#include "gltf_ext/convert/encode_document.h"
#include "gltf_ext/files/operating_system.h"
#include "src/stopwatch.h"
#include "tools/gltf_psplit/commands/commands.h"
#include "tools/gltf_psplit/files/asset_output.h"
#include "tools/gltf_psplit/files/read_input.h"
#include "tools/gltf_psplit/files/text_output.h"
#include "tools/gltf_psplit/options/backend_choice.h"
#include "tools/gltf_psplit/options/encode_options.h"
#include "tools/gltf_psplit/options/help_text.h"
#include "tools/gltf_psplit/options/session.h"
#include "tools/gltf_psplit/report/asset_bytes.h"
#include "tools/gltf_psplit/report/encode_report.h"
#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/progress.h"

namespace psplit {
namespace {

struct Arguments {
  std::string input, output, report;
  EncodeArguments encode;
  WriteOptions write;
};

Json report_json(const Arguments& arguments, const EncodeResult& result, const AssetSizes& sizes,
                 double wall_ms, const Session& session) {
  Json total;
  append_row(total, result.total);
  total["wall_ms"] = wall_ms;
  return {{"input", arguments.input},
          {"output", arguments.output},
          {"verified", arguments.encode.options.verify},
          {"threads", session.pool.thread_count()},
          {"files", sizes_json(sizes)},
          {"geometry", {{"input_bytes", result.geometry.input}, {"output_bytes", result.geometry.output}}},
          {"total", std::move(total)},
          {"primitives", result.primitives}};
}

Status run_encode(const Arguments& arguments, const Session& session) {
  // Large arrays are allocated and freed all the time. If freed memory went back to the system, the next array
  // would fault in page by page, each cleared first. For meshes of millions of faces, this costs a tenth of the
  // time.
  keep_freed_memory();
  const EncodeDocumentOptions& options = arguments.encode.options;

  const Stopwatch watch;
  WriteReport written;
  Expected<Document> document =
      read_for_output(arguments.input, arguments.output, arguments.report, session.log, written);
  if (!document) return document.status();
  AssetSizes sizes{bytes_on_disk(document->source.string()), {}};
  const Expected<std::vector<PrimitiveReport>> reports = [&] {
    ProgressBar bar("encoding", session.log);
    return encode_document(*document, options, find_backend({}), session.pool, bar.callback("face"));
  }();
  if (!reports) return reports.status().at({.file = arguments.input});

  const EncodeResult result = collect_rows(*reports, session.log);
  log_reports(*reports, session.log);
  if (result.split_count + result.draco_count == 0)
    session.log.warning("nothing to encode in " + arguments.input);
  warn_of_growth(result, session.log, arguments.input);
  if (Status status = write_asset(*document, arguments.output, arguments.write, session.log, written);
      !status.ok())
    return status;
  sizes.output = bytes_on_disk(arguments.output);
  const double wall_ms = watch.ms();

  if (!arguments.report.empty()) {
    Json report = report_json(arguments, result, sizes, wall_ms, session);
    if (Status status = write_asset_report(std::move(report), arguments.report, written); !status.ok())
      return status;
  }
  if (result.split_count > 1) session.log.detail("in all: " + row_text(result.total));
  session.log.note(written_text(
      arguments.output, sizes,
      encode_summary(result) + "; " + as_duration(wall_ms) + (options.verify ? "" : ", not verified")));
  return {};
}

}  // namespace

void add_encode_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App& command = *app.add_subcommand("encode", "Split the meshes of an asset into Draco patches");
  add_input_option(command, arguments->input);
  add_output_option(command, arguments->output);
  const auto resolve = add_encode_options(command, arguments->encode);
  add_images_option(command, arguments->write);
  command.add_option("--report", arguments->report, "Write a report as JSON; - is stdout")->type_name("FILE");
  group_encode_options(command);
  add_examples(
      command,
      {{"gltf-psplit encode dragon.ply dragon.glb", "split large primitives; keep small ones whole"},
       {"gltf-psplit encode dragon.ply dragon.glb --profile speed", "cut more and smaller patches, for a GPU"},
       {"gltf-psplit encode scan.obj -o scan.glb --lossless", "keep every float exactly"},
       {"gltf-psplit encode a.glb b.glb --compat khr", "for viewers that do not support the extension"},
       {"gltf-psplit encode a.glb b.glb --report - | jq .files", "show the bytes of input and output"}});
  command.callback([arguments, resolve, &action] {
    resolve();
    action = [arguments](const Session& session) { return run_encode(*arguments, session); };
  });
}

}  // namespace psplit
