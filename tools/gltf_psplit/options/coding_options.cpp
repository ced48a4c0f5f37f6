#include "tools/gltf_psplit/options/coding_options.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

namespace psplit {

namespace {

// Metres, from a number with a unit. Nothing if the text is not a length greater than 0.
std::optional<double> parse_length(std::string_view text) {
  double length = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), length);
  if (read.ec != std::errc() || !(length > 0) || !std::isfinite(length)) return std::nullopt;
  const std::string_view unit = text.substr(static_cast<size_t>(read.ptr - text.data()));
  for (const auto& [name, metres] : {std::pair<std::string_view, double>{"", 1},
                                     {"m", 1},
                                     {"cm", 1e2},
                                     {"mm", 1e3},
                                     {"um", 1e6},
                                     {"\u00b5m", 1e6}})
    if (unit == name) return length / metres;
  return std::nullopt;
}

void add_position_options(CLI::App& command, EncodeDocumentOptions& options) {
  const auto is_bits = [](const std::string& text) {
    int bits = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), bits);
    const bool is_number = read.ec == std::errc() && read.ptr == text.data() + text.size();
    return text == "auto" || (is_number && bits >= 1 && bits <= kMostPositionBits)
               ? std::string()
               : text + " is neither auto nor a number from 1 to " + std::to_string(kMostPositionBits);
  };
  const auto set_bits = [&options](const std::string& text) {
    options.position_bits_by_edges = text == "auto";
    if (text != "auto") options.position_bits = std::stoi(text);
  };
  CLI::Option* bits = command.add_option_function<std::string>(
      "--quantize-position", set_bits,
      "Bits for each component of positions. auto: the fewest, from " + std::to_string(kLeastBitsForEdges) +
          " on, whose step is at most 1/20 of the length that 95 % of the edges exceed. Dense meshes get more "
          "than " +
          std::to_string(options.position_bits) + ", and grow; the summary says by how much");
  bits->check(is_bits)->default_str(std::to_string(options.position_bits))->type_name("BITS");
  command
      .add_option_function<std::string>(
          "--max-error",
          [&options](const std::string& text) { options.max_position_error = *parse_length(text); },
          "Bits for positions that guarantee that each is at most this far off, whatever they cost: 0.5mm, "
          "20um, 1cm, 0.1m, or a "
          "number in the units of the input, which are metres in glTF. It counts in the mesh's own "
          "coordinates, "
          "before the transforms of nodes")
      ->check([](const std::string& text) {
        return parse_length(text) ? std::string() : text + " is not a length, such as 0.5mm, 20um or 0.001";
      })
      ->excludes(bits)
      ->type_name("LENGTH");
}

}  // namespace

void add_coding_options(CLI::App& command, EncodeDocumentOptions& options, bool fits_mesh) {
  const auto add_bits = [&](const char* name, int& bits, int least, const char* what) {
    command.add_option(name, bits, std::string("Bits for each component of ") + what)
        ->check(CLI::Range(least, 30))
        ->capture_default_str()
        ->type_name("BITS");
  };
  if (fits_mesh)
    add_position_options(command, options);
  else
    add_bits("--quantize-position", options.position_bits, 1, "positions");
  add_bits("--quantize-normal", options.normal_bits, 2, "normals (octahedral)");
  add_bits("--quantize-texcoord", options.texcoord_bits, 1, "texture coordinates");
  add_bits("--quantize-color", options.color_bits, 1, "colours stored as floats");
  add_bits("--quantize-generic", options.generic_bits, 1, "all other float attributes");
  CLI::Option* lossless =
      command.add_flag("--lossless", options.lossless, "Keep every float exactly, without quantization");
  for (const char* name : {"--quantize-position", "--quantize-normal", "--quantize-texcoord",
                           "--quantize-color", "--quantize-generic"})
    lossless->excludes(command.get_option(name));
  if (fits_mesh) lossless->excludes("--max-error");
  command
      .add_option("--encode-speed", options.encode_speed,
                  "Draco's speed: 0 makes the smallest files, 10 is fastest")
      ->check(CLI::Range(0, 10))
      ->capture_default_str()
      ->type_name("SPEED");
}

void add_partition_options(CLI::App& command, EncodeDocumentOptions& options) {
  const auto cut_as_the_paper = [&options](const std::string& distance) {
    options.method = PartitionMethod::kPaper;
    options.distance = distance == "geodesic" ? PathDistance::kGeodesic : PathDistance::kDijkstra;
  };
  command
      .add_option_function<std::string>(
          "--distance", cut_as_the_paper,
          "Cut with the paper's method, which clusters faces around farthest points. Distances are measured "
          "along edges (dijkstra) or across faces (geodesic). The default method cuts in levels and is faster")
      ->check(CLI::IsMember({"dijkstra", "geodesic"}))
      ->type_name("NAME");
  command.add_flag_callback(
      "--no-refine", [&options] { options.refine = false; },
      "Do not smooth the borders between patches: shows what refinement gains");
}

}  // namespace psplit
