// gltf-psplit encode: converts plain glTF or mesh files to PSPLIT_mesh_draco_patches. Into a folder, it is a
// batch.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <optional>

#include "gltf_ext/convert/encode_large_mesh.h"
#include "gltf_ext/convert/validate.h"
#include "gltf_ext/out_of_core/read_spool.h"
#include "mesh_files/read_asset.h"
#include "psplit/gltf.h"
#include "src/catch_exceptions.h"
#include "src/stopwatch.h"
#include "system/operating_system.h"
#include "tools/gltf_psplit/batch/batch.h"
#include "tools/gltf_psplit/batch/batch_plan.h"
#include "tools/gltf_psplit/batch/memory_estimate.h"
#include "tools/gltf_psplit/commands/commands.h"
#include "tools/gltf_psplit/files/asset_output.h"
#include "tools/gltf_psplit/files/mesh_output.h"
#include "tools/gltf_psplit/files/output_checks.h"
#include "tools/gltf_psplit/files/read_input.h"
#include "tools/gltf_psplit/files/text_output.h"
#include "tools/gltf_psplit/options/backend_choice.h"
#include "tools/gltf_psplit/options/count_option.h"
#include "tools/gltf_psplit/options/encode_options.h"
#include "tools/gltf_psplit/options/file_options.h"
#include "tools/gltf_psplit/options/help_text.h"
#include "tools/gltf_psplit/options/memory_options.h"
#include "tools/gltf_psplit/options/session.h"
#include "tools/gltf_psplit/report/asset_bytes.h"
#include "tools/gltf_psplit/report/encode_report.h"
#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/progress.h"

