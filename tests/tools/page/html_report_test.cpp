#include "tools/gltf_psplit/page/html_report.h"

#include <gtest/gtest.h>

#include <map>

#include "tools/gltf_psplit/compare/comparison_summary.h"
#include "tools/gltf_psplit/page/html_text.h"
#include "tools/gltf_psplit/page/svg_chart.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

size_t count_of(const std::string& text, const std::string& what) {
  size_t count = 0;
  for (size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += what.size()) ++count;
  return count;
}

// The text between the first `begin` and the next `end`.
std::string part_of(const std::string& text, const std::string& begin, const std::string& end) {
  const size_t from = text.find(begin);
  if (from == std::string::npos) return "";
  return text.substr(from, text.find(end, from) - from);
}

// A report in which all numbers differ.
ComparisonReport sample_report() {
  ComparisonReport report;
  report.input = "dragon.ply";
  report.options.repeat = 7;
  report.environment = {.cpu = "Some CPU",
                        .threads = 12,
                        .gpu = "Some GPU",
                        .psplit = "9.8.7",
                        .draco = "1.2.3",
                        .meshoptimizer = "0.99",
                        .zstd = "4.5.6",
                        .compiler = "cc 3",
                        .command_line = "gltf-psplit compare dragon.ply",
                        .date = "2026-01-02 03:04"};
  Comparison& comparison = report.comparison;
  comparison.faces = 100000;
  comparison.points = 50000;
  const auto timing = [](double ms) { return Timing{ms, ms * 0.875, ms * 1.125}; };
  comparison.stock_speeds = {
      {0, 190001, 301, timing(31.25)}, {5, 200002, 202, timing(20.5)}, {10, 210003, 103, timing(10.75)}};
  comparison.stock = comparison.stock_speeds[1];
  comparison.meshopt = {300004, timing(3.25)};
  comparison.meshopt_plain = {400005, timing(2.25)};
  for (const uint64_t patches : {3u, 40u, 500u, 6000u}) {
    SplitRow& row = comparison.splits.emplace_back();
    row.rule.patches = patches;
    row.summary = {.patches = patches,
                   .faces = 100000,
                   .points = 50000,
                   .references = 11 * patches,
                   .largest_patch_faces = 100000 / patches + 5,
                   .patch_faces = 100000,
                   .payload_bytes = 205006 + patches,
                   .directory_bytes = 100 + patches,
                   .stitch_bytes = 1000 + patches,
                   .total_bytes = 206106 + 3 * patches};
    row.overhead = static_cast<double>(row.summary.total_bytes) / 200002 - 1;
    for (const int threads : {1, 12})
      for (const std::string backend : {"cuda", "cpu", "draco"}) {
        const double ms =
            5 + static_cast<double>(patches) / 1000 + threads + static_cast<double>(backend.size());
        row.decode.push_back({backend, threads, timing(ms), 20.5 / ms});
      }
    for (const std::string stage : {"connectivity", "seams", "traversal and symbols", "prediction", "output"})
      row.stages.push_back(
          {stage, timing(static_cast<double>(stage.size()) + static_cast<double>(patches) / 7000)});
  }
  report.picture = {{'P', 'N', 'G'}, 40};
  return report;
}

TEST(HtmlText, EscapesWhateverHtmlReadsSomethingIn) {
  EXPECT_EQ(escape_html("<b a=\"1\" c='2'>&\x01\x7f\n\xc3\xa4"),
            "&lt;b a=&quot;1&quot; c=&#39;2&#39;&gt;&amp;\xef\xbf\xbd\xef\xbf\xbd\n\xc3\xa4");
  EXPECT_EQ(html_element("td", "<", "class=\"x\""), "<td class=\"x\">&lt;</td>");
}

