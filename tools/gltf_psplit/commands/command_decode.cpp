// gltf-psplit decode: converts patches and stock Draco to plain glTF, to stock Draco, or to a mesh file.
#include <CLI/CLI.hpp>
#include <memory>

#include "gltf_ext/convert/stated_bytes.h"
#include "gltf_ext/convert/stated_grids.h"
#include "gltf_ext/json/glb.h"
#include "gltf_ext/json/json.h"
#include "psplit/gltf.h"
#include "src/stopwatch.h"
#include "tools/gltf_psplit/commands/commands.h"
#include "tools/gltf_psplit/files/asset_output.h"
#include "tools/gltf_psplit/files/mesh_output.h"
#include "tools/gltf_psplit/files/output_checks.h"
#include "tools/gltf_psplit/options/backend_choice.h"
#include "tools/gltf_psplit/options/encode_options.h"
#include "tools/gltf_psplit/options/file_options.h"
#include "tools/gltf_psplit/options/help_text.h"
#include "tools/gltf_psplit/options/memory_options.h"
#include "tools/gltf_psplit/options/session.h"
#include "tools/gltf_psplit/report/asset_bytes.h"
#include "tools/gltf_psplit/report/encode_report.h"
#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/progress.h"
#include "tools/gltf_psplit/report/verdict.h"

