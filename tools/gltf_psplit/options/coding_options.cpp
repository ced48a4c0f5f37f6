#include "tools/gltf_psplit/options/coding_options.h"

#include <CLI/CLI.hpp>

namespace psplit {

void add_coding_options(CLI::App& command, EncodeDocumentOptions& options) {
  const auto add_bits = [&](const char* name, int& bits, int least, const char* what) {
    command.add_option(name, bits, std::string("Bits for each component of ") + what)
        ->check(CLI::Range(least, 30))
        ->capture_default_str()
        ->type_name("BITS");
  };
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
