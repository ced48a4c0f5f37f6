#include <algorithm>
#include <cmath>

#include "tools/gltf_psplit/page/html_report.h"
#include "tools/gltf_psplit/page/svg_chart.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

enum : size_t { kStock, kMeshopt, kCpu, kCuda, kDraco };  // colours, and shapes of ordinary patches
constexpr size_t kCondensedShapes = 3;                    // how far shapes of condensed patches follow

std::string noisy_text() {
  return "half of the rounds differ by over " + with_decimals(100 * kNoisySpread, 0) + " %";
}

// The colour tells who decodes, the shape whether patches are condensed. One thread is hollow.
ChartStyle split_style(const SplitRow& row, const DecodeRow& decode) {
  const size_t color = decode.backend == "cuda" ? kCuda : decode.backend == "draco" ? kDraco : kCpu;
  return {color, color + (row.rule.condense ? kCondensedShapes : 0), decode.threads == 1, row.rule.condense};
}

// One mark of the chart of size against speed.
ChartPoint speed_point(const ComparisonFigures& figures, const std::string& name, const std::string& tag,
                       uint64_t bytes, const Timing& timing) {
  const double percent = figures.percent_of_base(bytes);
  return {figures.million_triangles_a_second(timing.median_ms),
          percent,
          tag,
          name + ": " + with_separators(bytes) + " bytes, " + figures.ms_text(timing.median_ms) + " ms (" +
              figures.ms_text(timing.lower_quartile_ms) + " to " + figures.ms_text(timing.upper_quartile_ms) +
              ")",
          ChartPoint::Spread{figures.million_triangles_a_second(timing.upper_quartile_ms),
                             figures.million_triangles_a_second(timing.lower_quartile_ms), percent, percent},
          is_noisy(timing)};
}

// The series of that name, which is added if the chart has none.
ChartSeries& series_of(XyChart& chart, const std::string& name, const ChartStyle& style) {
  const auto found = std::ranges::find(chart.series, name, &ChartSeries::name);
  return found != chart.series.end() ? *found : chart.series.emplace_back(ChartSeries{name, style, {}});
}

// Only the fastest decoder of a row has a tag, so that the tags are few.
std::string tag_of(const SplitRow& row, const DecodeRow& decode, const std::string& tag) {
  return &decode == &fastest_decoder(row) ? tag : "";
}

// libdraco on patches is left out, unless it alone was timed: psplit's own decoders read the same bytes. So is
// brotli, whose mark would be beside zstd's.
XyChart size_against_speed(const ComparisonFigures& figures) {
  const Comparison& comparison = figures.comparison;
  XyChart chart{"size-speed",
                "Size against decoding speed",
                "Right is faster, down is smaller. Pale lines cover half of the rounds.",
                {"million triangles per second", true},
                {"% of the bytes of " + figures.base_name(), true},
                {},
                {},
                "above and left of this line, something else is both smaller and faster",
                920,
                440};
  ChartSeries stock{"stock Draco by speed, 1 thread", {kStock, kStock, false, false}, {}};
  for (const StockRow& row : comparison.stock_speeds)
    stock.points.push_back(speed_point(figures, figures.stock_name(row), "speed " + std::to_string(row.speed),
                                       row.bytes, row.decode));
  ChartSeries plain{figures.meshopt_name() + ", 1 thread", {kMeshopt, kMeshopt, true, false}, {}};
  plain.points.push_back(speed_point(figures, figures.meshopt_name(), "meshopt", comparison.meshopt_plain.bytes,
                                     comparison.meshopt_plain.decode));
  ChartSeries zstd{"the same with zstd, 1 thread", {kMeshopt, kMeshopt, false, false}, {}};
  zstd.points.push_back(speed_point(figures, figures.meshopt_name() + " and zstd", "meshopt + zstd",
                                    comparison.meshopt.bytes, comparison.meshopt.decode));
  chart.series = {std::move(stock), std::move(plain), std::move(zstd)};
  for (const SplitRow& row : comparison.splits)
    for (const DecodeRow& decode : row.decode) {
      if (decode.backend == "draco" && fastest_decoder(row).backend != "draco") continue;
      const std::string name = row.rule.condense ? "psplit condensed, " : "psplit, ";
      series_of(chart, name + figures.decoder_name(decode), split_style(row, decode))
          .points.push_back(
              speed_point(figures, figures.patches_name(row) + ", " + figures.decoder_name(decode),
                          tag_of(row, decode,
                                 row.rule.condense ? with_separators(row.summary.patches) + " condensed"
                                                   : counted(row.summary.patches, "patch")),
                          row.summary.total_bytes, decode.timing));
    }
  return chart;
}

