#include "tools/gltf_psplit/page/html_report.h"

#include <array>
#include <cmath>
#include <map>
#include <set>

#include "tests/support/expect.h"
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
  report.comparison.rounds = 7;
  report.environment = {.cpu = "Some CPU",
                        .threads = 12,
                        .gpu = "Some GPU",
                        .psplit = "9.8.7",
                        .draco = "1.2.3",
                        .meshoptimizer = "0.99",
                        .zstd = "4.5.6",
                        .brotli = "7.8.9",
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
  comparison.meshopt_brotli = {290006, timing(5.25)};
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
  EXPECT_EQ(count_of(codecs, "<tr>"), 1 + speeds.size() + 3 + split_count * decoder_count);
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
  EXPECT_TRUE(has_cell(codecs, "290,006"));
  for (const SplitRow& row : splits) {
    EXPECT_TRUE(has_cell(sizes, with_separators(row.summary.payload_bytes)));
    EXPECT_TRUE(has_cell(sizes, with_separators(row.summary.stitch_bytes)));
    EXPECT_TRUE(has_cell(sizes, as_share(row.summary.replication())));
    for (const DecodeRow& decode : row.decode) {
      EXPECT_TRUE(has_cell(codecs, with_decimals(decode.timing.median_ms, 2))) << decode.timing.median_ms;
      EXPECT_TRUE(has_cell(codecs, with_decimals(decode.speedup, 2)));
    }
    for (const StageRow& stage : row.stages)
      EXPECT_TRUE(contains(stages, ">" + with_decimals(stage.timing.median_ms, 2) + " ("));
  }

  // The chart of size against speed leaves out libdraco on patches. Each chart is drawn twice.
  const std::map<std::string, size_t> marks{{"size-speed", speeds.size() + 2 + split_count * 4},
                                            {"speed-up", split_count * decoder_count},
                                            {"patch-size", split_count + 4},
                                            {"size", 1 + 3 * split_count},
                                            {"stages", 5 * split_count},
                                            {"replication", split_count},
                                            {"balance", split_count}};
  EXPECT_EQ(count_of(page, "<figure class=\"chart\""), marks.size());
  for (const auto& [id, count] : marks) {
    const std::string chart = part_of(page, "id=\"" + id + "\"", "</figure>");
    for (const char* drawing : {"<svg class=\"wide\"", "<svg class=\"narrow\""}) {
      const std::string svg = part_of(chart, drawing, "</svg>");
      EXPECT_EQ(count_of(svg, "class=\"mark"), count) << id;
      EXPECT_EQ(count_of(svg, "<title>"), count) << id;
      EXPECT_TRUE(contains(svg, "aria-label=\"")) << id;
    }
  }
}

TEST(HtmlReport, SaysWhatWasMeasuredAndWhere) {
  ComparisonReport report = sample_report();
  const std::string page = to_html(report);
  for (const char* what :
       {"<h1>dragon.ply:", "Some CPU, 12 threads", "Some GPU", "9.8.7", "1.2.3", "0.99", "4.5.6", "cc 3",
        "gltf-psplit compare dragon.ply", "2026-01-02 03:04 UTC", "100,000 triangles", "50,000 points",
        "positions 14", "7, after one untimed round", "in 40 patches"})
    EXPECT_TRUE(contains(page, what)) << what;
  EXPECT_TRUE(contains(page, "src=\"data:image/png;base64,UE5H\""));
  EXPECT_TRUE(contains(page, "it includes copying to the GPU and back."));
  report.picture = {};
  report.environment.gpu.clear();
  for (SplitRow& row : report.comparison.splits)
    std::erase_if(row.decode, [](const DecodeRow& decode) { return decode.backend == "cuda"; });
  const std::string without = to_html(report);
  EXPECT_FALSE(contains(without, "<img"));
  EXPECT_TRUE(contains(without, "none that this build can use"));
  EXPECT_FALSE(contains(without, "cuda"));
}

