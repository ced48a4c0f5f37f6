// gltf-psplit compare: measures bytes and milliseconds of patches, stock Draco and meshoptimizer in one run.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "gltf_ext/convert/read_jobs.h"
#include "psplit/cuda.h"
#include "psplit/encode.h"
#include "psplit/gltf.h"
#include "tools/gltf_psplit/commands/commands.h"
#include "tools/gltf_psplit/compare/comparison.h"
#include "tools/gltf_psplit/compare/comparison_report.h"
#include "tools/gltf_psplit/files/output_checks.h"
#include "tools/gltf_psplit/files/read_input.h"
#include "tools/gltf_psplit/files/text_output.h"
#include "tools/gltf_psplit/options/backend_choice.h"
#include "tools/gltf_psplit/options/encode_options.h"
#include "tools/gltf_psplit/options/file_options.h"
#include "tools/gltf_psplit/options/help_text.h"
#include "tools/gltf_psplit/options/session.h"
#include "tools/gltf_psplit/page/html_report.h"
#include "tools/gltf_psplit/preview/preview.h"
#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/patch_summary.h"
#include "tools/gltf_psplit/report/progress.h"

namespace psplit {
namespace {

struct CompareArguments {
  std::string input, output = "-", format = "text";
  BackendChoice backend;
  std::vector<uint64_t> patch_counts;
  ComparisonOptions options;
  LoadingModel loading;
  bool wide = false, condense = false;
};

// Faces of a patch in a cut that has enough patches for a GPU.
constexpr uint64_t kGpuPatchFaces = 1200;

// A .drc file is accepted, as its original may not exist.
Status check_uncompressed(const Document& document) {
  for (const PrimitiveId id : all_primitives(document)) {
    const Place place = place_of(id);
    const PrimitiveRecord& primitive = document.records().primitive(id);
    if (!primitive.status.ok()) return primitive.status;
    if (primitive.storage() != PrimitiveStorage::kPlain && !document.from_draco)
      return unsupported("is compressed already: compare the original file, or decode this one first", place);
  }
  return {};
}

// The primitives that `encode` would encode.
Expected<std::vector<EncodeJob>> read_uncompressed(const Document& document,
                                                   const EncodeDocumentOptions& coding,
                                                   const Session& session) {
  if (Status status = check_uncompressed(document); !status.ok()) return status;
  EncodeDocumentOptions comparable = coding;
  comparable.morph_targets = MorphTargets::kSparse;  // stock Draco has none
  Expected<PlannedJobs> read = read_and_plan(document, comparable, find_backend({}), session.pool);
  if (!read) return read.status();
  for (const auto& [id, reason] : read->skipped)
    session.log.note(describe_place(id.mesh, id.primitive) + " is left out: " + reason);
  if (read->jobs.empty()) return unsupported("has no triangles");
  return std::move(read->jobs);
}

// One patch for each primitive; as `encode` cuts by default and with --profile speed; and smaller patches. Of
// rules that do not make more patches than the one before, only that one is kept.
std::vector<PatchRule> default_rules(std::span<const EncodeJob> jobs, const EncodeDocumentOptions& coding) {
  std::vector<PatchRule> rules{{.patches = 1}};
  uint64_t most = jobs.size();
  for (const PatchRule& rule :
       {PatchRule{}, PatchRule{.patch_faces = kSpeedPatchFaces}, PatchRule{.patch_faces = kGpuPatchFaces}})
    if (const uint64_t count = count_patches(jobs, coding, rule); count > most) {
      rules.push_back(rule);
      most = count;
    }
  return rules;
}

// Of the measured rules, the one for the picture: one that makes as many patches as `encode` does by default,
// if that splits any primitive; otherwise the middle one.
PatchRule pictured_rule(std::span<const EncodeJob> jobs, const ComparisonOptions& options) {
  const uint64_t usual = count_patches(jobs, options.coding, {});
  std::vector<std::pair<uint64_t, PatchRule>> counts;
  for (const PatchRule& rule : options.rules)
    counts.emplace_back(count_patches(jobs, options.coding, rule), rule);
  std::ranges::stable_sort(counts, {}, [](const auto& entry) { return entry.first; });
  const auto found = std::ranges::find(counts, usual, [](const auto& entry) { return entry.first; });
  return usual > jobs.size() && found != counts.end() ? found->second : counts[counts.size() / 2].second;
}

// Draws the asset in patches, cut as for the measurements.
Expected<PatchPicture> draw_patches(Document& document, EncodeDocumentOptions coding, const Session& session) {
  coding.patches.always = true;
  coding.verify = false;
  const auto reports = encode_document(document, coding, find_backend({}), session.pool);
  if (!reports) return reports.status();
  const Expected<Image> image = draw_preview(document, ImageSize(), find_backend({}), session.pool);
  if (!image) return image.status();
  Expected<std::vector<uint8_t>> png = encode_png(*image);
  if (!png) return png.status();
  PatchSummary summary;
  for (const PrimitiveReport& report : *reports)
    if (report.skipped.empty())
      summary += summarize_streams(report.streams, report.has_residue, report.head_bytes, report.bytes);
  return PatchPicture{std::move(*png), summary.patches};
}

// Each rule once more, with condensed streams.
void add_condensed_rules(std::vector<PatchRule>& rules) {
  std::vector<PatchRule> all;
  for (PatchRule rule : rules) {
    all.push_back(rule);
    rule.condense = true;
    all.push_back(rule);
  }
  rules = std::move(all);
}

// Reads the input, fills in what of the report and of the options depends on it, and returns the jobs to
// measure.
Expected<std::vector<EncodeJob>> read_compared(const CompareArguments& arguments, const Session& session,
                                               ComparisonOptions& options, ComparisonReport& report) {
  const ProgressBar bar("reading", session.log);
  Expected<Document> document = read_input(arguments.input, session);
  if (!document) return document.status();
  if (Status status = check_not_an_input(arguments.output, "--output", *document); !status.ok()) return status;
  Expected<std::vector<EncodeJob>> jobs = read_uncompressed(*document, options.coding, session);
  if (!jobs) return jobs;
  if (!document->from_draco) {
    std::vector<PrimitiveId> ids;
    for (const EncodeJob& job : *jobs) ids.insert(ids.end(), job.group.ids.begin(), job.group.ids.end());
    report.asset = measure_parts(*document, ids);
  }
  for (const uint64_t patches : arguments.patch_counts) options.rules.push_back({.patches = patches});
  if (options.rules.empty()) options.rules = default_rules(*jobs, options.coding);
  if (arguments.format == "html") {
    const EncodeDocumentOptions coding = apply_rule(options.coding, pictured_rule(*jobs, options));
    if (Expected<PatchPicture> picture = draw_patches(*document, coding, session))
      report.picture = std::move(*picture);
    else
      session.log.warning("the page has no picture: " + picture.status().to_string());
  }
  if (arguments.condense) add_condensed_rules(options.rules);
  return jobs;
}

Status run_compare(CompareArguments arguments, const Session& session) {
  ComparisonReport report;
  ComparisonOptions& options = arguments.options;
  const Expected<std::vector<EncodeJob>> jobs = read_compared(arguments, session, options, report);
  if (!jobs) return jobs.status().at({.file = arguments.input});
  options.thread_counts = {1};
  if (session.pool.thread_count() > 1) options.thread_counts.push_back(session.pool.thread_count());

  // `auto` measures every available decoder.
  std::vector<DecodeBackend> backends;
  for (const std::string name : {"cuda", "cpu", "draco"}) {
    const bool is_there = name != "cuda" || cuda_available(nullptr);
    if (arguments.backend.name == name || (arguments.backend.name == "auto" && is_there))
      backends.push_back(find_backend({name, arguments.backend.gpu_memory}));
  }
  Expected<Comparison> comparison = [&] {
    ProgressBar bar("comparing", session.log);
    return compare_codecs(*jobs, options, backends, session.pool, bar.callback());
  }();
  if (!comparison) return comparison.status().at({.file = arguments.input});
  report.input = arguments.input == "-" ? "stdin" : std::filesystem::path(arguments.input).filename().string();
  report.options = options;
  report.loading = arguments.loading;
  report.comparison = std::move(*comparison);
  report.environment = describe_environment(session.version, session.command_line);
  return write_text(arguments.output,
                    arguments.format == "html"   ? to_html(report)
                    : arguments.format == "json" ? report_text(to_json(report))
                                                 : to_text(report, arguments.wide),
                    session.if_read_only());
}

void add_measuring_options(CLI::App& command, std::vector<uint64_t>& patch_counts, ComparisonOptions& options,
                           LoadingModel& loading) {
  separated_by_commas(
      command.add_option("--patches", patch_counts,
                         "Patch counts to measure, over all primitives together. Default: one patch for each "
                         "primitive, the count of `encode`, and the counts for patches of 4800 and of 1200 "
                         "faces"),
      "A,B,C")
      ->check(CLI::Range(uint64_t{1}, uint64_t{0xffffffff}));
  command
      .add_option(
          "--repeat", options.rounds.count,
          "Number of timed rounds. In each round, every decoder runs once. Default: as many as it takes "
          "until the medians are certain to 3 %")
      ->check(CLI::Range(1, 10000))
      ->type_name("N");
  command
      .add_option("--seconds", options.rounds.seconds,
                  "Without --repeat: no further rounds after this time, but at least 5")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str()
      ->type_name("S");
  command
      .add_option("--line", loading.line_mbit,
                  "The line over which the meshes come, in Mbit/s: the recommendation adds the time of their "
                  "bytes to that of decoding")
      ->check(CLI::Range(0.001, 1e6))
      ->capture_default_str()
      ->type_name("MBIT");
  separated_by_commas(
      command.add_option("--stock-speeds", options.stock_speeds,
                         "Draco speeds to measure stock Draco with. --encode-speed is always measured too; all "
                         "ratios refer to it"),
      "A,B,C")
      ->check(CLI::Range(0, 10))
      ->capture_default_str();
}

}  // namespace

void add_compare_command(CLI::App& command, Action& action) {
  auto arguments = std::make_shared<CompareArguments>();
  command
      .add_option(
          "IN", arguments->input,
          "The input: an uncompressed .gltf or .glb file, or a .drc, .ply, .obj, .stl or .off file, optionally "
          "gzipped; - reads stdin")
      ->required();
  add_measuring_options(command, arguments->patch_counts, arguments->options, arguments->loading);
  command.add_flag("--condense", arguments->condense, "Also measure each patch count with condensed patches");
  add_format_option(command, arguments->format, {"text", "json", "html"});
  command.get_option("--format")->description("Format of the result. html: a page with charts");
  add_text_output_option(command, arguments->output);
  add_wide_option(command, arguments->wide);
  add_backend_options(command, arguments->backend);
  add_coding_options(command, arguments->options.coding, false);
  add_partition_options(command, arguments->options.coding);
  group_encode_options(command);
  command.get_option("--condense")->group("Patches");
  add_examples(
      command,
      {{"gltf-psplit compare dragon.ply", "measure bytes and times of patches, stock Draco and meshoptimizer"},
       {"gltf-psplit compare dragon.ply --patches 1,45,182 --wide",
        "measure these patch counts; show all columns"},
       {"gltf-psplit compare dragon.ply --format html -o dragon.html", "write a page with charts"}});
  command.callback([arguments, &action] {
    action = [arguments](const Session& session) -> Status {
      if (Status status = check_output_place(arguments->output, session.force); !status.ok()) return status;
      if (!has_draco())
        return unsupported(
            "compare measures libdraco, and this psplit was built without it (PSPLIT_WITH_DRACO=OFF)");
      return run_compare(*arguments, session);
    };
  });
}

}  // namespace psplit
