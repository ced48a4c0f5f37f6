#include <algorithm>
#include <cmath>

#include "tools/gltf_psplit/page/html_report.h"
#include "tools/gltf_psplit/page/html_text.h"
#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/patch_summary.h"

namespace psplit {
namespace {

constexpr size_t kWideColumns = 6;  // of tables that tablets do not show as a whole
constexpr size_t kFewRows = 8;      // of tables that one page of paper shows as a whole

// A table whose first `left_columns` columns are text. The first cell of each row is its header. In a window
// that is too narrow, the table scrolls sideways.
std::string html_table(const std::string& id, const std::string& caption,
                       const std::vector<std::string>& header,
                       const std::vector<std::vector<std::string>>& rows, size_t left_columns = 1) {
  const auto alignment = [&](size_t column) { return column < left_columns ? "left" : ""; };
  std::string html = "<table id=\"" + id + "\" aria-label=\"" + escape_html(caption) + "\"><thead><tr>";
  for (size_t i = 0; i < header.size(); ++i)
    html += html_element("th", header[i], "scope=\"col\" class=\"" + std::string(alignment(i)) + "\"");
  html += "</tr></thead>\n<tbody>\n";
  for (const std::vector<std::string>& row : rows) {
    html += "<tr>";
    for (size_t i = 0; i < row.size(); ++i)
      html += i == 0 ? html_element("th", row[i], "scope=\"row\"")
                     : html_element("td", row[i], "class=\"" + std::string(alignment(i)) + "\"");
    html += "</tr>\n";
  }
  return "<div class=\"tabled" + std::string(rows.size() <= kFewRows ? " whole" : "") + "\">" +
         html_element("p", caption, "class=\"caption\"") +
         scrolling_region(caption, header.size() >= kWideColumns, html + "</tbody></table>") + "</div>\n";
}

std::string codec_table(const ComparisonFigures& figures) {
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](const std::string& codec, const std::string& decoder, int threads, uint64_t bytes,
                       const Timing& timing) {
    rows.push_back({codec, decoder, std::to_string(threads), with_separators(bytes), figures.over_base(bytes),
                    figures.median_text(timing), with_decimals(figures.speedup(timing.median_ms), 2),
                    figures.ms_text(timing.min_ms), figures.ms_text(timing.max_ms),
                    with_decimals(figures.bits_per_point(bytes), 2),
                    with_decimals(figures.million_triangles_a_second(timing.median_ms), 1)});
  };
  for (const StockRow& row : figures.comparison.stock_speeds)
    add(figures.stock_name(row), "libdraco", 1, row.bytes, row.decode);
  for (const auto& [with, row] : figures.meshopt_rows())
    add(figures.meshopt_name() + (with.empty() ? "" : " and " + with),
        (with.empty() ? "" : with + ", ") + "meshoptimizer", 1, row->bytes, row->decode);
  for (const SplitRow& row : figures.comparison.splits)
    for (const DecodeRow& decode : row.decode)
      add("psplit, " + figures.patches_name(row), decode.backend, decode.threads, row.summary.total_bytes,
          decode.timing);
  return html_table("codecs",
                    "All timed decoders. Overhead and speed-up refer to " + figures.base_name() +
                        ". Mtri/s: million triangles per second. ~: half of the rounds differ by over " +
                        with_decimals(100 * kNoisySpread, 0) + " %.",
                    {"codec", "decoder", "threads", "bytes", "overhead", "decode ms, median", "speed-up",
                     "least ms", "most ms", "bits per point", "Mtri/s"},
                    rows, 2);
}

std::string size_table(const ComparisonFigures& figures) {
  std::vector<std::vector<std::string>> rows;
  for (const StockRow& row : figures.comparison.stock_speeds)
    rows.push_back({figures.stock_name(row), "", with_separators(row.bytes), "", "", with_separators(row.bytes),
                    figures.over_base(row.bytes), "", "", "", with_decimals(row.encode_ms, 0)});
  for (const SplitRow& row : figures.comparison.splits) {
    const PatchSummary& summary = row.summary;
    rows.push_back({"psplit, " + figures.patches_name(row),
                    with_separators(static_cast<uint64_t>(std::llround(row.mean_patch_faces()))),
                    with_separators(summary.payload_bytes), with_separators(summary.stitch_bytes),
                    with_separators(summary.directory_bytes + summary.head_bytes),
                    with_separators(summary.total_bytes), figures.over_base(summary.total_bytes),
                    as_share(summary.replication()), with_decimals(summary.balance(), 3),
                    with_decimals(row.partition_ms, 0), with_decimals(row.encode_ms, 0)});
  }
  return html_table("sizes", "Size, replication and balance. The time to encode includes the partition.",
                    {"codec", "faces per patch", figures.has_condensed() ? "streams" : "Draco streams",
                     "stitch map", figures.has_condensed() ? "directory and head" : "directory", "all bytes",
                     "overhead", "replication", "balance", "partition ms", "encode ms"},
                    rows);
}

std::string stage_table(const ComparisonFigures& figures) {
  std::vector<std::string> header{"patches"};
  std::vector<std::vector<std::string>> rows;
  for (const SplitRow& row : figures.comparison.splits) {
    std::vector<std::string>& cells = rows.emplace_back();
    cells.push_back(figures.patches_name(row));
    for (const StageRow& stage : row.stages) {
      if (rows.size() == 1) header.push_back(stage.name + ", ms");
      cells.push_back(figures.median_text(stage.timing) + " (" + figures.ms_text(stage.timing.min_ms) + " to " +
                      figures.ms_text(stage.timing.max_ms) + ")");
    }
  }
  return html_table(
      "stage-times",
      "Times of the stages of psplit's decoder on one thread, without stitching: median (least to most).",
      header, rows);
}

}  // namespace

std::string asset_table(const AssetParts& parts, const ComparisonFigures& figures,
                        const ComparisonSummary& summary) {
  const uint64_t meshes[] = {parts.meshes, figures.base.bytes, summary.recommended_bytes};
  const auto row = [&](const std::string& name, auto&& bytes_with) {
    std::vector<std::string> cells{name};
    for (const uint64_t bytes : meshes) cells.push_back(with_separators(bytes_with(bytes)));
    return cells;
  };
  const auto share = [&](uint64_t bytes) {
    return as_share(static_cast<double>(parts.with_meshes(bytes)) /
                    static_cast<double>(std::max<uint64_t>(parts.total(), 1)));
  };
  return html_table(
      "asset",
      "Bytes of the whole asset, including textures. psplit leaves textures and the rest (JSON, "
      "animations and so on) as they are. These are sums of the parts; files may differ from them by "
      "some hundred bytes.",
      {"part", "plain glTF", figures.base_name(), counted(summary.recommended_patches, "patch")},
      {row("meshes", [](uint64_t bytes) { return bytes; }),
       row("textures", [&](uint64_t) { return parts.textures; }),
       row("the rest", [&](uint64_t) { return parts.rest; }),
       row("all", [&](uint64_t bytes) { return parts.with_meshes(bytes); }),
       {"share of plain glTF", share(meshes[0]), share(meshes[1]), share(meshes[2])}});
}

std::string comparison_tables(const ComparisonFigures& figures) {
  return codec_table(figures) + size_table(figures) + stage_table(figures);
}

}  // namespace psplit