TEST(HtmlReport, BeginsWithWhatIsGainedAndWhatToTake) {
  ComparisonReport report = sample_report();
  for (SplitRow& row : report.comparison.splits)  // all but the first become slower
    std::erase_if(row.decode, [](const DecodeRow& decode) { return decode.threads > 1; });
  const ComparisonSummary summary = summarize(report);
  EXPECT_TRUE(contains(summary.headline, "meshoptimizer 0.99 with zstd decodes"));
  const std::string result = part_of(to_html(report), "<section id=\"result\">", "</section>");
  for (const std::string& sentence : {summary.headline, summary.recommendation, summary.rule})
    EXPECT_TRUE(contains(result, ">" + escape_html(sentence) + "</p>")) << sentence;
  EXPECT_FALSE(contains(result, "class=\"noise\""));
  report.comparison.rounds = 1;
  const std::string noisy = part_of(to_html(report), "<section id=\"result\">", "</section>");
  EXPECT_TRUE(contains(noisy, "The times are not certain"));
  EXPECT_TRUE(contains(noisy, "only once"));
}

TEST(HtmlReport, ShowsTheWholeAssetWithItsTextures) {
  ComparisonReport report = sample_report();
  // A compressed input has no such section.
  EXPECT_FALSE(contains(to_html(report), "The whole asset"));
  report.asset = AssetParts{.meshes = 1'800'000, .textures = 2'000'000, .rest = 3000, .missing_images = 0};
  const std::string page = to_html(report), table = part_of(page, "<table id=\"asset\"", "</table>");
  for (const char* cell : {"1,800,000", "200,002", "3,803,000", "2,203,002", "57.9 %"})
    EXPECT_TRUE(contains(table, ">" + std::string(cell) + "</td>")) << cell;
  EXPECT_EQ(count_of(table, ">2,000,000</td>"), 3u);
  EXPECT_FALSE(contains(page, "not found"));
  report.asset->missing_images = 2;
  EXPECT_TRUE(contains(to_html(report), "2 images are not found, and not counted"));
}

TEST(HtmlReport, NamesMeshoptimizersVersionInItsRows) {
  const std::string codecs = part_of(to_html(sample_report()), "<table id=\"codecs\"", "</table>");
  EXPECT_TRUE(contains(codecs, ">meshoptimizer 0.99<"));
  EXPECT_TRUE(contains(codecs, ">meshoptimizer 0.99 and zstd<"));
  EXPECT_TRUE(contains(codecs, ">meshoptimizer 0.99 and brotli<"));
  // An old codec makes larger files than a current one, so the page says that it is old.
  ComparisonReport report = sample_report();
  EXPECT_TRUE(
      contains(to_html(report), "the newest of release 0.99, which this build found. Releases from 0.23 on"));
  report.environment.meshopt_codec = 1;
  EXPECT_FALSE(contains(to_html(report), "the newest of release"));
}

TEST(HtmlReport, NeedsNoNetworkAndRunsNothing) {
  const std::string page = to_html(sample_report());
  EXPECT_FALSE(contains(page, "://"));
  EXPECT_FALSE(contains(page, "<script"));
  EXPECT_FALSE(contains(page, "url("));
  EXPECT_FALSE(contains(page, "@import"));
  EXPECT_EQ(count_of(page, "src="), 1u);   // the picture
  EXPECT_EQ(count_of(page, "href="), 2u);  // within the page, and an empty icon, which browsers would request
  EXPECT_TRUE(contains(page, "default-src 'none'"));
}

TEST(HtmlReport, EscapesWhatFilesAndMachinesSay) {
  ComparisonReport report = sample_report();
  const std::string evil = "<script>alert(\"1\")<script>' onload='x' &amp;";
  report.input = report.environment.cpu = report.environment.gpu = report.environment.command_line =
      report.environment.compiler = evil;
  for (std::string* version :
       {&report.environment.psplit, &report.environment.draco, &report.environment.meshoptimizer,
        &report.environment.zstd, &report.environment.brotli, &report.environment.date})
    *version = evil;
  report.comparison.splits[0].decode[0].backend = evil;
  report.comparison.splits[0].stages[0].name = evil;
  const std::string page = to_html(report);
  EXPECT_FALSE(contains(page, "<script"));
  EXPECT_FALSE(contains(page, "' onload"));
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
  EXPECT_FALSE(contains(page, "nan"));
  EXPECT_FALSE(contains(page, "\"-\""));  // with_decimals of a number that is not finite
  EXPECT_EQ(count_of(part_of(page, "id=\"speed-up\"", "</figure>"), "class=\"mark"), 2 * 24u);

  report.comparison.splits.clear();
  const std::string empty = to_html(report);
  EXPECT_EQ(count_of(part_of(empty, "id=\"size-speed\"", "</figure>"), "class=\"mark"), 2 * 5u);
}

