#include "tools/gltf_psplit/commands/output_files.h"

#include <CLI/CLI.hpp>
#include <map>

#include "gltf_ext/document/linked_files.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

const std::map<std::string, ImagePlacement> kPlacements{{"embed", ImagePlacement::kEmbed},
                                                        {"copy", ImagePlacement::kCopy},
                                                        {"reference", ImagePlacement::kReference}};

bool is_same_file(const fs::path& a, const fs::path& b) {
  std::error_code error;
  return fs::equivalent(a, b, error) || fs::weakly_canonical(a, error) == fs::weakly_canonical(b, error);
}

}  // namespace

void add_images_option(CLI::App& command, WriteOptions& options) {
  command
      .add_option_function<std::string>(
          "--images", [&options](const std::string& name) { options.images = kPlacements.at(name); },
          "Images that are files: embed them, copy them to the output's folder, or refer to where they are. By "
          "default a .glb embeds, and a .gltf copies")
      ->check(CLI::IsMember({"embed", "copy", "reference"}))
      ->type_name("HOW");
}

std::string describe_images(const WriteOptions& options) {
  for (const auto& [name, placement] : kPlacements)
    if (options.images == placement) return name;
  return "default";
}

Status check_not_an_input(const std::string& path, const std::string& option, const Document& document) {
  if (path.empty() || path == "-") return {};
  const auto refuse = [&](const fs::path& file) {
    return Status(StatusCode::kUsage, option + " would replace " + file.string() + ", which the input needs");
  };
  for (const fs::path& file : document.files)
    if (is_same_file(path, file)) return refuse(file);
  for (const LinkedFile& link : linked_files(document))
    if (link.state == LinkState::kFound && is_same_file(path, link.path)) return refuse(link.path);
  return {};
}

Status check_not_an_input(const std::string& path, const std::string& option,
                          std::span<const std::string> inputs) {
  Document named;
  named.json = Json::object();
  for (const std::string& input : inputs)
    if (input != "-") named.files.emplace_back(input);
  return check_not_an_input(path, option, named);
}

Status check_not_an_output(const std::string& path, const std::string& option, const WriteReport& written) {
  if (path.empty() || path == "-") return {};
  for (const fs::path& file : written.files)
    if (file != "-" && is_same_file(path, file))
      return {StatusCode::kUsage, option + " and the output cannot share " + file.string()};
  return {};
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
