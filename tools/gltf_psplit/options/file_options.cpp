#include "tools/gltf_psplit/options/file_options.h"

#include <CLI/CLI.hpp>
#include <map>
#include <utility>

namespace psplit {
namespace {

const std::map<std::string, ImagePlacement> kPlacements{{"embed", ImagePlacement::kEmbed},
                                                        {"copy", ImagePlacement::kCopy},
                                                        {"reference", ImagePlacement::kReference}};

}  // namespace

CLI::Option* add_word_option(CLI::App& command, const std::string& name, std::string& word,
                             const std::string& type, const std::string& text) {
  return command.add_option(name, word, text)->type_name(type);
}

CLI::Option* add_choice_option(CLI::App& command, const std::string& name, std::string& word,
                               const std::vector<std::string>& words, const std::string& text) {
  return command.add_option(name, word, text)->check(CLI::IsMember(words))->capture_default_str();
}

CLI::Option* add_parsed_option(CLI::App& command, const std::string& name, const std::string& type,
                               const std::string& text, const std::string& refusal,
                               std::function<bool(const std::string&)> take) {
  const auto parse = [name, refusal, take = std::move(take)](const std::string& word) {
    if (!take(word)) throw CLI::ValidationError(name, word + " " + refusal);
  };
  return command.add_option_function<std::string>(name, parse, text)->type_name(type);
}

CLI::Option* separated_by_commas(CLI::Option* option, const std::string& type) {
  return option->delimiter(',')->allow_extra_args(false)->type_name(type);
}

void add_input_option(CLI::App& command, std::string& path) {
  command.add_option("IN", path, kInputText)->required();
}

void add_output_option(CLI::App& command, std::string& path, OutputForms forms) {
  const std::string names =
      forms == OutputForms::kGltf ? ".glb or .gltf file" : ".glb, .gltf, .obj, .ply, .stl or .drc file";
  add_word_option(command, "-o,--output,OUT", path, "FILE",
                  "The output: a " + names + "; - writes a GLB to stdout")
      ->required();
}

void add_form_option(CLI::App& command, std::string& form) {
  add_choice_option(command, "--as", form, {"glb", "gltf"}, "Format of outputs in a folder");
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

void add_report_option(CLI::App& command, std::string& path) {
  add_word_option(command, "--report", path, "FILE", "Write a report as JSON; - is stdout");
}

void add_wide_option(CLI::App& command, bool& wide) {
  command.add_flag("--wide", wide, "Show all columns of tables, which may be wider than 100 characters");
}

void add_text_output_option(CLI::App& command, std::string& path) {
  command.add_option("-o,--output", path, "File for the result; - is stdout")
      ->capture_default_str()
      ->type_name("FILE");
}

void add_format_option(CLI::App& command, std::string& name, const std::vector<std::string>& forms) {
  add_choice_option(command, "--format", name, forms, "Format of the result");
}

std::string describe_images(const WriteOptions& options) {
  for (const auto& [name, placement] : kPlacements)
    if (options.images == placement) return name;
  return "default";
}

}  // namespace psplit