// A drawing of a chart, read back. Letters are taken to be as wide as in a common wide font.
struct DrawnText {
  std::string kind, text;
  double left, top, right, bottom;
};
struct Drawn {
  double width = 0, height = 0;
  std::vector<DrawnText> texts;
  std::vector<std::pair<double, double>> marks;  // their centres
  std::vector<std::pair<double, double>> front;
};

double number_after(const std::string& text, const std::string& name) {
  const size_t at = text.find(" " + name + "=\"");
  return at == std::string::npos ? NAN : std::stod(text.substr(at + name.size() + 3));
}

Drawn read_drawing(const std::string& svg) {
  constexpr double kLetter = 7.6, kLetterHeight = 10;
  Drawn drawn{number_after(svg, "width"), number_after(svg, "height"), {}, {}, {}};
  for (size_t at = 0; (at = svg.find("<text", at)) != std::string::npos; ++at) {
    const std::string element = svg.substr(at, svg.find("</text>", at) - at);
    const std::string text = element.substr(element.find('>') + 1);
    const double width = kLetter * static_cast<double>(text.size()), x = number_after(element, "x"),
                 y = number_after(element, "y");
    const bool is_middle = element.find("\"middle\"") != std::string::npos;
    const double left = is_middle                                      ? x - width / 2
                        : element.find("\"end\"") != std::string::npos ? x - width
                                                                       : x;
    drawn.texts.push_back({part_of(element, "class=\"", ">"), text, left, y - kLetterHeight, left + width, y});
  }
  for (size_t at = 0; (at = svg.find("<path class=\"mark", at)) != std::string::npos; ++at) {
    double x = 0, y = 0;
    EXPECT_EQ(std::sscanf(svg.c_str() + svg.find(" d=\"", at), " d=\"M%lf %lf", &x, &y), 2);
    drawn.marks.emplace_back(x + 5, y);
  }
  const std::string front = part_of(part_of(svg, "<polyline class=\"front\"", "/>"), "points=\"", "/>");
  for (size_t at = front.find('"'); at != std::string::npos && at + 2 < front.size();
       at = front.find(' ', at + 1)) {
    double x = 0, y = 0;
    if (std::sscanf(front.c_str() + at + 1, "%lf,%lf", &x, &y) == 2) drawn.front.emplace_back(x, y);
  }
  return drawn;
}

std::vector<Drawn> drawings_of(const std::string& page, const std::string& id) {
  const std::string chart = part_of(page, "id=\"" + id + "\"", "</figure>");
  return {read_drawing(part_of(chart, "<svg class=\"wide\"", "</svg>")),
          read_drawing(part_of(chart, "<svg class=\"narrow\"", "</svg>"))};
}

// A scan in 1, 32, 182 and 726 patches, and rivals that are far away.
ComparisonReport scan_report() {
  ComparisonReport report = sample_report();
  Comparison& comparison = report.comparison;
  const auto timing = [](double ms) { return Timing{ms, ms * 0.9, ms * 1.2, ms * 0.98, ms * 1.02}; };
  comparison.faces = 871306;
  comparison.points = 435545;
  comparison.stock_speeds = {
      {0, 967112, 1040, timing(169)}, {5, 1153605, 532, timing(58.4)}, {10, 1125558, 428, timing(53.6)}};
  comparison.stock = comparison.stock_speeds[1];
  comparison.meshopt = {1507564, timing(9.8)};
  comparison.meshopt_plain = {2477935, timing(7.2)};
  struct Cut {
    uint64_t patches, bytes;
    double one, two, draco_one, draco_two;
  };
  comparison.splits.clear();
  for (const auto& [patches, bytes, one, two, draco_one, draco_two] :
       {Cut{1, 1153657, 25.3, 25, 64.6, 64.3},
        {32, 1169514, 22.8, 12.8, 87.4, 47.6},
        {182, 1232714, 21.3, 12, 89.3, 49.6},
        {726, 1389270, 23.6, 13.6, 93.2, 52.6}}) {
    SplitRow& row = comparison.splits.emplace_back();
    row.rule.patches = patches;
    row.summary = {.patches = patches,
                   .faces = 871306,
                   .points = 435545,
                   .references = 40 * patches,
                   .largest_patch_faces = 900000 / patches,
                   .patch_faces = 871306,
                   .payload_bytes = bytes - 2000,
                   .directory_bytes = 500,
                   .stitch_bytes = 1500,
                   .total_bytes = bytes};
    row.overhead = static_cast<double>(bytes) / 1153605 - 1;
    const auto add = [&](const char* backend, int threads, double ms) {
      row.decode.push_back({backend, threads, timing(ms), 58.4 / ms});
    };
    add("cpu", 1, one);
    add("cpu", 2, two);
    add("draco", 1, draco_one);
    add("draco", 2, draco_two);
    for (const char* stage : {"connectivity", "seams", "traversal and symbols", "prediction", "output"})
      row.stages.push_back({stage, timing(one / 5)});
  }
  return report;
}

