// gltf-psplit encode: plain glTF, or a mesh file, to PSPLIT_mesh_draco_patches.
#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>
#include <thread>

#include "decoder_cuda/psplit_cuda.h"
#include "tools/gltf_psplit/commands.h"
#include "tools/gltf_psplit/gpus.h"
#include "tools/gltf_psplit/patch_summary.h"
#include "tools/gltf_psplit/progress.h"

namespace psplit {
namespace {

struct Arguments {
  std::string input, output, report;
  std::string profile, gpu, distance, volume = "primitive", fallback = "none";
  EncodeDocumentOptions options;
  bool no_verify = false;
};

constexpr uint64_t kSpeedPatchFaces = 1200;
constexpr uint64_t kBalancedPatchFaces = 4800;
// Patches of 440 faces take more than a third more bytes than one stream already (docs/benchmarks.md).
constexpr uint64_t kLeastPatchFaces = 440;

// Counts the machine's threads, not -j: -j never changes the bytes.
void apply_profile(const Arguments& arguments, EncodeDocumentOptions& options) {
  if (arguments.profile == "balanced") options.patch_faces = kBalancedPatchFaces;
  if (arguments.profile == "size") options.patches = std::max(1u, std::thread::hardware_concurrency());
  if (arguments.profile != "speed") return;
  const uint32_t gpu = arguments.gpu.empty() ? cuda_multiprocessors() : *multiprocessors(arguments.gpu);
  if (gpu == 0) {
    options.patch_faces = kSpeedPatchFaces;
    return;
  }
  options.patches = patches_in_flight(gpu);
  options.least_patch_faces = kLeastPatchFaces;
}

// One primitive's row of the report, or the sum of all rows.
struct Row {
  uint64_t input_faces = 0, input_points = 0;
  PatchSummary summary;
  EncodeStatistics statistics;

