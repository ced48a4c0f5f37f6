#include "tools/gltf_psplit/html_report.h"

#include <algorithm>
#include <filesystem>

#include "tools/gltf_psplit/html_text.h"
#include "tools/gltf_psplit/messages.h"
#include "tools/gltf_psplit/svg_chart.h"

namespace psplit {
namespace {

constexpr const char* kStyle = R"(
:root { color-scheme: light dark; --page: #fff; --text: #1b1f24; --faint: #57606a; --rule: #d5dae0; --shade: #f4f6f8; }
.s0 { --c: #334155 } .s1 { --c: #c2410c } .s2 { --c: #0b62a4 } .s3 { --c: #0f766e }
.s4 { --c: #7c3aed } .s5 { --c: #a16207 } .s6 { --c: #be185d } .s7 { --c: #4d7c0f }
@media (prefers-color-scheme: dark) {
  :root { --page: #14171a; --text: #e6e9ec; --faint: #a3adb8; --rule: #343b43; --shade: #1d2227; }
  .s0 { --c: #b6c2cf } .s1 { --c: #ff9a62 } .s2 { --c: #6cb6ff } .s3 { --c: #4fd1c0 }
  .s4 { --c: #b79cff } .s5 { --c: #e3b341 } .s6 { --c: #ff8fc0 } .s7 { --c: #a3d55d }
}
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2rem 1.25rem 4rem; max-width: 92rem; background: var(--page); color: var(--text);
  font: 16px/1.5 system-ui, sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.25; margin: 0 0 .25rem; overflow-wrap: anywhere; }
h2 { font-size: 1.2rem; margin: 2.5rem 0 .75rem; }
p { max-width: 50rem; margin: 0 0 .75rem; }
.method { columns: 2 30rem; column-gap: 2.5rem; } .method p { break-inside: avoid; }
.lead, figcaption small { color: var(--faint); }
.pair { display: grid; gap: 1.5rem 2.5rem; grid-template-columns: repeat(auto-fit, minmax(min(100%, 30rem), 1fr)); }
figure { margin: 0; min-width: 0; }
figcaption { font-weight: 600; margin-bottom: .25rem; }
figcaption small { display: block; font-weight: 400; }
.picture { text-align: center; }
.picture img { display: block; max-width: 100%; height: auto; margin: 0 auto; }
dl { display: grid; grid-template-columns: max-content minmax(0, 1fr); gap: .2rem 1rem; margin: 0; align-content: start; }
dt { color: var(--faint); } dd { margin: 0; overflow-wrap: anywhere; }
code { font: .9em ui-monospace, monospace; }
.legend { display: flex; flex-wrap: wrap; gap: .1rem 1rem; list-style: none; margin: 0; padding: 0; font-size: .9rem; }
.legend svg { vertical-align: -2px; margin-right: .4rem; }
.plot, .table { overflow-x: auto; }
.plot svg { display: block; width: 100%; min-width: 30rem; height: auto; }
.plot text { font: 13px system-ui, sans-serif; fill: var(--text); font-variant-numeric: tabular-nums; }
.plot text.title, .plot text.tick { fill: var(--faint); }
.plot text.tag { fill: var(--c); font-size: 12px; paint-order: stroke; stroke: var(--page); stroke-width: 3px; }
.grid { stroke: var(--rule); } .axis { stroke: var(--faint); }
.reference { stroke: var(--text); stroke-dasharray: 5 4; }
.mark, .key { fill: var(--c); stroke: var(--page); } .mark:hover { stroke: var(--text); stroke-width: 2; }
.line { fill: none; stroke: var(--c); stroke-width: 1.5; } .spread { stroke: var(--c); stroke-width: 3; opacity: .4; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
caption { text-align: left; color: var(--faint); padding-bottom: .4rem; }
th, td { padding: .25rem .7rem; text-align: right; white-space: nowrap; border-bottom: 1px solid var(--rule); }
th:first-child, td:first-child, .left { text-align: left; padding-left: .4rem; }
thead th { vertical-align: bottom; white-space: normal; } tbody th { font-weight: 600; }
tbody tr:hover { background: var(--shade); }
.table { margin-top: 1.25rem; }
)";

constexpr size_t kStockStyle = 0, kMeshoptStyle = 1, kFirstSplitStyle = 2;

// Milliseconds to three digits or so.
std::string ms_text(double ms) { return with_decimals(ms, ms < 0.1 ? 4 : ms < 1 ? 3 : ms < 100 ? 2 : 1); }

// What is drawn and tabled of the report, with what every part of the page needs.
class Page {
 public:
  explicit Page(const ComparisonReport& report)
      : report_(report), comparison_(report.comparison), base_(report.comparison.stock) {}

  std::string to_string() const {
    const std::string title =
        std::filesystem::path(report_.input).filename().string() + ": size and decoding speed";
    return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
           "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
           "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
           "'unsafe-inline'; "
           "img-src data:\">\n"
           "<link rel=\"icon\" href=\"data:,\">\n" +
           html_element("title", title) + "\n<style>" + kStyle + "</style>\n</head>\n<body>\n<header>\n" +
           html_element("h1", title) + "\n" +
           html_element("p",
                        counted(comparison_.faces, "triangle") + ", " + counted(comparison_.points, "point") +
                            ": patches that psplit decodes in parallel, beside stock Draco and meshoptimizer.",
                        "class=\"lead\"") +
           "\n</header>\n<main>\n" + opening() + method() + charts() + tables() + "</main>\n</body>\n</html>\n";
  }

 private:
  std::string opening() const;
  std::string method() const;
  std::string charts() const;
  std::string tables() const;

  XyChart size_against_speed() const;
  XyChart speedup_by_patches() const;
  BarChart size_by_patches() const;
  BarChart stages() const;
  XyChart by_patches(const std::string& id, const std::string& title, const ChartAxis& axis,
                     double (*value)(const SplitRow&), std::string (*text)(double)) const;

  std::string codec_table() const;
  std::string size_table() const;
  std::string stage_table() const;

  double bits_per_point(uint64_t bytes) const {
    return comparison_.points == 0 ? 0
                                   : 8 * static_cast<double>(bytes) / static_cast<double>(comparison_.points);
  }
  double million_triangles_a_second(double ms) const {
    return static_cast<double>(comparison_.faces) / std::max(ms, 1e-6) / 1000;
  }
  double speedup(double ms) const { return base_.decode.median_ms / std::max(ms, 1e-6); }
  std::string over_base(uint64_t bytes) const {
    return as_percent(static_cast<double>(bytes) / static_cast<double>(std::max<uint64_t>(base_.bytes, 1)) - 1);
  }
  std::string base_name() const { return "stock Draco, speed " + std::to_string(base_.speed); }

  // One mark of the chart of size and speed.
  ChartPoint speed_point(const std::string& name, const std::string& tag, uint64_t bytes,
                         const Timing& timing) const {
    const double bits = bits_per_point(bytes);
    return {million_triangles_a_second(timing.median_ms), bits, tag,
            name + ": " + with_separators(bytes) + " bytes, " + ms_text(timing.median_ms) + " ms (" +
                ms_text(timing.min_ms) + " to " + ms_text(timing.max_ms) + ")",
            ChartPoint::Spread{million_triangles_a_second(timing.max_ms),
                               million_triangles_a_second(timing.min_ms), bits, bits}};
  }

  const ComparisonReport& report_;
  const Comparison& comparison_;
  const StockRow& base_;  // what ratios refer to
};

std::string decoder_name(const DecodeRow& row) {
  return row.backend + ", " + counted(static_cast<uint64_t>(row.threads), "thread");
}

std::string patches_name(const SplitRow& row) { return counted(row.summary.patches, "patch"); }

std::string Page::opening() const {
  const Environment& environment = report_.environment;
  const EncodeDocumentOptions& coding = report_.options.coding;
  std::string list = "<dl>";
  const auto add = [&](const char* what, const std::string& text, const char* tag = "span") {
    list += html_element("dt", what) + "<dd>" + html_element(tag, text) + "</dd>\n";
  };
  add("Input", report_.input);
  add("Command", environment.command_line, "code");
  add("Date", environment.date + " UTC");
  add("CPU", environment.cpu + ", " + counted(static_cast<uint64_t>(environment.threads), "thread"));
  add("GPU", environment.gpu.empty() ? "none that this build can use" : environment.gpu);
  add("psplit", environment.psplit + ", built with " + environment.compiler);
  add("libdraco", environment.draco);
  add("meshoptimizer", environment.meshoptimizer);
  add("zstd", environment.zstd);
  add("Draco speed",
      std::to_string(coding.encode_speed) + " for patches, and for the stock stream that ratios refer to");
  add("Bits", coding.lossless ? "all: lossless"
                              : "positions " + std::to_string(coding.position_bits) + ", normals " +
                                    std::to_string(coding.normal_bits) + ", texture coordinates " +
                                    std::to_string(coding.texcoord_bits) + ", colours " +
                                    std::to_string(coding.color_bits) + ", other floats " +
                                    std::to_string(coding.generic_bits));
  if (!coding.refine) add("Borders", "not refined");
  add("Rounds", std::to_string(report_.options.repeat) + ", after one that is not timed");
  list += "</dl>\n";
  std::string picture;
  if (!report_.picture.png.empty()) {
    const std::string what = "The input in " + counted(report_.picture.patches, "patch");
    picture = "<figure class=\"picture\"><img alt=\"" + what + "\" src=\"data:image/png;base64," +
              base64(report_.picture.png) + "\" width=\"1200\" height=\"900\"><figcaption>" + what +
              (report_.picture.patches == 1 ? "" : ", each in a colour of its own") +
              "</figcaption></figure>\n";
  }
  return "<section>\n<h2>What was measured, and where</h2>\n<div class=\"pair\">\n" + list + picture +
         "</div>\n</section>\n";
}

std::string Page::method() const {
  const bool has_cuda = std::ranges::any_of(comparison_.splits, [](const SplitRow& row) {
    return std::ranges::find(row.decode, "cuda", &DecodeRow::backend) != row.decode.end();
  });
  const auto paragraph = [](const std::string& text) { return html_element("p", text) + "\n"; };
  return "<section>\n<h2>How</h2>\n<div class=\"method\">\n" +
         paragraph(
             "All decoders ran in one process and took turns: in each round each of them decoded everything "
             "once. Times are medians of the rounds; the fastest and the slowest are in the tables, and are "
             "pale "
             "lines through the marks of the charts, cut off at a chart's edge. They are from bytes in the "
             "host's "
             "memory to indices and attributes there: reading files is not in them" +
             std::string(has_cuda ? ", copying to the GPU and back is." : ".")) +
         paragraph(
             "Stock Draco is one stream for each primitive, decoded on one thread: it has no use for more. "
             "Its library is the installed libdraco " +
             report_.environment.draco +
             ", linked as it is: psplit neither builds nor changes it. The decoder named draco is the same "
             "library "
             "on patches; cpu is psplit's own" +
             (has_cuda ? ", and cuda its own on the GPU." : ".")) +
         paragraph(
             "Meshoptimizer gets its meshes as its documentation recommends for small files: points merged, "
             "triangles ordered in strips and points for vertex fetch, quantized (normals and tangents to 8 "
             "bits), indices in version 1 of its codec; zstd is at level 19. It runs on one thread. What it "
             "decodes to stays quantized, as GPUs take it; the others decode to floats where the input has "
             "them.") +
         paragraph("Encoding ran once, patches on all threads. Overhead and speed-up refer to " + base_name() +
                   ".") +
         "</section>\n";
}

XyChart Page::size_against_speed() const {
  XyChart chart{"size-speed",
                "Size against decoding speed",
                "Right is faster, down is smaller; numbers beside marks are patches.",
                {"million triangles a second", true},
                {"bits a point"},
                {}};
  ChartSeries stock{"stock Draco by speed, 1 thread", kStockStyle, true, {}};
  for (const StockRow& row : comparison_.stock_speeds)
    stock.points.push_back(speed_point("stock Draco, speed " + std::to_string(row.speed),
                                       "speed " + std::to_string(row.speed), row.bytes, row.decode));
  ChartSeries meshopt{"meshoptimizer, 1 thread", kMeshoptStyle, true, {}};
  meshopt.points.push_back(
      speed_point("meshoptimizer", "plain", comparison_.meshopt_plain.bytes, comparison_.meshopt_plain.decode));
  meshopt.points.push_back(
      speed_point("meshoptimizer and zstd", "zstd", comparison_.meshopt.bytes, comparison_.meshopt.decode));
  chart.series = {std::move(stock), std::move(meshopt)};
  for (const SplitRow& row : comparison_.splits)
    for (size_t i = 0; i < row.decode.size(); ++i) {
      const DecodeRow& decode = row.decode[i];
      if (chart.series.size() <= i + 2)
        chart.series.push_back({"psplit " + decoder_name(decode), kFirstSplitStyle + i, true, {}});
      chart.series[i + 2].points.push_back(speed_point(patches_name(row) + ", " + decoder_name(decode),
                                                       with_separators(row.summary.patches),
                                                       row.summary.total_bytes, decode.timing));
    }
  return chart;
}

XyChart Page::speedup_by_patches() const {
  XyChart chart{
      "speed-up", "Speed-up by number of patches", "", {"patches", true, 0, true}, {"times " + base_name()},
      {},         ChartReference{1, base_name()}};
  for (const SplitRow& row : comparison_.splits)
    for (size_t i = 0; i < row.decode.size(); ++i) {
      const DecodeRow& decode = row.decode[i];
      if (chart.series.size() <= i)
        chart.series.push_back({decoder_name(decode), kFirstSplitStyle + i, true, {}});
      const auto patches = static_cast<double>(row.summary.patches);
      chart.series[i].points.push_back(
          {patches, decode.speedup, with_decimals(decode.speedup, 1),
           patches_name(row) + ", " + decoder_name(decode) + ": " + with_decimals(decode.speedup, 2) + " times",
           ChartPoint::Spread{patches, patches, speedup(decode.timing.max_ms), speedup(decode.timing.min_ms)}});
    }
  return chart;
}

BarChart Page::size_by_patches() const {
  uint64_t largest = base_.bytes;
  for (const SplitRow& row : comparison_.splits) largest = std::max(largest, row.summary.total_bytes);
  const auto [unit, scale] = largest >= 10'000'000 ? std::pair("MB", 1e6)
                             : largest >= 10'000   ? std::pair("kB", 1e3)
                                                   : std::pair("bytes", 1.0);
  const auto scaled = [&, by = scale](uint64_t bytes) { return static_cast<double>(bytes) / by; };
  BarChart chart{"size",
                 "Size by number of patches",
                 unit,
                 unit,
                 {"Draco streams", "stitch map", "directory"},
                 {},
                 ChartReference{scaled(base_.bytes), base_name()}};
  chart.bars.push_back({base_name(), {scaled(base_.bytes)}, ""});
  for (const SplitRow& row : comparison_.splits)
    chart.bars.push_back({patches_name(row),
                          {scaled(row.summary.payload_bytes), scaled(row.summary.stitch_bytes),
                           scaled(row.summary.directory_bytes)},
                          as_percent(row.overhead)});
  return chart;
}

BarChart Page::stages() const {
  BarChart chart{"stages", "Decoding by stage, psplit's core on one thread", "ms", "ms", {}, {}};
  for (const SplitRow& row : comparison_.splits) {
    BarChart::Bar bar{patches_name(row), {}, ""};
    double sum = 0;
    for (const StageRow& stage : row.stages) {
      if (chart.bars.empty()) chart.parts.push_back(stage.name);
      bar.values.push_back(stage.timing.median_ms);
      sum += stage.timing.median_ms;
    }
    bar.total = ms_text(sum) + " ms";
    chart.bars.push_back(std::move(bar));
  }
  return chart;
}

XyChart Page::by_patches(const std::string& id, const std::string& title, const ChartAxis& axis,
                         double (*value)(const SplitRow&), std::string (*text)(double)) const {
  XyChart chart{id, title, "", {"patches", true, 0, true}, axis, {}};
  ChartSeries series{"psplit", kFirstSplitStyle, true, {}};
  for (const SplitRow& row : comparison_.splits)
    series.points.push_back({static_cast<double>(row.summary.patches), value(row), text(value(row)),
                             patches_name(row) + ": " + text(value(row))});
  chart.series.push_back(std::move(series));
  return chart;
}

std::string Page::charts() const {
  return "<section>\n<h2>Charts</h2>\n<div class=\"pair\">\n" + draw_chart(size_against_speed()) +
         draw_chart(speedup_by_patches()) + draw_chart(size_by_patches()) + draw_chart(stages()) +
         draw_chart(by_patches(
             "replication", "Replication: points that are stored more than once, per point", {"percent"},
             [](const SplitRow& row) { return 100 * row.summary.replication(); },
             [](double percent) { return as_share(percent / 100); })) +
         draw_chart(by_patches(
             "balance", "Balance: faces of the largest patch, per mean of all", {"largest / mean", false, 1},
             [](const SplitRow& row) { return row.summary.balance(); },
             [](double balance) { return with_decimals(balance, 3); })) +
         "</div>\n</section>\n";
}

// A table whose first `left_columns` columns are text; a row's first cell is its header.
std::string html_table(const std::string& id, const std::string& caption,
                       const std::vector<std::string>& header,
                       const std::vector<std::vector<std::string>>& rows, size_t left_columns = 1) {
  const auto alignment = [&](size_t column) { return column < left_columns ? "left" : ""; };
  std::string html =
      "<div class=\"table\"><table id=\"" + id + "\">" + html_element("caption", caption) + "<thead><tr>";
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
  return html + "</tbody></table></div>\n";
}

std::string Page::codec_table() const {
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](const std::string& codec, const std::string& decoder, int threads, uint64_t bytes,
                       const Timing& timing) {
    rows.push_back({codec, decoder, std::to_string(threads), with_separators(bytes),
                    with_decimals(bits_per_point(bytes), 2), over_base(bytes), ms_text(timing.median_ms),
                    ms_text(timing.min_ms), ms_text(timing.max_ms), with_decimals(speedup(timing.median_ms), 2),
                    with_decimals(million_triangles_a_second(timing.median_ms), 1)});
  };
  for (const StockRow& row : comparison_.stock_speeds)
    add("stock Draco, speed " + std::to_string(row.speed), "libdraco", 1, row.bytes, row.decode);
  add("meshoptimizer", "meshoptimizer", 1, comparison_.meshopt_plain.bytes, comparison_.meshopt_plain.decode);
  add("meshoptimizer and zstd", "zstd, meshoptimizer", 1, comparison_.meshopt.bytes,
      comparison_.meshopt.decode);
  for (const SplitRow& row : comparison_.splits)
    for (const DecodeRow& decode : row.decode)
      add("psplit, " + patches_name(row), decode.backend, decode.threads, row.summary.total_bytes,
          decode.timing);
  return html_table("codecs",
                    "Every decoder that was timed; overhead and speed-up refer to " + base_name() +
                        "; Mtri/s are million triangles a second.",
                    {"codec", "decoder", "threads", "bytes", "bits a point", "overhead", "decode ms, median",
                     "least", "most", "speed-up", "Mtri/s"},
                    rows, 2);
}

std::string Page::size_table() const {
  std::vector<std::vector<std::string>> rows;
  for (const StockRow& row : comparison_.stock_speeds)
    rows.push_back({"stock Draco, speed " + std::to_string(row.speed), "", with_separators(row.bytes), "", "",
                    with_separators(row.bytes), over_base(row.bytes), "", "", "",
                    with_decimals(row.encode_ms, 0)});
  for (const SplitRow& row : comparison_.splits) {
    const PatchSummary& summary = row.summary;
    rows.push_back({"psplit, " + patches_name(row), with_decimals(row.mean_patch_faces(), 0),
                    with_separators(summary.payload_bytes), with_separators(summary.stitch_bytes),
                    with_separators(summary.directory_bytes), with_separators(summary.total_bytes),
                    over_base(summary.total_bytes), as_share(summary.replication()),
                    with_decimals(summary.balance(), 3), with_decimals(row.partition_ms, 0),
                    with_decimals(row.encode_ms, 0)});
  }
  return html_table("sizes", "Size, replication and balance; encoding includes the partition.",
                    {"codec", "faces a patch", "Draco streams", "stitch map", "directory", "bytes in all",
                     "overhead", "replication", "balance", "partition ms", "encode ms"},
                    rows);
}

std::string Page::stage_table() const {
  std::vector<std::string> header{"patches"};
  std::vector<std::vector<std::string>> rows;
  for (const SplitRow& row : comparison_.splits) {
    std::vector<std::string>& cells = rows.emplace_back();
    cells.push_back(patches_name(row));
    for (const StageRow& stage : row.stages) {
      if (rows.size() == 1) header.push_back(stage.name + ", ms");
      cells.push_back(ms_text(stage.timing.median_ms) + " (" + ms_text(stage.timing.min_ms) + " to " +
                      ms_text(stage.timing.max_ms) + ")");
    }
  }
  return html_table(
      "stage-times",
      "Stages of psplit's core on one thread: median (least to most); stitching is not among them.", header,
      rows);
}

std::string Page::tables() const {
  return "<section>\n<h2>Numbers</h2>\n" + codec_table() + size_table() + stage_table() + "</section>\n";
}

}  // namespace

std::string to_html(const ComparisonReport& report) { return Page(report).to_string(); }

}  // namespace psplit