constexpr const char* kCharts[] = {"size-speed", "speed-up",    "patch-size", "size",
                                   "stages",     "replication", "balance"};

TEST(SvgChart, KeepsTextInsideAndApart) {
  for (const ComparisonReport& report : {sample_report(), scan_report()}) {
    const std::string page = to_html(report);
    for (const std::string id : kCharts)
      for (const Drawn& drawn : drawings_of(page, id)) {
        EXPECT_GT(drawn.texts.size(), 5u) << id;
        for (size_t i = 0; i < drawn.texts.size(); ++i) {
          const DrawnText& a = drawn.texts[i];
          EXPECT_TRUE(a.left >= 0 && a.right <= drawn.width && a.top >= 0 && a.bottom <= drawn.height)
              << id << ": " << a.text << " leaves the chart of width " << drawn.width;
          for (size_t k = i + 1; k < drawn.texts.size(); ++k) {
            const DrawnText& b = drawn.texts[k];
            EXPECT_FALSE(a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom)
                << id << ": " << a.text << " hides " << b.text;
          }
          if (a.kind.find("tag") == std::string::npos) continue;
          for (const auto& [x, y] : drawn.marks)
            EXPECT_FALSE(a.left < x + 4 && x - 4 < a.right && a.top < y + 4 && y - 4 < a.bottom)
                << id << ": " << a.text << " hides a mark";
        }
      }
  }
}

TEST(SvgChart, UsesTheWholeHeightForSizeAgainstSpeed) {
  for (const ComparisonReport& report : {sample_report(), scan_report()})
    for (const Drawn& drawn : drawings_of(to_html(report), "size-speed")) {
      double left = HUGE_VAL, right = 0, top = HUGE_VAL, bottom = 0;
      for (const auto& [x, y] : drawn.marks) {
        left = std::min(left, x);
        right = std::max(right, x);
        top = std::min(top, y);
        bottom = std::max(bottom, y);
      }
      // The axes begin at the data: axes, labels and some room take the rest.
      EXPECT_GT(right - left, 0.7 * drawn.width);
      EXPECT_GT(bottom - top, 0.55 * drawn.height);
    }
}

TEST(SvgChart, KeepsTotalsOffTheReference) {
  BarChart chart{"id", "t", "", "kB", "kB", {"part"}, {}, ChartReference{10, "base"}};
  for (const double value : {4, 9, 10, 12}) chart.bars.push_back({"a bar", {value}, "+1.5 %"});
  const std::string svg = part_of(draw_chart(chart), "<svg class=\"wide\"", "</svg>");
  const double at = number_after(svg.substr(svg.rfind("<line")), "x1");  // the reference is drawn last
  size_t count = 0;
  for (const DrawnText& text : read_drawing(svg).texts)
    if (text.text == "+1.5 %") {
      ++count;
      EXPECT_TRUE(text.right < at || text.left > at) << text.left << " to " << text.right << " around " << at;
    }
  EXPECT_EQ(count, 4u);
}

TEST(SvgChart, NamesTheFewMarksThatMatter) {
  for (const Drawn& drawn : drawings_of(to_html(scan_report()), "size-speed")) {
    std::set<std::string> tags;
    for (const DrawnText& text : drawn.texts)
      if (text.kind.find("tag") != std::string::npos) {
        EXPECT_TRUE(tags.insert(text.text).second) << text.text;
      }
    for (const char* tag : {"speed 0", "32 patches", "meshopt + zstd", "meshopt"})
      EXPECT_TRUE(tags.contains(tag)) << tag << " in a chart of width " << drawn.width;
    EXPECT_TRUE(tags.contains("182 patches") || drawn.width < 500);
    EXPECT_LE(tags.size(), 9u);  // 13 marks
  }
}