  Row& operator+=(const Row& other) {
    input_faces += other.input_faces;
    input_points += other.input_points;
    summary += other.summary;
    statistics.merged_points += other.statistics.merged_points;
    statistics.dropped_faces += other.statistics.dropped_faces;
    statistics.dropped_points += other.statistics.dropped_points;
    statistics.residue_faces += other.statistics.residue_faces;
    statistics.partition_ms += other.statistics.partition_ms;
    statistics.encode_ms += other.statistics.encode_ms;
    statistics.verify_ms += other.statistics.verify_ms;
    return *this;
  }
};

void append_row(Json& object, const Row& row) {
  object["input"] = {{"faces", row.input_faces}, {"points", row.input_points}};
  append_summary(object, row.summary);
  object["merged_points"] = row.statistics.merged_points;
  object["dropped_faces"] = row.statistics.dropped_faces;
  object["dropped_points"] = row.statistics.dropped_points;
  object["residue_faces"] = row.statistics.residue_faces;
  object["partition_ms"] = row.statistics.partition_ms;
  object["encode_ms"] = row.statistics.encode_ms;
  object["verify_ms"] = row.statistics.verify_ms;
}

std::string row_text(const Row& row) {
  const PatchSummary& summary = row.summary;
  const uint64_t map_bytes = summary.directory_bytes + summary.stitch_bytes;
  const double map_share =
      summary.total_bytes == 0 ? 0 : static_cast<double>(map_bytes) / static_cast<double>(summary.total_bytes);
  return counted(summary.patches, "patch") + ", " + counted(summary.faces, "face") + ", " +
         counted(summary.points, "point") + ", " + counted(summary.total_bytes, "byte") + " (" +
         with_decimals(summary.bits_per_point(), 2) + " bits a point; overhead: replication " +
         as_share(summary.replication()) + ", directory and stitch map " + as_share(map_share) +
         "); partition " + as_duration(row.statistics.partition_ms) + ", all of encoding " +
         as_duration(row.statistics.encode_ms) + ", verification " + as_duration(row.statistics.verify_ms);
}

Expected<Row> make_row(const Document& document, const PrimitiveReport& report) {
  const Expected<StoredPrimitive> patched = stored_primitive(document, report.id, kExtensionName);
  if (!patched) return patched.status();
  Expected<PatchSummary> summary = summarize_container(patched->bytes);
  if (!summary) return summary.status();
  return Row{report.faces, report.points, *summary, report.statistics};
}

struct Result {
  Row total;
  Json primitives = Json::array();
  size_t split_count = 0;
};

Expected<Result> collect_rows(const Document& document, std::span<const PrimitiveReport> reports,
                              const Log& log) {
  Result result;
  for (const PrimitiveReport& report : reports) {
    const std::string place = describe_place(report.id.mesh, report.id.primitive);
    Json object{{"mesh", report.id.mesh}, {"primitive", report.id.primitive}};
    if (report.skipped.empty()) {
      const Expected<Row> row = make_row(document, report);
      if (!row) return row.status();
      append_row(object, *row);
      result.total += *row;
      ++result.split_count;
      log.detail(place + ": " + row_text(*row));
    } else {
      object["skipped"] = report.skipped;
      log.note(place + " is left as it is: " + report.skipped);
    }
    result.primitives.push_back(std::move(object));
  }
  return result;
}

void log_changes(const EncodeStatistics& statistics, const Log& log) {
  if (statistics.merged_points > 0) log.note("merged " + counted(statistics.merged_points, "duplicate point"));
  if (statistics.dropped_faces + statistics.dropped_points > 0)
    log.note("dropped " + counted(statistics.dropped_faces, "degenerate face") + " and " +
             counted(statistics.dropped_points, "unused point"));
}

Status run_encode(Arguments arguments, const Session& session) {
  if (Status status = check_output_path(arguments.output); !status.ok()) return status;
  if (arguments.report == arguments.output)
    return {StatusCode::kUsage, "--report and the output cannot share " + arguments.output};
  EncodeDocumentOptions& options = arguments.options;
  options.verify = !arguments.no_verify;
  options.volume = arguments.volume == "mesh"    ? QuantizationVolume::kMesh
                   : arguments.volume == "scene" ? QuantizationVolume::kScene
                                                 : QuantizationVolume::kPrimitive;
  if (!arguments.distance.empty()) options.method = PartitionMethod::kPaper;
  if (arguments.distance == "geodesic") options.distance = PathDistance::kGeodesic;
  options.fallback = arguments.fallback == "uncompressed" ? Fallback::kUncompressed : Fallback::kNone;

  const auto begin = std::chrono::steady_clock::now();
  Expected<Document> document = read_input(arguments.input);
  if (!document) return document.status();
  const Expected<std::vector<PrimitiveReport>> reports = [&] {
    ProgressBar bar("encoding", session.log);
    return encode_document(*document, options, find_backend({}), session.pool, bar.callback());
  }();
  if (!reports) return reports.status().at({.file = arguments.input});

  const Expected<Result> result = collect_rows(*document, *reports, session.log);
  if (!result) return result.status().at({.file = arguments.output});
  if (result->split_count == 0) session.log.warning("nothing to split in " + arguments.input);
  log_changes(result->total.statistics, session.log);
  if (Status status = write_document(*document, arguments.output); !status.ok())
    return std::move(status).at({.file = arguments.output});
  const double wall_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();

  if (!arguments.report.empty()) {
    Json total;
    append_row(total, result->total);
    total["wall_ms"] = wall_ms;
    const Json report{{"input", arguments.input},   {"output", arguments.output},
                      {"verified", options.verify}, {"threads", session.pool.thread_count()},
                      {"total", std::move(total)},  {"primitives", result->primitives}};
    if (Status status = write_text(arguments.report, report.dump(2) + "\n"); !status.ok()) return status;
  }
  session.log.note(arguments.output + ": " + row_text(result->total) + "; " + as_duration(wall_ms) + " in all" +
                   (options.verify ? "" : ", not verified"));
  return {};
}

}  // namespace

void add_encode_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<Arguments>();
  EncodeDocumentOptions& options = arguments->options;
  CLI::App& command = *app.add_subcommand("encode", "Split the meshes of an asset into Draco patches");
  command
      .add_option("IN", arguments->input,
                  "A .gltf, .glb, .ply, .obj, .stl or .drc file; - is a GLB or Draco on stdin")
      ->required();
  command.add_option("OUT", arguments->output, "A .glb or .gltf file; - is a GLB on stdout")->required();

