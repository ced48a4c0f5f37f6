#include "tools/gltf_psplit/page/html_report.h"

#include <algorithm>

#include "tools/gltf_psplit/page/html_style.h"
#include "tools/gltf_psplit/page/html_text.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

std::string paragraph(const std::string& text, const std::string& attributes = "") {
  return html_element("p", text, attributes) + "\n";
}

std::string result(const ComparisonFigures& figures, const ComparisonSummary& summary) {
  std::string html = "<section id=\"result\">\n";
  if (summary.has_recommendation)
    html += paragraph(summary.headline, "class=\"headline\"") + paragraph(summary.recommendation);
  if (!summary.rule.empty()) html += paragraph(summary.rule, "class=\"rule\"");
  html += chart_of_size_and_speed(figures);
  if (!summary.noise.empty()) {
    html += "<div class=\"noise\">\n<h2>The times are not certain</h2>\n";
    for (const std::string& note : summary.noise) html += paragraph(note);
    html += "</div>\n";
  }
  return html + "</section>\n";
}

bool has_cuda(const ComparisonFigures& figures) {
  return std::ranges::any_of(figures.comparison.splits, [](const SplitRow& row) {
    return std::ranges::find(row.decode, "cuda", &DecodeRow::backend) != row.decode.end();
  });
}

// Explains all terms. The page begins with a link to it.
std::string words(const ComparisonFigures& figures) {
  const std::string base = figures.base_name();
  const std::pair<const char*, std::string> kWords[] = {
      {"patch",
       "A piece of a mesh that is compressed on its own, so that several patches can decode at the same time."},
      {"point", "A vertex as glTF stores it: a position with its normal, texture coordinates and so on."},
      {"stock Draco",
       "Google's Draco library, unchanged: a mesh is one stream, which one thread decodes from beginning to "
       "end."},
      {"speed",
       "A setting of Draco, from 0 for the smallest files to 10 for the fastest decoding. Patches, and the "
       "stream that they are compared with, use the same speed."},
      {"decoder", "cpu is psplit's own decoder" +
                      std::string(has_cuda(figures) ? ", cuda is its own on the GPU" : "") +
                      ", and draco is Draco's library, which decodes the patches. Stock Draco and "
                      "meshoptimizer use one thread."},
      {"speed-up", "How many times as fast as " + base + " something decodes."},
      {"overhead", "How many more bytes something takes than " + base + "."},
      {"replication",
       "How many more points the patches store than the mesh has, because points on a border are stored in "
       "each patch that they touch. This is most of the cost of patches."},
      {"stitch map",
       "The table that says which points of different patches are the same, so that the decoded mesh has no "
       "cracks and no duplicate points."},
      {"directory", "The table that says where each patch begins and how large it is."},
      {"balance",
       "Triangles of the largest patch, divided by the mean over all patches: the largest takes longest to "
       "decode."},
  };
  std::string list;
  for (const auto& [word, meaning] : kWords)
    list += "<dt><dfn>" + escape_html(word) + "</dfn></dt>" + html_element("dd", meaning) + "\n";
  return "<section id=\"words\">\n<h2>Words</h2>\n<dl class=\"words\">" + list + "</dl>\n</section>\n";
}

std::string whole_asset(const ComparisonFigures& figures, const ComparisonSummary& summary) {
  if (!figures.report.asset || !summary.has_recommendation) return "";
  const AssetParts& parts = *figures.report.asset;
  std::string html = "<section>\n<h2>The whole asset</h2>\n";
  const uint64_t with_patches = parts.with_meshes(summary.recommended_bytes);
  const uint64_t with_stock = parts.with_meshes(figures.base.bytes);
  if (parts.textures > 0)
    html += paragraph("Textures are " +
                      as_share(static_cast<double>(parts.textures) / static_cast<double>(with_patches)) +
                      " of the compressed asset. Including them, patches change its size by " +
                      as_percent(static_cast<double>(with_patches) / static_cast<double>(with_stock) - 1) +
                      " compared with stock Draco.");
  if (parts.missing_images > 0)
    html += paragraph(counted(parts.missing_images, "image") + (parts.missing_images == 1 ? " is" : " are") +
                      " not found, and not counted.");
  return html + asset_table(parts, figures, summary) + "</section>\n";
}