TEST(HtmlText, EncodesBase64AsTheRfcDoes) {
  const std::map<std::string, std::string> expected{{"", ""},
                                                    {"f", "Zg=="},
                                                    {"fo", "Zm8="},
                                                    {"foo", "Zm9v"},
                                                    {"foob", "Zm9vYg=="},
                                                    {"fooba", "Zm9vYmE="},
                                                    {"\xff\xfe\xfd", "//79"}};
  for (const auto& [text, encoded] : expected)
    EXPECT_EQ(base64({reinterpret_cast<const uint8_t*>(text.data()), text.size()}), encoded);
}

TEST(HtmlReport, ShowsEveryRowInTablesAndCharts) {
  const ComparisonReport report = sample_report();
  const std::string page = to_html(report);
  const auto& [speeds, splits] = std::tie(report.comparison.stock_speeds, report.comparison.splits);
  const size_t decoder_count = 6, split_count = splits.size();

  const std::string codecs = part_of(page, "<table id=\"codecs\"", "</table>");
  EXPECT_EQ(count_of(codecs, "<tr>"), 1 + speeds.size() + 2 + split_count * decoder_count);
  const std::string sizes = part_of(page, "<table id=\"sizes\"", "</table>");
  EXPECT_EQ(count_of(sizes, "<tr>"), 1 + speeds.size() + split_count);
  const std::string stages = part_of(page, "<table id=\"stage-times\"", "</table>");
  EXPECT_EQ(count_of(stages, "<tr>"), 1 + split_count);
  const auto has_cell = [](const std::string& table, const std::string& cell) {
    return table.find(">" + cell + "</td>") != std::string::npos;
  };
  for (const StockRow& row : speeds) {
    EXPECT_TRUE(has_cell(codecs, with_separators(row.bytes))) << row.bytes;
    EXPECT_TRUE(has_cell(codecs, with_decimals(row.decode.median_ms, 2)));
    EXPECT_TRUE(has_cell(sizes, with_decimals(row.encode_ms, 0)));
  }
  EXPECT_TRUE(has_cell(codecs, "300,004"));
  EXPECT_TRUE(has_cell(codecs, "400,005"));
  for (const SplitRow& row : splits) {
    EXPECT_TRUE(has_cell(sizes, with_separators(row.summary.payload_bytes)));
    EXPECT_TRUE(has_cell(sizes, with_separators(row.summary.stitch_bytes)));
    EXPECT_TRUE(has_cell(sizes, as_share(row.summary.replication())));
    for (const DecodeRow& decode : row.decode) {
      EXPECT_TRUE(has_cell(codecs, with_decimals(decode.timing.median_ms, 2))) << decode.timing.median_ms;
      EXPECT_TRUE(has_cell(codecs, with_decimals(decode.speedup, 2)));
    }
    for (const StageRow& stage : row.stages)
      EXPECT_NE(stages.find(">" + with_decimals(stage.timing.median_ms, 2) + " ("), std::string::npos);
  }

  const std::map<std::string, size_t> marks{{"size-speed", speeds.size() + 2 + split_count * decoder_count},
                                            {"speed-up", split_count * decoder_count},
                                            {"patch-size", split_count + 4},
                                            {"size", 1 + 3 * split_count},
                                            {"stages", 5 * split_count},
                                            {"replication", split_count},
                                            {"balance", split_count}};
  EXPECT_EQ(count_of(page, "<figure class=\"chart\""), marks.size());
  for (const auto& [id, count] : marks) {
    const std::string chart = part_of(page, "id=\"" + id + "\"", "</figure>");
    EXPECT_EQ(count_of(chart, "class=\"mark"), count) << id;
    EXPECT_EQ(count_of(chart, "<title>"), count) << id;
    EXPECT_NE(chart.find("aria-label=\""), std::string::npos) << id;
  }
}