TEST(SvgChart, DrawsTheBorderOfWhatIsBeaten) {
  XyChart chart{"id", "t", "", {"x"}, {"y"}, {}, {}, "front"};
  //  slow and small; beaten by the next; faster; beaten in both; as fast and larger; fastest
  chart.series.push_back({"a", {}, {{1, 1, "", "a"}, {2, 3, "", "b"}, {3, 2, "", "c"}}});
  chart.series.push_back({"b", {1, 1, false, false}, {{2.5, 5, "", "d"}, {3, 4, "", "e"}, {9, 8, "", "f"}}});
  std::string titles;
  for (const ChartPoint* point : front_of(chart)) titles += point->title;
  EXPECT_EQ(titles, "acf");
  const std::string svg = draw_chart(chart);
  const Drawn drawn = read_drawing(part_of(svg, "<svg class=\"wide\"", "</svg>"));
  ASSERT_EQ(drawn.front.size(), 7u);  // two for each point, and the way up
  for (const auto& [corner, mark] : std::vector<std::pair<size_t, size_t>>{{1, 0}, {3, 2}, {5, 5}}) {
    EXPECT_NEAR(drawn.front[corner].first, drawn.marks[mark].first, 1);
    EXPECT_EQ(drawn.front[corner].second, drawn.marks[mark].second);
  }
  EXPECT_TRUE(contains(svg, "</svg>front</li>"));
  chart.front.clear();
  EXPECT_FALSE(contains(draw_chart(chart), "class=\"front\""));
}

// The colours of the page as red, green and blue, linear; one list for each scheme.
std::vector<std::vector<std::array<double, 3>>> page_colors(const std::string& page) {
  std::vector<std::vector<std::array<double, 3>>> schemes(2);
  for (size_t i = 0; i < kChartColors; ++i) {
    const std::string rule = ".s" + std::to_string(i) + " { --c: #";
    size_t at = 0;
    for (auto& scheme : schemes) {
      at = page.find(rule, at) + rule.size();
      const unsigned long value = std::stoul(page.substr(at, 6), nullptr, 16);
      std::array<double, 3>& color = scheme.emplace_back();
      for (size_t k = 0; k < 3; ++k) {
        const double part = static_cast<double>(value >> (16 - 8 * k) & 255) / 255;
        color[k] = part <= 0.04045 ? part / 12.92 : std::pow((part + 0.055) / 1.055, 2.4);
      }
    }
  }
  return schemes;
}

// CIE Lab.
std::array<double, 3> lab_of(const std::array<double, 3>& rgb) {
  const auto root = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; };
  const double x = root((0.4124 * rgb[0] + 0.3576 * rgb[1] + 0.1805 * rgb[2]) / 0.9505);
  const double y = root(0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]);
  const double z = root((0.0193 * rgb[0] + 0.1192 * rgb[1] + 0.9505 * rgb[2]) / 1.089);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

TEST(SvgChart, HasColorsThatColorBlindReadersTellApart) {
  // What eyes without one kind of cones see (Machado, Oliveira and Fernandes 2009).
  constexpr double kEyes[][9] = {
      {1, 0, 0, 0, 1, 0, 0, 0, 1},
      {0.152286, 1.052583, -0.204868, 0.114503, 0.786281, 0.099216, -0.003882, -0.048116, 1.051998},
      {0.367322, 0.860646, -0.227968, 0.280085, 0.672501, 0.047413, -0.011820, 0.042940, 0.968881},
      {1.255528, -0.076749, -0.178779, -0.078411, 0.930809, 0.147602, 0.004733, 0.691367, 0.303900}};
  for (const auto& colors : page_colors(to_html(sample_report())))
    for (const auto& eye : kEyes) {
      std::vector<std::array<double, 3>> seen;
      for (const auto& color : colors) {
        std::array<double, 3> rgb{};
        for (size_t k = 0; k < 9; ++k) rgb[k / 3] += eye[k] * color[k % 3];
        for (double& part : rgb) part = std::clamp(part, 0.0, 1.0);
        seen.push_back(lab_of(rgb));
      }
      for (size_t a = 0; a < seen.size(); ++a)
        for (size_t b = a + 1; b < seen.size(); ++b)
          EXPECT_GT(std::hypot(seen[a][0] - seen[b][0], seen[a][1] - seen[b][1], seen[a][2] - seen[b][2]), 20)
              << a << " and " << b;
    }
}