namespace psplit {
namespace {

struct DecodeArguments {
  std::string input, output, report, target = "gltf";
  BackendChoice backend;
  MemoryChoice memory;
  EncodeDocumentOptions options;
  OriginChoice origin;
  WriteOptions write;
  bool accept_loss = false;
};

// The number of primitives, by what was done with them.
struct Decoded {
  size_t primitives = 0;  // all of the asset
  size_t decoded = 0;     // primitives that were compressed
  size_t encoded = 0;     // primitives that were encoded as stock Draco
  EncodeStatistics lost;  // what stock Draco does not hold
  CoarseCounts coarse;    // what loaders without the extension would have shown; dropped
  double decode_ms = 0;   // until all of the asset was plain in memory
};

std::string decode_summary(const Decoded& counts) {
  const std::string coarse = coarse_text(counts.coarse);
  const std::string dropped = coarse.empty() ? "" : "; dropped " + coarse;
  if (counts.decoded + counts.encoded == 0) return "nothing was decoded: no primitive is compressed" + dropped;
  std::string text = counts.decoded == 0 ? "" : counted(counts.decoded, "primitive") + " decoded";
  if (counts.encoded > 0)
    text += (text.empty() ? "" : ", ") + counted(counts.encoded, "primitive") + " encoded as stock Draco";
  const std::string changes = changes_text(counts.lost);
  return text + (changes.empty() ? "" : "; ") + changes + dropped;
}

// Stock Draco is encoded from whole meshes.
MemoryLimit limit_of(const DecodeArguments& arguments) {
  return arguments.target == "draco" ? MemoryLimit() : memory_limit(arguments.memory, arguments.output);
}

Expected<Decoded> convert(Document& document, const DecodeArguments& arguments, const Session& session,
                          bool to_mesh_file, const Stopwatch& watch) {
  Decoded counts;
  counts.coarse = coarse_counts(document);
  for (const PrimitiveId id : all_primitives(document)) {
    ++counts.primitives;
    if (document.records().primitive(id).storage() != PrimitiveStorage::kPlain || document.cloud)
      ++counts.decoded;
  }
  const bool to_draco = !to_mesh_file && arguments.target == "draco";
  EncodeDocumentOptions options = arguments.options;
  if (to_draco) options.stated = all_stated_grids(document, session.pool);
  std::vector<Finding> corrections;
  {
    ProgressBar bar("decoding", session.log);
    Status status = decode_document(document, find_backend(arguments.backend), session.pool,
                                    bar.callback("patch"), limit_of(arguments), &corrections);
    if (!status.ok()) return status;
  }
  counts.decode_ms = watch.ms();
  warn_of_corrections(corrections, session.log, arguments.input);
  if (!to_draco) return counts;
  options.storage = Storage::kOneStream;
  options.keep_duplicates = true;  // as Draco keeps them
  const auto reports = encode_document(document, options, find_backend({}), session.pool);
  if (!reports) return reports.status();
  log_reports(*reports, session.log);
  for (const PrimitiveReport& report : *reports) {
    counts.encoded += report.skipped.empty() ? 1 : 0;
    if (report.repeated) continue;
    counts.lost.dropped_faces += report.statistics.dropped_faces;
    counts.lost.dropped_points += report.statistics.dropped_points;
  }
  return counts;
}

Status check_form(const DecodeArguments& arguments, std::optional<AssetFormat> mesh_format) {
  const bool to_draco = arguments.target == "draco";
  if (to_draco && mesh_format && mesh_format != AssetFormat::kDraco)
    return wrong_usage("--to draco writes a .glb, .gltf or .drc file");
  if ((to_draco || mesh_format == AssetFormat::kDraco) && arguments.memory.bytes != 0)
    return wrong_usage("--memory cannot be kept with --to draco: stock Draco needs whole meshes");
  return {};
}

// Sizes of all files of a mesh output.
AssetBytes bytes_of(const WriteReport& written) {
  AssetBytes bytes{0, written.image_bytes};
  for (const std::filesystem::path& file : written.files) bytes.files += bytes_on_disk(file.string()).files;
  return bytes;
}

Status run_decode(const DecodeArguments& arguments, const Session& session) {
  const std::optional<AssetFormat> mesh_format = mesh_format_of_output(arguments.output);
  if (Status status = check_form(arguments, mesh_format); !status.ok()) return status;
  const Stopwatch watch;
  WriteReport written;
  OriginChoice origin = arguments.origin;
  origin.bits = 0;  // plain floats are as exact as they can be
  if (arguments.target == "draco" || mesh_format == AssetFormat::kDraco) follow_bits(arguments.options, origin);
  Expected<Document> document =
      read_for_output(arguments.input, arguments.output, arguments.report, session, written,
                      arguments.backend.name, spool_folder(arguments.memory, arguments.output),
                      OutputForms::kGltfAndMeshFiles, PointClouds::kRead, origin);
  if (!document) return document.status();
  AssetSizes sizes{bytes_on_disk(*document), {}};
  if (arguments.target != "draco" && is_glb_output(arguments.output))
    if (Status status = check_glb_bytes(stated_bytes(*document).decoded, true); !status.ok())
      return std::move(status).at({.file = arguments.output});
  // A file system that compresses may take less than all bytes of floats, but hardly half of them.
  if (arguments.target != "draco" && !mesh_format)
    if (Status status = check_free_space(arguments.output, stated_bytes(*document).decoded / 2); !status.ok())
      return status;
  Expected<Decoded> counts = convert(*document, arguments, session, mesh_format.has_value(), watch);
  if (!counts) return counts.status().at({.file = arguments.input});
  const Status wrote =
      mesh_format ? write_mesh_output(*document, arguments.output, *mesh_format,
                                      {arguments.accept_loss, arguments.write.images, arguments.options},
                                      session, written, counts->lost)
                  : write_asset(*document, arguments.output, arguments.write, session, written);
  if (!wrote.ok()) return wrote;
  if (mesh_format) log_written(written, session.log);
  sizes.output = mesh_format ? bytes_of(written) : bytes_on_disk(arguments.output);
  const double wall_ms = watch.ms();

  if (!arguments.report.empty()) {
    Json report{{"input", arguments.input},         {"output", arguments.output},
                {"files", sizes_json(sizes)},       {"threads", session.pool.thread_count()},
                {"primitives", counts->primitives}, {"decoded", counts->decoded},
                {"encoded", counts->encoded},       {"dropped_coarse", coarse_json(counts->coarse)},
                {"decode_ms", counts->decode_ms},   {"wall_ms", wall_ms}};
    if (arguments.target == "draco" || mesh_format == AssetFormat::kDraco) {
      report["dropped_faces"] = counts->lost.dropped_faces;
      report["dropped_points"] = counts->lost.dropped_points;
    }
    if (Status status = write_asset_report(std::move(report), arguments.report, session, written); !status.ok())
      return status;
  }
  session.log.note(
      written_text(arguments.output, sizes, decode_summary(*counts) + "; " + as_duration(wall_ms)));
  return {};
}

}  // namespace

void add_decode_command(CLI::App& command, Action& action) {
  auto arguments = std::make_shared<DecodeArguments>();
  add_input_option(command, arguments->input);
  add_output_option(command, arguments->output, OutputForms::kGltfAndMeshFiles);
  add_choice_option(command, "--to", arguments->target, {"gltf", "draco"},
                    "gltf: plain accessors. draco: KHR_draco_mesh_compression, one stream for each primitive, "
                    "encoded with the options below. A .drc output is one such stream");
  add_images_option(command, arguments->write);
  command.add_flag("--accept-loss", arguments->accept_loss,
                   "Write an .obj, .ply, .stl or .drc file even if it cannot hold the whole asset. A warning "
                   "names the lost parts; without this option they are an error (exit code 5)");
  add_report_option(command, arguments->report);
  add_backend_options(command, arguments->backend);
  add_memory_options(command, arguments->memory,
                     "Larger meshes are decoded by the CPU into a temporary file of their size. Not with "
                     "--to draco, which needs whole meshes.");
  add_coding_options(command, arguments->options, true);
  add_origin_option(command, arguments->origin);
  group_encode_options(command);
  add_examples(
      command,
      {{"gltf-psplit decode dragon.glb plain.glb", "plain glTF, which every viewer opens"},
       {"gltf-psplit decode dragon.glb draco.glb --to draco", "stock Draco, one stream for each primitive"},
       {"gltf-psplit decode mesh.drc mesh.gltf", "a Draco file as glTF"},
       {"gltf-psplit decode points.drc points.glb", "a point cloud as a glTF of points"},
       {"gltf-psplit decode part.glb part.stl --accept-loss", "the triangles of the scene, for a slicer"},
       {"gltf-psplit decode huge.glb plain.glb --gpu-memory 2GB",
        "decode in parts if the GPU has little memory"},
       {"gltf-psplit decode scan.gltf plain.gltf --memory 4GB", "decode a mesh that is larger than memory"}});
  command.callback([arguments, &action] {
    action = [arguments](const Session& session) { return run_decode(*arguments, session); };
  });
}

}  // namespace psplit
