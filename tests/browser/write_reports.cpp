// Writes pages of `gltf-psplit compare` with random times for report_test.mjs:
//
//   write_reports FOLDER SEED INPUT THREADS PATCHES...
//
// Measured times differ from run to run, and so do pages: which marks are near each other, which times are
// noisy, how many digits a number has. Times from a seed reproduce a failure. The page is FOLDER/SEED.html.
// INPUT is the name of the file in it.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "tools/gltf_psplit/compare/comparison_report.h"
#include "tools/gltf_psplit/page/html_report.h"
#include "tools/gltf_psplit/preview/picture.h"

namespace psplit {
namespace {

class RandomReport {
 public:
  RandomReport(uint64_t seed, const std::string& input, int threads, std::span<const uint64_t> patch_counts)
      : random_(seed) {
    report_.input = input;
    report_.comparison.rounds = 5;
    report_.environment = {.cpu = "AMD EPYC 9R14 96-Core Processor",
                           .threads = threads,
                           .gpu = "",
                           .psplit = "1.2.3",
                           .draco = "1.5.5",
                           .meshoptimizer = "0.18",
                           .zstd = "1.5.4",
                           .brotli = "1.0.9",
                           .compiler = "GCC 12.2.0",
                           .command_line = "gltf-psplit compare mesh.glb --repeat 5 --format html",
                           .date = "2026-01-02 03:04"};
    Comparison& comparison = report_.comparison;
    const uint64_t most = *std::ranges::max_element(patch_counts);
    comparison.faces =
        static_cast<uint64_t>(static_cast<double>(std::max<uint64_t>(most, 40)) * scaled(1, 2000));
    comparison.points = comparison.faces / 2 + 2;
    const auto stock_bytes = static_cast<double>(comparison.faces) * scaled(0.5, 8);
    const double stock_ms = static_cast<double>(comparison.faces) * scaled(1e-4, 1e-2);
    for (const int speed : {0, 5, 10})
      comparison.stock_speeds.push_back(
          {speed, near(stock_bytes, 1.3), 1 + 10 * stock_ms, around(stock_ms, 2)});
    comparison.stock = comparison.stock_speeds[1];
    comparison.meshopt = {near(stock_bytes, 2), around(stock_ms / 10, 10)};
    comparison.meshopt_plain = {2 * comparison.meshopt.bytes, around(stock_ms / 20, 10)};
    comparison.meshopt_brotli = {near(stock_bytes, 2), around(stock_ms / 8, 10)};
    for (const uint64_t patches : patch_counts) add_split(patches, threads, stock_bytes, stock_ms);
    report_.asset = {
        .meshes = 36 * comparison.faces, .textures = near(1e5, 100), .rest = 2345, .missing_images = 0};
    Image image{{1200, 900}, {}};
    image.rgba.resize(size_t{4} * 1200 * 900, 128);
    report_.picture = {encode_png(image).value(), patch_counts.front()};
  }

  const ComparisonReport& report() const { return report_; }

 private:
  void add_split(uint64_t patches, int threads, double stock_bytes, double stock_ms) {
    SplitRow& row = report_.comparison.splits.emplace_back();
    const uint64_t faces = report_.comparison.faces, payload = near(stock_bytes, 1.2);
    row.rule.patches = patches;
    row.summary = {.patches = patches,
                   .faces = faces,
                   .points = report_.comparison.points,
                   .references = patches > 1 ? near(30 * static_cast<double>(patches), 2) : 0,
                   .largest_patch_faces = faces / patches + patches % 7,
                   .patch_faces = faces,
                   .payload_bytes = payload,
                   .directory_bytes = 20 + 8 * patches,
                   .stitch_bytes = 40 * (patches - 1),
                   .total_bytes = payload + 20 + 48 * patches - 40};
    row.overhead =
        static_cast<double>(row.summary.total_bytes) / static_cast<double>(report_.comparison.stock.bytes) - 1;
    row.partition_ms = scaled(0.1, 100);
    row.encode_ms = row.partition_ms + scaled(0.1, 1000);
    for (const std::string backend : {"cpu", "draco"})
      for (int count = 1; count <= threads; count += threads - 1) {
        const Timing timing = around((backend == "cpu" ? stock_ms / 3 : stock_ms) / count, 2);
        row.decode.push_back(
            {backend, count, timing, report_.comparison.stock.decode.median_ms / timing.median_ms});
        if (threads == 1) break;
      }
    for (const char* stage : {"connectivity", "seams", "traversal and symbols", "prediction", "output"})
      row.stages.push_back({stage, around(stock_ms / 15, 4)});
  }

  double scaled(double low, double high) {
    return std::exp(std::uniform_real_distribution(std::log(low), std::log(high))(random_));
  }
  uint64_t near(double value, double factor) {
    return static_cast<uint64_t>(std::max(1.0, value * scaled(1 / factor, factor)));
  }
  // Every fourth time is of a machine that does something else.
  Timing around(double ms, double factor) {
    const double median = ms * scaled(1 / factor, factor), spread = random_() % 4 == 0 ? 4 : 1.1;
    Timing timing{median, median / scaled(1, spread), median * scaled(1, spread), 0, 0};
    timing.lower_quartile_ms = (median + timing.min_ms) / 2;
    timing.upper_quartile_ms = (median + timing.max_ms) / 2;
    return timing;
  }

  std::mt19937_64 random_;
  ComparisonReport report_;
};

}  // namespace
}  // namespace psplit

int main(int argc, char** argv) {
  if (argc < 6) return std::fputs("usage: write_reports FOLDER SEED INPUT THREADS PATCHES...\n", stderr), 1;
  std::vector<uint64_t> patch_counts;
  for (int i = 5; i < argc; ++i) patch_counts.push_back(std::stoull(argv[i]));
  const psplit::RandomReport random(std::stoull(argv[2]), argv[3], std::stoi(argv[4]), patch_counts);
  const std::filesystem::path file = std::filesystem::path(argv[1]) / (std::string(argv[2]) + ".html");
  return std::ofstream(file, std::ios::binary) << psplit::to_html(random.report()) ? 0 : 1;
}