TEST(SvgChart, HasAStyleOfItsOwnForEverySeries) {
  ComparisonReport report = sample_report();
  for (size_t i = 0; i < 4; ++i) {
    report.comparison.splits.push_back(report.comparison.splits[i]);
    report.comparison.splits.back().rule.condense = true;
  }
  const std::string page = to_html(report);
  for (const char* id : {"size-speed", "speed-up", "patch-size"}) {
    const std::string legend =
        part_of(part_of(page, "id=\"" + std::string(id) + "\"", "</figure>"), "<ul", "</ul>");
    std::set<std::string> styles;
    for (size_t at = 0; (at = legend.find("<path class=\"key", at)) != std::string::npos; ++at)
      EXPECT_TRUE(styles.insert(legend.substr(at, legend.find("/>", at) - at)).second) << id << ": " << legend;
    EXPECT_GE(styles.size(), 4u);
  }
}

TEST(HtmlReport, MarksNoisyTimes) {
  ComparisonReport report = scan_report();
  const std::string still = to_html(report);
  for (const char* sign : {"class=\"ring\"", " noisy\"", ">about ", ">~"})
    EXPECT_FALSE(contains(still, sign)) << sign;
  SplitRow& row = report.comparison.splits[1];
  row.decode[1].timing = {12.8, 9, 30, 11, 15};
  for (StageRow& stage : row.stages) stage.timing = {4, 3, 9, 3.5, 4.5};
  const std::string page = to_html(report);
  for (const char* id : {"size-speed", "speed-up"}) {
    const std::string chart = part_of(page, "id=\"" + std::string(id) + "\"", "</figure>");
    EXPECT_EQ(count_of(chart, "class=\"ring\""), 3u) << id;  // in two drawings and in the legend
    EXPECT_TRUE(contains(chart, "half of the rounds differ by over 20 %</li>")) << id;
  }
  const std::string stages = part_of(page, "id=\"stages\"", "</figure>");
  EXPECT_EQ(count_of(stages, " noisy\""), 2 * 5u);
  EXPECT_EQ(count_of(stages, ">about 20.00 ms<"), 2u);
  EXPECT_TRUE(contains(page, ">~12.80</td>"));
  EXPECT_TRUE(contains(page, "about 4.6 times (3.8 to 5.4) as fast"));
}

TEST(HtmlReport, BeginsWithResultsAndEndsWithWords) {
  ComparisonReport report = sample_report();
  report.asset = AssetParts{.meshes = 1'800'000, .textures = 2'000'000, .rest = 3000, .missing_images = 0};
  const std::string page = to_html(report);
  size_t last = 0;
  for (const char* part : {"class=\"headline\"", "id=\"size-speed\"", "<table id=\"asset\"", "id=\"charts\"",
                           "id=\"numbers\"", "id=\"setting\"", "class=\"method\"", "id=\"words\""}) {
    const size_t at = page.find(part);
    ASSERT_NE(at, std::string::npos) << part;
    EXPECT_GT(at, last) << part;
    last = at;
  }
  EXPECT_TRUE(contains(page, "href=\"#words\""));
}

TEST(SvgChart, NamesTheLineThatItRefersTo) {
  const std::string page = to_html(sample_report());
  for (const char* id : {"speed-up", "patch-size", "size"}) {
    const std::string chart = part_of(page, "id=\"" + std::string(id) + "\"", "</figure>");
    EXPECT_EQ(count_of(chart, "class=\"reference\""), 3u) << id;  // in two drawings and in the legend
    EXPECT_TRUE(contains(chart, "</svg>stock Draco, speed 5</li>")) << id;
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
    EXPECT_EQ(count_of(svg, "class=\"mark s0\""), 2u) << value;
    EXPECT_LT(count_of(svg, "class=\"grid\""), 40u) << value;
  }
}

TEST(SvgChart, ScalesBothAxes) {
  XyChart chart{"id", "title", "", {"x", true}, {"y"}, {{"series", {}, {{1, 0, "", "a"}, {100, 8, "", "b"}}}}};
  const std::string svg = draw_chart(chart);
  // The two ends of the line: values grow to the right and upwards.
  double x1 = 0, y1 = 0, x2 = 0, y2 = 0;
  ASSERT_EQ(
      std::sscanf(part_of(svg, "points=\"", "\"/>").c_str(), "points=\"%lf,%lf %lf,%lf", &x1, &y1, &x2, &y2),
      4);
  EXPECT_LT(x1, x2);
  EXPECT_GT(y1, y2);
  for (const char* tick : {">1<", ">2<", ">5<", ">10<", ">20<", ">50<", ">100<", ">0<", ">4<", ">8<"})
    EXPECT_TRUE(contains(svg, tick)) << tick;
}

}  // namespace
}  // namespace psplit
