// gltf-psplit decode: patches, and stock Draco, back to plain glTF, or to stock Draco.
#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>

#include "tools/gltf_psplit/commands.h"
#include "tools/gltf_psplit/output_files.h"
#include "tools/gltf_psplit/progress.h"

namespace psplit {
namespace {

struct Arguments {
  std::string input, output, target = "gltf";
  BackendChoice backend;
  EncodeDocumentOptions options;
  WriteOptions write;
};

Status run_decode(const Arguments& arguments, const Session& session) {
  if (Status status = check_output_path(arguments.output); !status.ok()) return status;
  const auto begin = std::chrono::steady_clock::now();
  Expected<Document> document = read_input(arguments.input, session.log, arguments.backend.name);
  if (!document) return document.status();
  const size_t primitive_count = all_primitives(*document).size();
  {
    ProgressBar bar("decoding", session.log);
    Status status = decode_document(*document, find_backend(arguments.backend), session.pool, bar.callback());
    if (!status.ok()) return std::move(status).at({.file = arguments.input});
  }
  if (arguments.target == "draco") {
    const auto reports = encode_document_stock(*document, arguments.options, session.pool);
    if (!reports) return reports.status().at({.file = arguments.input});
    log_reports(*reports, session.log);
  }
  WriteReport written;
  if (Status status = write_document(*document, arguments.output, arguments.write, &written); !status.ok())
    return std::move(status).at({.file = arguments.output});
  log_written(written, session.log);
  const double wall_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  session.log.note(arguments.output + ": " + counted(primitive_count, "primitive") + "; " +
                   as_duration(wall_ms));
  return {};
}

}  // namespace

void add_decode_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App& command =
      *app.add_subcommand("decode", "Decode patches and stock Draco into plain or stock Draco glTF");
  command
      .add_option("IN", arguments->input,
                  "A .gltf, .glb, .drc, .ply, .obj, .stl or .off file, packed by gzip or not; - is stdin")
      ->required();
  command.add_option("OUT", arguments->output, "A .glb or .gltf file; - is a GLB on stdout")->required();
  command
      .add_option(
          "--to", arguments->target,
          "gltf: plain accessors; draco: KHR_draco_mesh_compression, one stream a primitive, coded with "
          "the options below")
      ->check(CLI::IsMember({"gltf", "draco"}))
      ->capture_default_str()
      ->type_name("FORM");
  add_images_option(command, arguments->write);
  add_backend_options(command, arguments->backend);
  add_coding_options(command, arguments->options);
  command.callback([arguments, &action] {
    action = [arguments](const Session& session) { return run_decode(*arguments, session); };
  });
}

}  // namespace psplit