// What was measured and on which machine, and a picture.
std::string setting(const ComparisonReport& report) {
  const Environment& environment = report.environment;
  const EncodeDocumentOptions& coding = report.options.coding;
  std::string list = "<dl>";
  const auto add = [&](const char* what, const std::string& text, const char* tag = "span") {
    list += html_element("dt", what) + "<dd>" + html_element(tag, text) + "</dd>\n";
  };
  add("Input", report.input);
  add("Command", environment.command_line, "code");
  add("Date", environment.date + " UTC");
  add("CPU", environment.cpu + ", " + counted(static_cast<uint64_t>(environment.threads), "thread"));
  add("GPU", environment.gpu.empty() ? "none that this build can use" : environment.gpu);
  add("psplit", environment.psplit + ", built with " + environment.compiler);
  add("libdraco", environment.draco);
  add("meshoptimizer",
      environment.meshoptimizer + ", version " + std::to_string(environment.meshopt_codec) + " of its codec");
  add("zstd", environment.zstd);
  if (!environment.brotli.empty()) add("brotli", environment.brotli);
  add("Draco speed", std::to_string(coding.encode_speed) +
                         " for patches, and for the stock Draco stream that all ratios refer to");
  add("Bits", coding.lossless ? "all: lossless"
                              : "positions " + std::to_string(coding.position_bits) + ", normals " +
                                    std::to_string(coding.normal_bits) + ", texture coordinates " +
                                    std::to_string(coding.texcoord_bits) + ", colours " +
                                    std::to_string(coding.color_bits) + ", other floats " +
                                    std::to_string(coding.generic_bits));
  if (!coding.refine) add("Borders", "not refined");
  add("Rounds", std::to_string(report.comparison.rounds) + ", after one untimed round");
  list += "</dl>\n";
  std::string picture;
  if (!report.picture.png.empty()) {
    const std::string what = "The input in " + counted(report.picture.patches, "patch");
    picture = "<figure class=\"picture\"><img alt=\"" + what + "\" src=\"data:image/png;base64," +
              base64(report.picture.png) + "\" width=\"1200\" height=\"900\"><figcaption>" + what +
              (report.picture.patches == 1 ? "" : ", each in a colour of its own") + "</figcaption></figure>\n";
  }
  return "<section id=\"setting\">\n<h2>What was measured, and where</h2>\n<div class=\"pair\">\n" + list +
         picture + "</div>\n</section>\n";
}

std::string method(const ComparisonFigures& figures) {
  return "<section>\n<h2>How</h2>\n<div class=\"method\">\n" +
         paragraph(
             "All decoders ran in one process and took turns: in each round, each of them decoded everything "
             "once. Times are medians over the rounds. The tables also have the fastest and the slowest "
             "round. The charts show as pale lines, clipped to the chart, what half of the rounds were within. "
             "Times are marked as noisy (~) where these lines are longer than " +
             with_decimals(100 * kNoisySpread, 0) +
             " % of the median. A time "
             "covers the way from compressed bytes to indices and attributes, both in the host's memory. It "
             "does not include reading files" +
             std::string(has_cuda(figures) ? ", but it includes copying to the GPU and back." : ".")) +
         paragraph(
             "Stock Draco is one stream for each primitive, decoded on one thread, because Draco cannot use "
             "more. Its library is the installed libdraco " +
             figures.report.environment.draco +
             ", which psplit neither builds nor changes. The decoder named draco is the same library, which "
             "decodes the patches. The decoder named cpu is psplit's own" +
             (has_cuda(figures) ? ", and cuda is its own on the GPU." : ".")) +
         paragraph(
             "Meshoptimizer gets its meshes as its documentation recommends for small files: points are "
             "merged, triangles are ordered in strips and points for vertex fetch, and attributes are "
             "quantized on the grids of stock Draco and psplit, with as many bits. Indices use version 1 of "
             "its codec, and attributes "
             "use version " +
             std::to_string(figures.report.environment.meshopt_codec) +
             (figures.report.environment.meshopt_codec == 0
                  ? ", the newest of release " + figures.report.environment.meshoptimizer +
                        ", which this build found. Releases from 0.23 on have a version 1, whose files are "
                        "smaller"
                  : "") +
             ". zstd compresses at level 19" +
             (figures.report.environment.brotli.empty() ? "" : ", brotli at quality 11") +
             ". Meshoptimizer runs on one thread. Its decoded values stay "
             "quantized, as GPUs accept them; the other decoders produce floats where the input has floats.") +
         paragraph("Encoding ran once; patches were encoded on all threads. Overhead and speed-up refer to " +
                   figures.base_name() + ".") +
         "</div>\n</section>\n";
}

}  // namespace

std::string to_html(const ComparisonReport& report) {
  const ComparisonFigures figures(report);
  const ComparisonSummary summary = summarize(report);
  const std::string title = report.input + ": size and decoding speed";
  const std::string lead = counted(report.comparison.faces, "triangle") + ", " +
                           counted(report.comparison.points, "point") +
                           ". psplit cuts meshes into patches, Draco streams that decode at the same time; "
                           "stock Draco makes one stream "
                           "of a mesh.";
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
         "'unsafe-inline'; img-src data:\">\n"
         "<link rel=\"icon\" href=\"data:,\">\n" +
         html_element("title", title) + "\n<style>" + kPageStyle + "</style>\n</head>\n<body>\n<header>\n" +
         html_element("h1", title) + "\n<p class=\"lead\">" + escape_html(lead) +
         " <a href=\"#words\">All words are explained</a> at the end.</p>\n</header>\n<main>\n" +
         result(figures, summary) + whole_asset(figures, summary) +
         "<section id=\"charts\">\n<h2>Charts</h2>\n<div class=\"pair\">\n" + comparison_charts(figures) +
         "</div>\n</section>\n<section id=\"numbers\">\n<h2>Numbers</h2>\n" + comparison_tables(figures) +
         "</section>\n" + setting(report) + method(figures) + words(figures) + "</main>\n</body>\n</html>\n";
}

}  // namespace psplit