TEST(HtmlReport, SaysWhatWasMeasuredAndWhere) {
  ComparisonReport report = sample_report();
  const std::string page = to_html(report);
  for (const char* what :
       {"<h1>dragon.ply:", "Some CPU, 12 threads", "Some GPU", "9.8.7", "1.2.3", "0.99", "4.5.6", "cc 3",
        "gltf-psplit compare dragon.ply", "2026-01-02 03:04 UTC", "100,000 triangles", "50,000 points",
        "positions 14", "7, after one untimed round", "in 40 patches"})
    EXPECT_NE(page.find(what), std::string::npos) << what;
  EXPECT_NE(page.find("src=\"data:image/png;base64,UE5H\""), std::string::npos);
  EXPECT_NE(page.find("it includes copying to the GPU and back."), std::string::npos);
  report.picture = {};
  report.environment.gpu.clear();
  for (SplitRow& row : report.comparison.splits)
    std::erase_if(row.decode, [](const DecodeRow& decode) { return decode.backend == "cuda"; });
  const std::string without = to_html(report);
  EXPECT_EQ(without.find("<img"), std::string::npos);
  EXPECT_NE(without.find("none that this build can use"), std::string::npos);
  EXPECT_EQ(without.find("cuda"), std::string::npos);
}

TEST(HtmlReport, BeginsWithWhatIsGainedAndWhatToTake) {
  ComparisonReport report = sample_report();
  for (SplitRow& row : report.comparison.splits)  // all but the first become slower
    std::erase_if(row.decode, [](const DecodeRow& decode) { return decode.threads > 1; });
  const ComparisonSummary summary =
      summarize_comparison(report.comparison, report.input, report.options.repeat);
  const std::string result = part_of(to_html(report), "<section id=\"result\">", "</section>");
  for (const std::string& sentence : {summary.headline, summary.recommendation, summary.rule})
    EXPECT_NE(result.find(">" + escape_html(sentence) + "</p>"), std::string::npos) << sentence;
  EXPECT_EQ(result.find("class=\"noise\""), std::string::npos);
  report.options.repeat = 1;
  const std::string noisy = part_of(to_html(report), "<section id=\"result\">", "</section>");
  EXPECT_NE(noisy.find("The times are not certain"), std::string::npos);
  EXPECT_NE(noisy.find("only once"), std::string::npos);
}

TEST(HtmlReport, ShowsTheWholeAssetWithItsTextures) {
  ComparisonReport report = sample_report();
  // A compressed input has no such section.
  EXPECT_EQ(to_html(report).find("The whole asset"), std::string::npos);
  report.asset = AssetParts{.meshes = 1'800'000, .textures = 2'000'000, .rest = 3000, .missing_images = 0};
  const std::string page = to_html(report), table = part_of(page, "<table id=\"asset\"", "</table>");
  for (const char* cell : {"1,800,000", "200,002", "3,803,000", "2,203,002", "57.9 %"})
    EXPECT_NE(table.find(">" + std::string(cell) + "</td>"), std::string::npos) << cell;
  EXPECT_EQ(count_of(table, ">2,000,000</td>"), 3u);
  EXPECT_EQ(page.find("not found"), std::string::npos);
  report.asset->missing_images = 2;
  EXPECT_NE(to_html(report).find("2 images are not found, and not counted"), std::string::npos);
}

TEST(HtmlReport, NamesMeshoptimizersVersionInItsRows) {
  const std::string codecs = part_of(to_html(sample_report()), "<table id=\"codecs\"", "</table>");
  EXPECT_NE(codecs.find(">meshoptimizer 0.99<"), std::string::npos);
  EXPECT_NE(codecs.find(">meshoptimizer 0.99 and zstd<"), std::string::npos);
}

TEST(HtmlReport, NeedsNoNetworkAndRunsNothing) {
  const std::string page = to_html(sample_report());
  EXPECT_EQ(page.find("://"), std::string::npos);
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_EQ(page.find("url("), std::string::npos);
  EXPECT_EQ(page.find("@import"), std::string::npos);
  EXPECT_EQ(count_of(page, "src="), 1u);   // the picture
  EXPECT_EQ(count_of(page, "href="), 1u);  // an empty icon, which browsers would otherwise request
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
}

