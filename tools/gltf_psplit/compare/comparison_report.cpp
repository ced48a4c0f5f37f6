#include "tools/gltf_psplit/compare/comparison_report.h"

#include <cmath>

#include "gltf_ext/json/json.h"
#include "tools/gltf_psplit/compare/comparison_figures.h"
#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/text_layout.h"

namespace psplit {
namespace {

void append_timing(Json& object, const Timing& timing, const std::string& prefix) {
  object[prefix.empty() ? "median_ms" : prefix + "_ms"] = timing.median_ms;
  const std::string before = prefix.empty() ? "" : prefix + "_";
  object[before + "min_ms"] = timing.min_ms;
  object[before + "max_ms"] = timing.max_ms;
  object[before + "lower_quartile_ms"] = timing.lower_quartile_ms;
  object[before + "upper_quartile_ms"] = timing.upper_quartile_ms;
}

Json stock_json(const StockRow& row) {
  Json object{{"speed", row.speed}, {"bytes", row.bytes}, {"encode_ms", row.encode_ms}};
  append_timing(object, row.decode, "decode");
  return object;
}

Json meshopt_json(const MeshoptRow& row, const Environment& environment) {
  Json object{{"version", environment.meshoptimizer},
              {"codec_version", environment.meshopt_codec},
              {"bytes", row.bytes}};
  append_timing(object, row.decode, "decode");
  return object;
}

Json environment_json(const Environment& environment) {
  return {{"cpu", environment.cpu},
          {"threads", environment.threads},
          {"gpu", environment.gpu.empty() ? Json() : Json(environment.gpu)},
          {"psplit", environment.psplit},
          {"draco", environment.draco},
          {"meshoptimizer", environment.meshoptimizer},
          {"meshoptimizer_codec", environment.meshopt_codec},
          {"zstd", environment.zstd},
          {"brotli", environment.brotli.empty() ? Json() : Json(environment.brotli)},
          {"compiler", environment.compiler},
          {"command_line", environment.command_line},
          {"date", environment.date}};
}

void append_summary(Json& object, const ComparisonSummary& summary) {
  object["headline"] = summary.has_recommendation ? Json(summary.headline) : Json();
  object["recommendation"] = Json();
  if (summary.has_recommendation)
    object["recommendation"] = {
        {"patches", summary.recommended_patches}, {"text", summary.recommendation}, {"rule", summary.rule}};
  object["noise"] = summary.noise;
}

Json asset_json(const ComparisonReport& report, const ComparisonSummary& summary) {
  if (!report.asset) return nullptr;
  const AssetParts& parts = *report.asset;
  return {{"bytes", parts.total()},
          {"mesh_bytes", parts.meshes},
          {"texture_bytes", parts.textures},
          {"other_bytes", parts.rest},
          {"missing_images", parts.missing_images},
          {"morph_targets", parts.morph_targets},
          {"bytes_with_stock", parts.with_meshes(report.comparison.stock.bytes)},
          {"bytes_with_patches",
           summary.has_recommendation ? Json(parts.with_meshes(summary.recommended_bytes)) : Json()}};
}

std::string asset_text(const ComparisonReport& report, const ComparisonSummary& summary) {
  if (!report.asset || !summary.has_recommendation) return "";
  const AssetParts& parts = *report.asset;
  return "The whole asset: " + with_separators(parts.total()) + " bytes as plain glTF, " +
         with_separators(parts.with_meshes(report.comparison.stock.bytes)) + " with stock Draco, " +
         with_separators(parts.with_meshes(summary.recommended_bytes)) + " in " +
         counted(summary.recommended_patches, "patch") + "; " + with_separators(parts.textures) +
         " of each are textures." +
         (parts.morph_targets == 0
              ? ""
              : " Morph targets are plain in each: " + counted(parts.morph_targets, "attribute") +
                    ", which `encode` stores in patches.");
}

std::string wrapped(const std::string& text) { return wrap_text(text, kTableWidth, 0) + "\n"; }

std::string summary_text(const ComparisonReport& report) {
  const ComparisonSummary summary = summarize(report);
  std::string text;
  if (summary.has_recommendation) text += wrapped(summary.headline) + wrapped(summary.recommendation);
  if (const std::string asset = asset_text(report, summary); !asset.empty()) text += wrapped(asset);
  for (const std::string& note : summary.noise) text += wrapped("note: " + note);
  return text;
}

std::string stages_text(const Comparison& comparison) {
  if (comparison.splits.empty()) return "";
  std::vector<std::string> header{"patches"};
  for (const StageRow& stage : comparison.splits.front().stages) header.push_back(stage.name + " ms");
  TextTable table(header);
  for (const SplitRow& row : comparison.splits) {
    std::vector<std::string> cells{with_separators(row.summary.patches) +
                                   (row.rule.condense ? " condensed" : "")};
    for (const StageRow& stage : row.stages) cells.push_back(with_decimals(stage.timing.median_ms, 1));
    table.add(std::move(cells));
  }
  return table.to_string();
}

// A table with a row for each decoder. The cells that describe a split are only in its first row.
std::string codecs_text(const ComparisonReport& report, bool wide) {
  const ComparisonFigures figures(report);
  const Comparison& comparison = report.comparison;
  TextTable table({"codec", "patches", "faces/patch", "bytes", "bits/point", "overhead", "replication",
                   "balance", "partition ms", "encode ms", "decoder", "threads", "decode ms", "min", "max",
                   "speed-up", "Mtri/s"});
  const auto add = [&](std::vector<std::string> cells, const std::string& decoder, int threads,
                       const Timing& timing) {
    for (const std::string& cell :
         {decoder, std::to_string(threads), (is_noisy(timing) ? "~" : "") + with_decimals(timing.median_ms, 1),
          with_decimals(timing.min_ms, 1), with_decimals(timing.max_ms, 1),
          with_decimals(figures.speedup(timing.median_ms), 2) + "x",
          with_decimals(figures.million_triangles_a_second(timing.median_ms), 1)})
      cells.push_back(cell);
    table.add(std::move(cells));
  };
  const auto per_point = [&](uint64_t bytes) { return with_decimals(figures.bits_per_point(bytes), 2); };
  for (const StockRow& row : comparison.stock_speeds)
    add({figures.stock_name(row), "1", with_separators(comparison.faces), with_separators(row.bytes),
         per_point(row.bytes), row.speed == comparison.stock.speed ? "" : figures.over_base(row.bytes), "", "",
         "", with_decimals(row.encode_ms, 0)},
        "draco", 1, row.decode);
  for (const auto& [with, row] : figures.meshopt_rows())
    add({"meshopt " + report.environment.meshoptimizer + (with.empty() ? "" : " + " + with), "", "",
         with_separators(row->bytes), per_point(row->bytes), figures.over_base(row->bytes), "", "", "", ""},
        "meshopt", 1, row->decode);
  for (const SplitRow& row : comparison.splits) {
    const PatchSummary& summary = row.summary;
    std::vector<std::string> cells{row.rule.condense ? "psplit, condensed" : "psplit",
                                   with_separators(summary.patches),
                                   with_separators(static_cast<uint64_t>(std::llround(row.mean_patch_faces()))),
                                   with_separators(summary.total_bytes),
                                   per_point(summary.total_bytes),
                                   as_percent(row.overhead),
                                   as_share(summary.replication()),
                                   with_decimals(summary.balance(), 3),
                                   with_decimals(row.partition_ms, 0),
                                   with_decimals(row.encode_ms, 0)};
    for (const DecodeRow& decode : row.decode) {
      add(cells, decode.backend, decode.threads, decode.timing);
      cells.assign(cells.size(), "");
    }
  }
  if (!wide)
    table.keep_columns(std::vector<std::string>{"codec", "patches", "bytes", "overhead", "decoder", "threads",
                                                "decode ms", "speed-up", "Mtri/s"});
  return table.to_string();
}

std::string settings_text(const ComparisonReport& report) {
  const EncodeDocumentOptions& coding = report.options.coding;
  const std::string speed = std::to_string(coding.encode_speed);
  const std::string precision =
      coding.lossless ? "lossless" : "positions " + counted(static_cast<uint64_t>(coding.position_bits), "bit");
  return "Draco speed " + speed + ", " + precision + (coding.refine ? "" : ", borders not refined") +
         "; decode: median of " +
         counted(static_cast<uint64_t>(report.comparison.rounds), "interleaved round") +
         "; stock Draco and meshopt use one thread; speed-up and overhead refer to stock Draco at speed " +
         speed + "; stages of the core on one thread, without stitching";
}

// "psplit 0.1.0 (g++ 12.2.0), libdraco ..."
std::string versions_text(const Environment& environment) {
  return "psplit " + environment.psplit + " (" + environment.compiler + "), libdraco " + environment.draco +
         ", meshoptimizer " + environment.meshoptimizer + " with codec " +
         std::to_string(environment.meshopt_codec) + ", zstd " + environment.zstd +
         (environment.brotli.empty() ? "" : ", brotli " + environment.brotli);
}

std::string machine_text(const Environment& environment) {
  return environment.cpu + ", " + counted(static_cast<uint64_t>(environment.threads), "thread") + "; " +
         (environment.gpu.empty() ? "no GPU" : environment.gpu) + "; " + versions_text(environment);
}

}  // namespace

ComparisonSummary summarize(const ComparisonReport& report) {
  return summarize_comparison(
      report.comparison, report.input, report.loading,
      {ComparisonFigures(report).meshopt_name(), report.environment.meshopt_codec == 0});
}

Json to_json(const ComparisonReport& report) {
  const Comparison& comparison = report.comparison;
  const EncodeDocumentOptions& coding = report.options.coding;
  Json result{{"input", report.input}, {"faces", comparison.faces}, {"points", comparison.points}};
  const ComparisonSummary summary = summarize(report);
  append_summary(result, summary);
  result["asset"] = asset_json(report, summary);
  result["environment"] = environment_json(report.environment);
  result["settings"] = {{"encode_speed", coding.encode_speed}, {"position_bits", coding.position_bits},
                        {"normal_bits", coding.normal_bits},   {"texcoord_bits", coding.texcoord_bits},
                        {"color_bits", coding.color_bits},     {"generic_bits", coding.generic_bits},
                        {"lossless", coding.lossless},         {"refine", coding.refine},
                        {"repeat", comparison.rounds},         {"line_mbit", report.loading.line_mbit}};
  result["stock"] = stock_json(comparison.stock);
  result["stock_speeds"] = Json::array();
  for (const StockRow& row : comparison.stock_speeds) result["stock_speeds"].push_back(stock_json(row));
  result["meshopt"] = meshopt_json(comparison.meshopt, report.environment);
  result["meshopt_plain"] = meshopt_json(comparison.meshopt_plain, report.environment);
  result["meshopt_brotli"] = Json();
  if (comparison.meshopt_brotli)
    result["meshopt_brotli"] = meshopt_json(*comparison.meshopt_brotli, report.environment);
  result["splits"] = Json::array();
  for (const SplitRow& row : comparison.splits) {
    Json split{{"patches", row.summary.patches},
               {"condensed", row.rule.condense},
               {"patch_faces", row.mean_patch_faces()},
               {"bytes", row.summary.total_bytes},
               {"overhead", row.overhead},
               {"payload_bytes", row.summary.payload_bytes},
               {"stitch_bytes", row.summary.stitch_bytes},
               {"directory_bytes", row.summary.directory_bytes},
               {"head_bytes", row.summary.head_bytes},
               {"replication", row.summary.replication()},
               {"balance", row.summary.balance()},
               {"partition_ms", row.partition_ms},
               {"encode_ms", row.encode_ms}};
    split["decode"] = Json::array();
    for (const DecodeRow& decode : row.decode) {
      Json object{{"backend", decode.backend}, {"threads", decode.threads}};
      append_timing(object, decode.timing, "");
      object["speedup"] = decode.speedup;
      split["decode"].push_back(std::move(object));
    }
    split["stages"] = Json::array();
    for (const StageRow& stage : row.stages) {
      Json object{{"stage", stage.name}};
      append_timing(object, stage.timing, "");
      split["stages"].push_back(std::move(object));
    }
    result["splits"].push_back(std::move(split));
  }
  return result;
}

std::string to_text(const ComparisonReport& report, bool wide) {
  const Comparison& comparison = report.comparison;
  return report.input + ": " + counted(comparison.faces, "face") + ", " + counted(comparison.points, "point") +
         "\n" + summary_text(report) + "\n" + codecs_text(report, wide) + "\n" + stages_text(comparison) +
         "\n" + wrapped(settings_text(report)) + wrapped(machine_text(report.environment));
}

}  // namespace psplit
