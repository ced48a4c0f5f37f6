#include "tools/gltf_psplit/page/html_charts.h"

#include <algorithm>
#include <cmath>

#include "tools/gltf_psplit/page/svg_chart.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

constexpr size_t kStockStyle = 0, kMeshoptStyle = 1, kFirstSplitStyle = 2;

// One mark of the chart of size against speed.
ChartPoint speed_point(const ComparisonFigures& figures, const std::string& name, const std::string& tag,
                       uint64_t bytes, const Timing& timing) {
  const double bits = figures.bits_per_point(bytes);
  return {figures.million_triangles_a_second(timing.median_ms), bits, tag,
          name + ": " + with_separators(bytes) + " bytes, " + figures.ms_text(timing.median_ms) + " ms (" +
              figures.ms_text(timing.min_ms) + " to " + figures.ms_text(timing.max_ms) + ")",
          ChartPoint::Spread{figures.million_triangles_a_second(timing.max_ms),
                             figures.million_triangles_a_second(timing.min_ms), bits, bits}};
}

// Condensed patches have series of their own, after the others.
size_t split_style(const SplitRow& row, size_t decoder) {
  return kFirstSplitStyle + decoder + (row.rule.condense ? row.decode.size() : 0);
}

// The series of that name, which is added if the chart has none.
ChartSeries& series_of(XyChart& chart, const std::string& name, size_t style) {
  const auto found = std::ranges::find(chart.series, name, &ChartSeries::name);
  return found != chart.series.end() ? *found : chart.series.emplace_back(ChartSeries{name, style, true, {}});
}