XyChart speedup_by_patches(const ComparisonFigures& figures) {
  XyChart chart{"speed-up",
                "Speed-up by number of patches",
                "How many times as fast as stock Draco, which is the dashed line.",
                {"patches", true, 0, true},
                {"times " + figures.base_name()},
                {},
                ChartReference{1, figures.base_name()}};
  for (const SplitRow& row : figures.comparison.splits)
    for (const DecodeRow& decode : row.decode) {
      const auto patches = static_cast<double>(row.summary.patches);
      const std::string name = row.rule.condense ? "condensed, " : "";
      series_of(chart, name + figures.decoder_name(decode), split_style(row, decode))
          .points.push_back(
              {patches, decode.speedup, tag_of(row, decode, with_decimals(decode.speedup, 1)),
               figures.patches_name(row) + ", " + figures.decoder_name(decode) + ": " +
                   with_decimals(decode.speedup, 2) + " times",
               ChartPoint::Spread{patches, patches, figures.speedup(decode.timing.upper_quartile_ms),
                                  figures.speedup(decode.timing.lower_quartile_ms)},
               is_noisy(decode.timing)});
    }
  return chart;
}

BarChart size_by_patches(const ComparisonFigures& figures) {
  uint64_t largest = figures.base.bytes;
  for (const SplitRow& row : figures.comparison.splits) largest = std::max(largest, row.summary.total_bytes);
  const auto [unit, scale] = largest >= 10'000'000 ? std::pair("MB", 1e6)
                             : largest >= 10'000   ? std::pair("kB", 1e3)
                                                   : std::pair("bytes", 1.0);
  const auto scaled = [&, by = scale](uint64_t bytes) { return static_cast<double>(bytes) / by; };
  const bool has_condensed = figures.has_condensed();
  BarChart chart{"size",
                 "Size by number of patches",
                 "The percentages are the overhead: how many more bytes than stock Draco.",
                 unit,
                 unit,
                 {has_condensed ? "streams" : "Draco streams", "stitch map",
                  has_condensed ? "directory and head" : "directory"},
                 {},
                 ChartReference{scaled(figures.base.bytes), figures.base_name()}};
  chart.bars.push_back({figures.base_name(), {scaled(figures.base.bytes)}, ""});
  for (const SplitRow& row : figures.comparison.splits)
    chart.bars.push_back({figures.patches_name(row),
                          {scaled(row.summary.payload_bytes), scaled(row.summary.stitch_bytes),
                           scaled(row.summary.directory_bytes + row.summary.head_bytes)},
                          as_percent(row.overhead)});
  return chart;
}

// A line that reaches over the whole chart: a size that does not depend on patches.
ChartSeries level(const std::string& name, const ChartStyle& style, double percent, double low_x,
                  double high_x) {
  ChartSeries series{name, style, {}};
  for (const double x : {low_x, high_x})
    series.points.push_back({x, percent, "", name + ": " + with_decimals(percent, 1) + " %"});
  return series;
}