  CLI::Option* patches = command.add_option("--patches", options.patches, "Patches of all primitives together")
                             ->check(CLI::Range(uint64_t{1}, uint64_t{0xffffffff}))
                             ->type_name("N");
  CLI::Option* patch_faces =
      command.add_option("--patch-faces", options.patch_faces, "Faces of a patch, about")
          ->check(CLI::Range(uint64_t{1}, uint64_t{0xffffffff}))
          ->capture_default_str()
          ->type_name("N")
          ->excludes(patches);
  CLI::Option* profile =
      command
          .add_option("--profile", arguments->profile,
                      "speed: as many patches as a GPU decodes at once, or without one 1200 faces a patch; "
                      "balanced: 4800; size: as few patches as this machine has threads. --patches and "
                      "--patch-faces win over it")
          ->check(CLI::IsMember({"speed", "balanced", "size"}))
          ->type_name("NAME");
  command
      .add_option(
          "--gpu", arguments->gpu,
          "The GPU of --profile speed, by name or by its number of multiprocessors; by default the one of "
          "this machine")
      ->check([](const std::string& gpu) {
        return multiprocessors(gpu) ? std::string()
                                    : gpu + " is not known: " + known_gpus() + " are, or a number";
      })
      ->needs(profile)
      ->type_name("GPU");
  command
      .add_option("--distance", arguments->distance,
                  "Cut by the paper's own method, around farthest points, with this distance between faces: "
                  "dijkstra, along edges, or geodesic, across faces. By default in levels, which is faster")
      ->check(CLI::IsMember({"dijkstra", "geodesic"}))
      ->type_name("NAME");
  add_coding_options(command, options);
  command
      .add_option("--quantization-volume", arguments->volume,
                  "What shares one quantization grid: primitive, mesh or scene")
      ->check(CLI::IsMember({"primitive", "mesh", "scene"}))
      ->capture_default_str()
      ->type_name("WHAT");
  CLI::Option* lossless = command.add_flag("--lossless", options.lossless, "Keep every float exactly as it is");
  for (const char* name : {"--quantize-position", "--quantize-normal", "--quantize-texcoord",
                           "--quantize-color", "--quantize-generic", "--quantization-volume"})
    lossless->excludes(command.get_option(name));
  command.add_flag("--drop-degenerate", options.drop_degenerate,
                   "Drop faces that repeat an index, and points that no face uses");
  command.add_flag("--keep-duplicates", options.keep_duplicates,
                   "Keep points that are equal in everything apart");
  command
      .add_option("--fallback", arguments->fallback,
                  "For loaders without the extension: none, or uncompressed geometry beside the patches")
      ->check(CLI::IsMember({"none", "uncompressed"}))
      ->capture_default_str()
      ->type_name("KIND");
  command.add_flag("--no-verify", arguments->no_verify,
                   "Do not decode the result and compare it with the input");
  command.add_option("--report", arguments->report, "Write what was done as JSON; - is stdout")
      ->type_name("FILE");

  command.callback([arguments, patches, patch_faces, &action] {
    if (patches->empty() && patch_faces->empty()) apply_profile(*arguments, arguments->options);
    action = [arguments](const Session& session) { return run_encode(*arguments, session); };
  });
}

}  // namespace psplit
