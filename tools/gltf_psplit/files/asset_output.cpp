#include "tools/gltf_psplit/files/asset_output.h"

#include <CLI/CLI.hpp>
#include <map>

namespace psplit {
namespace {

const std::map<std::string, ImagePlacement> kPlacements{{"embed", ImagePlacement::kEmbed},
                                                        {"copy", ImagePlacement::kCopy},
                                                        {"reference", ImagePlacement::kReference}};

}  // namespace

void add_output_option(CLI::App& command, std::string& path) {
  command.add_option("-o,--output,OUT", path, "The output: a .glb or .gltf file; - writes a GLB to stdout")
      ->required()
      ->type_name("FILE");
}

void add_images_option(CLI::App& command, WriteOptions& options) {
  command
      .add_option_function<std::string>(
          "--images", [&options](const std::string& name) { options.images = kPlacements.at(name); },
          "What to do with image files: embed them, copy them to the output's folder, or refer to them where "
          "they are. Default: a .glb embeds, a .gltf copies")
      ->check(CLI::IsMember({"embed", "copy", "reference"}))
      ->type_name("HOW");
}

std::string describe_images(const WriteOptions& options) {
  for (const auto& [name, placement] : kPlacements)
    if (options.images == placement) return name;
  return "default";
}

void log_written(const WriteReport& report, const Log& log, const std::string& prefix) {
  for (const std::string& note : report.notes) log.note(prefix + note);
  for (const std::string& warning : report.warnings) log.warning(prefix + warning);
}

void append_written(Json& object, const WriteReport& report) {
  object["images"] = {
      {"embedded", report.embedded_images}, {"copied", report.copied_images}, {"bytes", report.image_bytes}};
  object["warnings"] = report.warnings;
}

}  // namespace psplit