XyChart size_by_patch_size(const ComparisonFigures& figures) {
  const Comparison& comparison = figures.comparison;
  XyChart chart{
      "patch-size",
      "Bytes by size of patches",
      "Smaller patches decode on more threads, and take more bytes. Stock Draco is the dashed line; like "
      "it, meshoptimizer does not cut the mesh.",
      {"triangles of a patch", true, 0, true},
      {"% of the bytes of " + figures.base_name(), true},
      {},
      ChartReference{100, figures.base_name()}};
  double low_x = static_cast<double>(std::max<uint64_t>(1, comparison.faces)), high_x = low_x;
  for (const SplitRow& row : comparison.splits) {
    const double faces = row.mean_patch_faces(), percent = figures.percent_of_base(row.summary.total_bytes);
    low_x = faces > 0 ? std::min(low_x, faces) : low_x;
    const bool is_condensed = row.rule.condense;
    series_of(chart, is_condensed ? "psplit condensed" : "psplit",
              {kCpu, kCpu + (is_condensed ? kCondensedShapes : 0), false, is_condensed})
        .points.push_back({faces, percent, as_percent(row.overhead),
                           figures.patches_name(row) + ": " + with_separators(row.summary.total_bytes) +
                               " bytes, " + as_percent(row.overhead)});
  }
  chart.series.push_back(level(figures.meshopt_name(), {kMeshopt, kMeshopt, true, true},
                               figures.percent_of_base(comparison.meshopt_plain.bytes), low_x, high_x));
  chart.series.push_back(level(figures.meshopt_name() + " and zstd", {kMeshopt, kMeshopt, false, false},
                               figures.percent_of_base(comparison.meshopt.bytes), low_x, high_x));
  return chart;
}

BarChart stages(const ComparisonFigures& figures) {
  BarChart chart{"stages",
                 "Decoding time by stage, one thread",
                 "Where psplit's own decoder spends its time, without stitching the patches together.",
                 "ms",
                 "ms",
                 {},
                 {}};
  for (const SplitRow& row : figures.comparison.splits) {
    BarChart::Bar bar{figures.patches_name(row), {}, ""};
    Timing sum;
    for (const StageRow& stage : row.stages) {
      if (chart.bars.empty()) chart.parts.push_back(stage.name);
      bar.values.push_back(stage.timing.median_ms);
      bar.noisy.push_back(is_noisy(stage.timing));
      sum.median_ms += stage.timing.median_ms;
      sum.lower_quartile_ms += stage.timing.lower_quartile_ms;
      sum.upper_quartile_ms += stage.timing.upper_quartile_ms;
    }
    bar.total = (is_noisy(sum) ? "about " : "") + figures.ms_text(sum.median_ms) + " ms";
    chart.bars.push_back(std::move(bar));
  }
  return chart;
}

XyChart by_patches(const ComparisonFigures& figures, const std::string& id, const std::string& title,
                   const std::string& note, const ChartAxis& axis, double (*value)(const SplitRow&),
                   std::string (*text)(double)) {
  XyChart chart{id, title, note, {"patches", true, 0, true}, axis, {}};
  ChartSeries series{"psplit", {kCpu, kCpu, false, false}, {}};
  for (const SplitRow& row : figures.comparison.splits)
    if (!row.rule.condense)  // these are cut alike
      series.points.push_back({static_cast<double>(row.summary.patches), value(row), text(value(row)),
                               figures.patches_name(row) + ": " + text(value(row))});
  chart.series.push_back(std::move(series));
  return chart;
}

}  // namespace

std::string chart_of_size_and_speed(const ComparisonFigures& figures) {
  return draw_chart(size_against_speed(figures), noisy_text());
}

std::string comparison_charts(const ComparisonFigures& figures) {
  return draw_chart(speedup_by_patches(figures), noisy_text()) + draw_chart(size_by_patch_size(figures)) +
         draw_chart(size_by_patches(figures)) + draw_chart(stages(figures), noisy_text()) +
         draw_chart(by_patches(
             figures, "replication", "Replication by number of patches",
             "Points on borders are stored in every patch that they touch. This is how many more points that "
             "makes than the mesh has.",
             {"percent"}, [](const SplitRow& row) { return 100 * row.summary.replication(); },
             [](double percent) { return as_share(percent / 100); })) +
         draw_chart(by_patches(
             figures, "balance", "Balance by number of patches",
             "Triangles of the largest patch, divided by the mean over all patches. At 1, all patches are "
             "equally large.",
             {"largest / mean", false, 1}, [](const SplitRow& row) { return row.summary.balance(); },
             [](double balance) { return with_decimals(balance, 3); }));
}

}  // namespace psplit