TEST(HtmlReport, EscapesWhatFilesAndMachinesSay) {
  ComparisonReport report = sample_report();
  const std::string evil = "<script>alert(\"1\")<script>' onload='x' &amp;";
  report.input = report.environment.cpu = report.environment.gpu = report.environment.command_line =
      report.environment.compiler = evil;
  for (std::string* version :
       {&report.environment.psplit, &report.environment.draco, &report.environment.meshoptimizer,
        &report.environment.zstd, &report.environment.date})
    *version = evil;
  report.comparison.splits[0].decode[0].backend = evil;
  report.comparison.splits[0].stages[0].name = evil;
  const std::string page = to_html(report);
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_EQ(page.find("' onload"), std::string::npos);
  EXPECT_GE(
      count_of(page, "&lt;script&gt;alert(&quot;1&quot;)&lt;script&gt;&#39; onload=&#39;x&#39; &amp;amp;"),
      13u);
}

TEST(HtmlReport, DrawsEveryMarkOfNumbersThatNoAxisHas) {
  ComparisonReport report = sample_report();
  report.comparison.points = 0;
  for (SplitRow& row : report.comparison.splits) {
    row.summary = {};
    for (DecodeRow& decode : row.decode) decode = {decode.backend, decode.threads, {0, 0, 0}, 1.0 / 0.0};
    for (StageRow& stage : row.stages) stage.timing = {};
  }
  const std::string page = to_html(report);
  EXPECT_EQ(page.find("nan"), std::string::npos);
  EXPECT_EQ(page.find("\"-\""), std::string::npos);  // with_decimals of a number that is not finite
  EXPECT_EQ(count_of(part_of(page, "id=\"speed-up\"", "</figure>"), "class=\"mark"), 24u);

  report.comparison.splits.clear();
  const std::string empty = to_html(report);
  EXPECT_EQ(count_of(part_of(empty, "id=\"size-speed\"", "</figure>"), "class=\"mark"), 5u);
}

TEST(SvgChart, NamesTheLineThatItRefersTo) {
  const std::string page = to_html(sample_report());
  for (const char* id : {"speed-up", "patch-size", "size"}) {
    const std::string chart = part_of(page, "id=\"" + std::string(id) + "\"", "</figure>");
    EXPECT_EQ(count_of(chart, "class=\"reference\""), 2u) << id;  // in the chart and in its legend
    EXPECT_NE(chart.find("</svg>stock Draco, speed 5</li>"), std::string::npos) << id;
  }
}

TEST(SvgChart, TakesRoundingForNoRange) {
  XyChart chart;
  chart.series.resize(1);
  for (const double value : {1.0, 1 + 2.3e-16, 1 + 1e-12, 1e-300, 0.0}) {
    chart.y.start = value < 1 ? 0 : 1;
    chart.series[0].points.resize(1);
    chart.series[0].points[0].x = chart.series[0].points[0].y = value;
    const std::string svg = draw_chart(chart);
    EXPECT_EQ(count_of(svg, "class=\"mark\""), 1u) << value;
    EXPECT_LT(count_of(svg, "class=\"grid\""), 20u) << value;
  }
}

TEST(SvgChart, ScalesBothAxes) {
  XyChart chart{"id",        "title", "",
                {"x", true}, {"y"},   {{"series", 0, true, {{1, 0, "", "a"}, {100, 8, "", "b"}}}}};
  const std::string svg = draw_chart(chart);
  // The two ends of the line: values grow to the right and upwards.
  double x1 = 0, y1 = 0, x2 = 0, y2 = 0;
  ASSERT_EQ(
      std::sscanf(part_of(svg, "points=\"", "\"/>").c_str(), "points=\"%lf,%lf %lf,%lf", &x1, &y1, &x2, &y2),
      4);
  EXPECT_LT(x1, x2);
  EXPECT_GT(y1, y2);
  for (const char* tick : {">1<", ">2<", ">5<", ">10<", ">20<", ">50<", ">100<", ">0<", ">4<", ">8<"})
    EXPECT_NE(svg.find(tick), std::string::npos) << tick;
}

}  // namespace
}  // namespace psplit