XyChart size_against_speed(const ComparisonFigures& figures) {
  XyChart chart{"size-speed",
                "Size against decoding speed",
                "Right is faster, down is smaller. Numbers beside marks are patches. Pale lines reach from the "
                "slowest to the fastest round.",
                {"million triangles per second", true},
                {"bits per point"},
                {}};
  ChartSeries stock{"stock Draco by speed, 1 thread", kStockStyle, true, {}};
  for (const StockRow& row : figures.comparison.stock_speeds)
    stock.points.push_back(speed_point(figures, figures.stock_name(row), "speed " + std::to_string(row.speed),
                                       row.bytes, row.decode));
  ChartSeries meshopt{figures.meshopt_name() + ", 1 thread", kMeshoptStyle, true, {}};
  meshopt.points.push_back(speed_point(figures, figures.meshopt_name(), "plain",
                                       figures.comparison.meshopt_plain.bytes,
                                       figures.comparison.meshopt_plain.decode));
  meshopt.points.push_back(speed_point(figures, figures.meshopt_name() + " and zstd", "zstd",
                                       figures.comparison.meshopt.bytes, figures.comparison.meshopt.decode));
  chart.series = {std::move(stock), std::move(meshopt)};
  for (const SplitRow& row : figures.comparison.splits)
    for (size_t i = 0; i < row.decode.size(); ++i) {
      const DecodeRow& decode = row.decode[i];
      const std::string name = row.rule.condense ? "psplit condensed " : "psplit ";
      series_of(chart, name + figures.decoder_name(decode), split_style(row, i))
          .points.push_back(
              speed_point(figures, figures.patches_name(row) + ", " + figures.decoder_name(decode),
                          with_separators(row.summary.patches), row.summary.total_bytes, decode.timing));
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
    for (size_t i = 0; i < row.decode.size(); ++i) {
      const DecodeRow& decode = row.decode[i];
      const auto patches = static_cast<double>(row.summary.patches);
      const std::string name = row.rule.condense ? "condensed, " : "";
      series_of(chart, name + figures.decoder_name(decode), split_style(row, i))
          .points.push_back({patches, decode.speedup, with_decimals(decode.speedup, 1),
                             figures.patches_name(row) + ", " + figures.decoder_name(decode) + ": " +
                                 with_decimals(decode.speedup, 2) + " times",
                             ChartPoint::Spread{patches, patches, figures.speedup(decode.timing.max_ms),
                                                figures.speedup(decode.timing.min_ms)}});
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
ChartSeries level(const std::string& name, size_t style, double percent, double low_x, double high_x) {
  ChartSeries series{name, style, true, {}};
  for (const double x : {low_x, high_x})
    series.points.push_back({x, percent, "", name + ": " + with_decimals(percent, 1) + " %"});
  return series;
}

XyChart size_by_patch_size(const ComparisonFigures& figures) {
  const Comparison& comparison = figures.comparison;
  const auto percent = [&](uint64_t bytes) {
    return 100 * static_cast<double>(bytes) / static_cast<double>(std::max<uint64_t>(1, figures.base.bytes));
  };
  XyChart chart{
      "patch-size",
      "Bytes by size of patches",
      "Smaller patches decode on more threads, and take more bytes. Stock Draco is the dashed line; like "
      "it, meshoptimizer does not cut the mesh.",
      {"triangles of a patch", true, 0, true},
      {"percent of the bytes of " + figures.base_name()},
      {},
      ChartReference{100, figures.base_name()}};
  double low_x = static_cast<double>(std::max<uint64_t>(1, comparison.faces)), high_x = low_x;
  double low_y = 100;
  for (const SplitRow& row : comparison.splits) {
    const double faces = row.mean_patch_faces();
    low_x = faces > 0 ? std::min(low_x, faces) : low_x;
    low_y = std::min(low_y, percent(row.summary.total_bytes));
    series_of(chart, row.rule.condense ? "psplit condensed" : "psplit",
              kFirstSplitStyle + (row.rule.condense ? 1 : 0))
        .points.push_back({faces, percent(row.summary.total_bytes), as_percent(row.overhead),
                           figures.patches_name(row) + ": " + with_separators(row.summary.total_bytes) +
                               " bytes, " + as_percent(row.overhead)});
  }
  chart.series.push_back(
      level(figures.meshopt_name(), kMeshoptStyle, percent(comparison.meshopt_plain.bytes), low_x, high_x));
  chart.series.push_back(level(figures.meshopt_name() + " and zstd", kMeshoptStyle + 3,
                               percent(comparison.meshopt.bytes), low_x, high_x));
  for (const auto* rival : {&comparison.meshopt_plain, &comparison.meshopt})
    low_y = std::min(low_y, percent(rival->bytes));
  chart.y.start = 10 * std::floor(low_y / 10);
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
    double sum = 0;
    for (const StageRow& stage : row.stages) {
      if (chart.bars.empty()) chart.parts.push_back(stage.name);
      bar.values.push_back(stage.timing.median_ms);
      sum += stage.timing.median_ms;
    }
    bar.total = figures.ms_text(sum) + " ms";
    chart.bars.push_back(std::move(bar));
  }
  return chart;
}

XyChart by_patches(const ComparisonFigures& figures, const std::string& id, const std::string& title,
                   const std::string& note, const ChartAxis& axis, double (*value)(const SplitRow&),
                   std::string (*text)(double)) {
  XyChart chart{id, title, note, {"patches", true, 0, true}, axis, {}};
  ChartSeries series{"psplit", kFirstSplitStyle, true, {}};
  for (const SplitRow& row : figures.comparison.splits)
    if (!row.rule.condense)  // these are cut alike
      series.points.push_back({static_cast<double>(row.summary.patches), value(row), text(value(row)),
                               figures.patches_name(row) + ": " + text(value(row))});
  chart.series.push_back(std::move(series));
  return chart;
}

}  // namespace

std::string comparison_charts(const ComparisonFigures& figures) {
  return draw_chart(size_against_speed(figures)) + draw_chart(speedup_by_patches(figures)) +
         draw_chart(size_by_patch_size(figures)) + draw_chart(size_by_patches(figures)) +
         draw_chart(stages(figures)) +
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