namespace psplit {
namespace {

struct EncodeCommandArguments {
  std::vector<std::string> inputs;  // as the user wrote them
  std::string input, output, report, form = "glb";
  bool dry_run = false, accept_loss = false;
  EncodeArguments encode;
  WriteOptions write;
  uint64_t memory = 0;  // 0: the whole asset is in memory
  std::string temporary;
};

Json report_json(const EncodeCommandArguments& arguments, const EncodeResult& result, const Document& encoded,
                 const Json& dropped_extensions, const AssetSizes& sizes, double wall_ms,
                 const Session& session) {
  Json total;
  append_row(total, result.total);
  total["wall_ms"] = wall_ms;
  return {{"input", arguments.input},
          {"output", arguments.output},
          {"dropped_attributes", result.dropped_attributes},
          {"unused_attributes", result.unused_attributes},
          {"verified", arguments.encode.options.verify},
          {"threads", session.pool.thread_count()},
          {"files", sizes_json(sizes)},
          {"geometry", {{"input_bytes", result.geometry.input}, {"output_bytes", result.geometry.output}}},
          {"total", std::move(total)},
          {"dropped_extensions", dropped_extensions},
          {"coarse", coarse_json(coarse_counts(encoded))},
          {"meshopt", meshopt_json(meshopt_counts(encoded))},
          {"primitives", result.primitives}};
}

// The least that the output can take: its images, if they are in it, and a part of the rest that no mesh stays
// below. A full disk then ends the work before it begins.
Status check_least_space(const EncodeCommandArguments& arguments, const AssetBytes& input) {
  constexpr uint64_t kMostRatio = 256;
  const ImagePlacement images = arguments.write.images.value_or(
      is_glb_output(arguments.output) ? ImagePlacement::kEmbed : ImagePlacement::kCopy);
  return check_free_space(arguments.output,
                          input.files / kMostRatio + (images == ImagePlacement::kEmbed ? input.textures : 0));
}

OutOfCoreOptions limits_of(const EncodeCommandArguments& arguments, const Session& session) {
  OutOfCoreOptions limits;
  limits.memory = arguments.memory;
  limits.temporary = temporary_folder(arguments.temporary, arguments.output);
  limits.to_glb = is_glb_output(arguments.output);
  limits.note = [&](const std::string& text) { session.log.note(arguments.input + ": " + text); };
  return limits;
}

bool makes_coarse(const EncodeCommandArguments& arguments) {
  return arguments.encode.options.fallback == Fallback::kCoarse;
}

Status too_large(uint64_t estimate) {
  return unsupported("may take " + as_bytes(estimate) +
                     " of memory, which is more than --memory allows. Of mesh files, only PLY, OBJ and STL are "
                     "encoded part by part");
}

// The input, and whether all of it fits into memory.
struct Input {
  Document document;
  bool fits = false;
};

// What cannot be read again is put into a temporary file. If it does not fit into memory, glTF stays there, and
// a PLY, an STL or an OBJ becomes a document in temporary files. Pipes do not tell their size: PLY and STL are
// read as a stream. An OBJ that fits may have several objects and materials.
Expected<Asset> read_stream(const EncodeCommandArguments& arguments, const Session& session,
                            std::optional<uint64_t> estimate, bool& fits) {
  ProgressBar bar("reading", session.log);
  Expected<std::unique_ptr<ByteStream>> stream = open_byte_stream(arguments.input, bar.callback("byte"));
  if (!stream) return stream.status();
  Expected<Scanner> scanner = open_scanner(std::move(*stream));
  if (!scanner) return scanner.status();
  const OutOfCoreOptions limits = limits_of(arguments, session);
  std::optional<AssetFormat> format = format_of(*scanner, arguments.input);
  const auto is_spooled = [&] { return format && can_be_spooled(*format); };
  SpooledBytes bytes;
  if (format == AssetFormat::kGltf || (!estimate && (!is_spooled() || format == AssetFormat::kObj))) {
    Expected<SpooledBytes> spooled = spool_bytes(*scanner, limits.temporary);
    if (!spooled) return spooled.status();
    bytes = std::move(*spooled);
    scanner = open_scanner(memory_stream(bytes.bytes.bytes()));
    if (!scanner) return scanner.status();
    format = format_of(*scanner, arguments.input);  // a binary STL is known by its size alone
    const std::string path = bytes.file.path().string();
    const bool is_gltf = format == AssetFormat::kGltf;
    if (!is_gltf && path.empty())
      return unsupported("this system cannot estimate the memory of a pipe of this format");
    estimate = is_gltf ? 0
                       : kProcessMemory + estimate_memory(path, BatchVerb::kEncode, arguments.input,
                                                          makes_coarse(arguments), bytes.bytes.bytes().size());
    if (*estimate <= arguments.memory) {
      fits = !is_gltf;
      return read_asset(bytes.bytes, arguments.input, find_describer("auto"), {}, session.pool,
                        arguments.encode.origin);
    }
  }
  if (!is_spooled()) return too_large(*estimate);
  const auto check = [&](const ExpectedSizes& sizes, bool is_certain) {
    return check_temporary_space(sizes, limits.temporary, limits.note, is_certain);
  };
  SpoolOptions spool = spool_options(arguments.encode.options, limits);
  spool.origin = arguments.encode.origin;
  return read_spool(*scanner, *format, arguments.input, std::move(spool), check, session.pool);
}

Expected<Input> read_input(const EncodeCommandArguments& arguments, const Session& session,
                           WriteReport& written) {
  std::optional<uint64_t> estimate;
  if (arguments.memory > 0 && arguments.input != "-" && is_disk_file(arguments.input))
    estimate =
        kProcessMemory + estimate_memory(arguments.input, BatchVerb::kEncode, "", makes_coarse(arguments));
  bool fits = arguments.memory == 0 || (estimate && *estimate <= arguments.memory);
  if (fits || (estimate && read_asset_json(arguments.input).ok())) {
    // If freed memory went back to the system, the next array would fault in page by page, each cleared first.
    // On virtual machines, small pages cost a third of the time of a large mesh.
    if (fits) expect_large_arrays();
    Expected<Document> document =
        read_for_output(arguments.input, arguments.output, arguments.report, session, written, "auto", {},
                        OutputForms::kGltf, PointClouds::kRefuse, arguments.encode.origin);
    if (!document) return document.status();
    return Input{std::move(*document), fits};
  }
  const auto check = [&](const Document* document) {
    return check_paths(arguments.input, document, arguments.output, arguments.report, session, written);
  };
  if (Status status = check(nullptr); !status.ok()) return status;
  Expected<Asset> asset = read_stream(arguments, session, estimate, fits);
  if (!asset) return asset.status().at({.file = arguments.input == "-" ? "stdin" : arguments.input});
  log_warnings(*asset, arguments.input, arguments.encode.origin, session.log);
  if (Status status = check(&asset->document); !status.ok()) return status;
  return Input{std::move(asset->document), fits};
}

// A .drc file is one Draco stream: of the scene's mesh, or of its points if it has no triangles.
bool is_draco_output(const EncodeCommandArguments& arguments) {
  return mesh_format_of_output(arguments.output) == AssetFormat::kDraco;
}

Expected<Document> read_for_draco(const EncodeCommandArguments& arguments, const Session& session,
                                  WriteReport& written) {
  if (arguments.memory > 0)
    return wrong_usage("--memory cannot be kept with a .drc file: Draco needs whole meshes");
  if (!arguments.report.empty()) return wrong_usage("--report is for .glb and .gltf outputs");
  return read_for_output(arguments.input, arguments.output, "", session, written, "auto", {},
                         OutputForms::kGltfAndMeshFiles, PointClouds::kRead, arguments.encode.origin);
}

Status run_encode_draco(const EncodeCommandArguments& arguments, const Session& session) {
  const Stopwatch watch;
  WriteReport written;
  Expected<Document> document = read_for_draco(arguments, session, written);
  if (!document) return document.status();
  AssetSizes sizes{bytes_on_disk(*document), {}};
  drop_extensions(*document, arguments.encode.drop_extensions, arguments.input, session.log);
  if (Status status = decode_document(*document, find_backend({}), session.pool); !status.ok())
    return std::move(status).at({.file = arguments.input});
  EncodeStatistics lost;
  if (Status status = write_mesh_output(
          *document, arguments.output, AssetFormat::kDraco,
          {arguments.accept_loss, arguments.write.images, arguments.encode.options}, session, written, lost);
      !status.ok())
    return status;
  sizes.output = bytes_on_disk(arguments.output);
  const std::string changes = changes_text(lost);
  session.log.note(written_text(arguments.output, sizes,
                                "one Draco stream" + (changes.empty() ? "" : "; " + changes) + "; " +
                                    as_duration(watch.ms()) +
                                    (arguments.encode.options.verify ? "" : ", not verified")));
  return {};
}

Status run_encode(const EncodeCommandArguments& arguments, const Session& session) {
  if (is_draco_output(arguments)) return run_encode_draco(arguments, session);
  const EncodeDocumentOptions& options = arguments.encode.options;
  const Stopwatch watch;
  WriteReport written;
  Expected<Input> input = read_input(arguments, session, written);
  if (!input) return input.status();
  Document& document = input->document;
  AssetSizes sizes{bytes_on_disk(document), {}};
  if (Status status = check_least_space(arguments, sizes.input); !status.ok()) return status;
  const Json dropped_extensions =
      drop_extensions(document, arguments.encode.drop_extensions, arguments.input, session.log);
  OutOfCoreOptions limits = limits_of(arguments, session);
  if (input->fits) limits.memory = 0;
  std::optional<ProgressBar> bar(std::in_place, "encoding", session.log);
  const Expected<std::vector<PrimitiveReport>> reports =
      encode_document(document, options, find_backend({}), session.pool, bar->callback("face"), limits);
  bar.reset();  // clears its line
  if (!reports) return reports.status().at({.file = arguments.input});
  const EncodeResult result = collect_rows(*reports, options.skip, session.log);
  log_reports(*reports, session.log);
  const MeshoptCounts meshopt = meshopt_counts(document);
  if (result.split_count + result.draco_count == 0 && meshopt.views == 0)
    session.log.warning("nothing to encode in " + arguments.input);
  warn_of_result(result, session.log, arguments.input);
  if (Status status = write_asset(document, arguments.output, arguments.write, session, written); !status.ok())
    return status;
  sizes.output = bytes_on_disk(arguments.output);
  const double wall_ms = watch.ms();

  if (!arguments.report.empty()) {
    Json report = report_json(arguments, result, document, dropped_extensions, sizes, wall_ms, session);
    if (Status status = write_asset_report(std::move(report), arguments.report, session, written); !status.ok())
      return status;
  }
  if (result.split_count > 1) session.log.detail("in all: " + row_text(result.total));
  std::string summary = encode_summary(result, options);
  for (const std::string& more :
       {targets_text(count_targets(document)), coarse_text(coarse_counts(document)), meshopt_text(meshopt)})
    if (!more.empty()) summary += "; " + more;
  session.log.note(
      written_text(arguments.output, sizes,
                   summary + "; " + as_duration(wall_ms) + (options.verify ? "" : ", not verified")));
  if (const std::string unused = unused_text(result); !unused.empty()) session.log.note(unused);
  return {};
}

// Checks what can be checked before the work, and says what would be written.
Status run_dry(const EncodeCommandArguments& arguments, const Session& session) {
  WriteReport written;
  Status status;
  if (is_draco_output(arguments)) {
    status = read_for_draco(arguments, session, written).status();
  } else if (arguments.memory > 0 && !read_asset_json(arguments.input).ok()) {
    // Mesh files are read once, when they are encoded.
    status = check_paths(arguments.input, nullptr, arguments.output, arguments.report, session, written);
    if (status.ok()) status = open_byte_stream(arguments.input).status();
  } else {
    const Expected<Document> document =
        read_for_output(arguments.input, arguments.output, arguments.report, session, written, "auto", {},
                        OutputForms::kGltf, PointClouds::kRefuse, arguments.encode.origin);
    status = document ? check_document(*document, find_backend({}), session.pool,
                                       {arguments.memory, limits_of(arguments, session).temporary})
                      : document.status();
  }
  if (!status.ok()) return std::move(status).at({.file = arguments.input});
  session.log.note((arguments.output == "-" ? "stdout" : arguments.output) +
                   would_be_written(arguments.output));
  return {};
}

// Whether the outputs go to a folder, as in a batch.
bool writes_into_folder(const EncodeCommandArguments& arguments) {
  std::error_code error;
  const std::string& first = arguments.inputs.front();
  const bool may_be_many =
      !std::filesystem::exists(first, error) && (first.starts_with('@') || is_pattern(first));
  return arguments.inputs.size() > 1 || may_be_many || std::filesystem::is_directory(first, error) ||
         (std::filesystem::is_directory(arguments.output, error) && !is_asset_name(arguments.output)) ||
         (!arguments.output.empty() && !std::filesystem::path(arguments.output).has_filename());
}

Status run_into_folder(const EncodeCommandArguments& arguments, const Session& session) {
  std::error_code error;
  if (!std::filesystem::is_directory(arguments.output, error) &&
      (arguments.output == "-" || is_asset_name(arguments.output))) {
    if (arguments.inputs.size() > 1)
      return wrong_usage(
          "several inputs need a folder for the outputs: -o DIR. With -o, all other words are inputs");
    return io_failure("may be several assets: they need a folder for the outputs, -o DIR",
                      {.file = arguments.input});
  }
  if (arguments.memory > 0)
    return wrong_usage(
        "--memory takes one input and one output. batch --memory bounds the memory that assets take at once");
  BatchArguments batch;
  batch.request = {arguments.inputs, arguments.output, "", "." + arguments.form};
  batch.folder = arguments.output;
  batch.report = arguments.report;
  batch.reports_by_default = false;
  batch.dry_run = arguments.dry_run;
  batch.force = session.force;
  batch.encode = arguments.encode;
  batch.write = arguments.write;
  return run_batch(batch, session);
}

// Adds advice to out-of-memory errors.
Status with_advice(Status status, const EncodeCommandArguments& arguments) {
  if (status.code() != StatusCode::kOutOfMemory) return status;
  status = std::move(status).at({.file = arguments.input});
  std::string advice;
  if (arguments.memory == 0) advice += "; --memory SIZE encodes large meshes part by part";
  const EncodeDocumentOptions& options = arguments.encode.options;
  const int most_bits = std::max({options.position_bits, options.normal_bits, options.texcoord_bits,
                                  options.color_bits, options.generic_bits});
  constexpr int kFewBits = 24;
  if (most_bits > kFewBits) advice += "; fewer quantization bits or smaller patches need less memory";
  return out_of_memory(status.message() + advice, status.place());
}

void add_inputs(CLI::App& command, EncodeCommandArguments& arguments) {
  command
      .add_option("IN", arguments.inputs,
                  std::string(kInputText) +
                      ". With -o DIR also several files, folders, patterns and lists, as for batch")
      ->required();
  add_output_option(command, arguments.output);
  CLI::Option* output = command.get_option("--output");
  output->required(false)->description(
      output->get_description() +
      "; or a .drc file, one Draco stream of a mesh, or of the points of a file without faces; or a folder for "
      "all outputs, as for batch. Any file of this name is replaced: in a folder with two files, `encode "
      "*.glb` without -o replaces the second");
}

// All words are inputs. Without -o, the last of two is the output.
void settle_output(EncodeCommandArguments& arguments, bool is_named) {
  if (is_named && arguments.output.empty())
    throw CLI::ValidationError("--output", "names neither a file nor a folder");
  if (arguments.output.empty() && arguments.inputs.size() > 2)
    throw CLI::ValidationError("several inputs need a folder for the outputs: -o DIR");
  if (arguments.output.empty() && arguments.inputs.size() < 2) throw CLI::RequiredError("OUT");
  if (arguments.output.empty()) {
    arguments.output = std::move(arguments.inputs.back());
    arguments.inputs.pop_back();
  }
  arguments.input = arguments.inputs.front();
}

void add_memory_options(CLI::App& command, EncodeCommandArguments& arguments) {
  constexpr const char* kGroup = "Memory";
  CLI::Option* memory =
      add_size_option(command, "--memory", arguments.memory,
                      "Take at most SIZE of memory, such as 4GB, but at least " +
                          std::to_string(kLeastMemory >> 20) +
                          "MiB. A PLY or STL file, an OBJ of one material, or a plain primitive of glTF, that "
                          "needs more is read into temporary files and encoded part by part. All other inputs "
                          "must fit. Inputs such as pipes are first copied into temporary files")
          ->group(kGroup);
  add_temporary_option(command, arguments.temporary)->needs(memory);
}

}  // namespace

void add_encode_command(CLI::App& command, Action& action) {
  auto arguments = std::make_shared<EncodeCommandArguments>();
  add_inputs(command, *arguments);
  const auto resolve = add_encode_options(command, arguments->encode);
  add_images_option(command, arguments->write);
  add_memory_options(command, *arguments);
  add_report_option(command, arguments->report);
  command.add_flag("--accept-loss", arguments->accept_loss,
                   "Write a .drc file even if it cannot hold the whole asset. A warning names the lost parts; "
                   "without this option they are an error (exit code 5)");
  command.add_flag("--dry-run", arguments->dry_run,
                   "Only check the input, and list what would be written, replaced or left");
  add_form_option(command, arguments->form);
  group_encode_options(command);
  add_examples(
      command,
      {{"gltf-psplit encode dragon.ply dragon.glb", "split large primitives; keep small ones whole"},
       {"gltf-psplit encode dragon.ply dragon.glb --profile speed", "cut more and smaller patches, for a GPU"},
       {"gltf-psplit encode scan.obj -o scan.glb --lossless", "keep every float exactly"},
       {"gltf-psplit encode points.ply points.drc", "a Draco point cloud of a file without faces"},
       {"gltf-psplit encode scan.ply scan.gltf --memory 4GB", "a mesh that is larger than the memory"},
       {"gltf-psplit encode assets -o out", "all assets below a folder; a second run repeats what changed"},
       {"gltf-psplit encode a.glb b.glb --compat khr", "for viewers that do not support the extension"},
       {"gltf-psplit encode a.glb b.glb --report - | jq .files", "show the bytes of input and output"}});
  command.callback([arguments, resolve, &action, &command] {
    resolve();
    settle_output(*arguments, command.count("--output") > 0);
    if (command.count("--as") > 0 && !writes_into_folder(*arguments))
      throw CLI::ValidationError("--as",
                                 "is for outputs in a folder; the name of a single output states its format");
    if (command.count("--memory") > 0 && command.count("--meshopt") > 0)
      throw CLI::ValidationError("--meshopt", "is for assets in memory, and cannot be used with --memory");
    if (command.count("--memory") > 0 && arguments->memory < kLeastMemory)
      throw CLI::ValidationError("--memory", "must be at least " + std::to_string(kLeastMemory >> 20) + "MiB");
    action = [arguments](const Session& session) {
      if (writes_into_folder(*arguments)) return run_into_folder(*arguments, session);
      if (arguments->dry_run) return run_dry(*arguments, session);
      return with_advice(catch_exceptions([&] { return run_encode(*arguments, session); }), *arguments);
    };
  });
}

}  // namespace psplit
