// gltf-psplit inspect: lists the patches and stock Draco streams of assets with their sizes, and draws a
// picture.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <memory>

#include "gltf_ext/document/linked_files.h"
#include "src/stopwatch.h"
#include "system/files.h"
#include "tools/gltf_psplit/commands/commands.h"
#include "tools/gltf_psplit/files/many_files.h"
#include "tools/gltf_psplit/files/output_checks.h"
#include "tools/gltf_psplit/files/read_input.h"
#include "tools/gltf_psplit/files/text_output.h"
#include "tools/gltf_psplit/inspect/inspected_asset.h"
#include "tools/gltf_psplit/options/backend_choice.h"
#include "tools/gltf_psplit/options/file_options.h"
#include "tools/gltf_psplit/options/help_text.h"
#include "tools/gltf_psplit/options/session.h"
#include "tools/gltf_psplit/preview/preview.h"
#include "tools/gltf_psplit/report/asset_bytes.h"
#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/progress.h"

namespace psplit {
namespace {

struct InspectArguments {
  std::vector<std::string> inputs;
  std::string output = "-", format = "text", preview;
  ImageSize preview_size;
  bool wide = false;
  BackendChoice backend;
};

// Reads "WxH", or one number for both. False if the text is neither, or the size is out of range.
bool parse_image_size(const std::string& text, ImageSize& size) {
  constexpr int kLeast = 16, kMost = 4096;
  const char* const end = text.data() + text.size();
  auto read = std::from_chars(text.data(), end, size.width);
  size.height = size.width;
  if (read.ec == std::errc() && read.ptr != end && *read.ptr == 'x')
    read = std::from_chars(read.ptr + 1, end, size.height);
  if (read.ec != std::errc() || read.ptr != end) return false;
  const auto [least, most] = std::minmax(size.width, size.height);
  return least >= kLeast && most <= kMost;
}

Status write_preview(const Document& document, const std::string& input, const InspectArguments& arguments,
                     const Session& session) {
  const Stopwatch watch;
  const Expected<Image> image = [&] {
    ProgressBar bar("drawing", session.log);
    return draw_preview(document, arguments.preview_size, find_backend(arguments.backend), session.pool,
                        bar.callback());
  }();
  if (!image) return image.status().at({.file = input});
  const auto file = encode_png(*image);
  if (!file) return file.status().at({.file = arguments.preview});
  if (Status status = write_file(arguments.preview, {*file}, session.if_read_only()); !status.ok())
    return status;
  session.log.note(arguments.preview + ": " + std::to_string(image->size.width) + " x " +
                   std::to_string(image->size.height) + " pixels; " + as_duration(watch.ms()));
  return {};
}

Expected<InspectedAsset> inspect_asset(const std::string& input, const InspectArguments& arguments,
                                       const Session& session) {
  const Expected<Document> document =
      read_input(input, session, arguments.backend.name, FileAccess::kMap, {}, {}, PointClouds::kRead);
  if (!document) return document.status();
  if (Status status = check_not_an_input(arguments.preview, "--preview", *document); !status.ok())
    return status;
  if (Status status = check_not_an_input(arguments.output, "--output", *document); !status.ok()) return status;
  std::vector<std::string> warnings;
  for (const LinkedFile& link : linked_files(*document)) {
    const std::string text = describe_dangling(link);
    if (text.empty()) continue;
    session.log.warning(text);
    warnings.push_back(text);
  }
  if (!arguments.preview.empty())
    if (Status status = write_preview(*document, input, arguments, session); !status.ok()) return status;
  InspectedAsset asset{.file = input,
                       .bytes = bytes_on_disk(*document),
                       .compressed = {},
                       .plain = {},
                       .coarse = {},
                       .warnings = warnings};
  if (Status status =
          inspect_primitives(*document, find_describer(arguments.backend.name), session.pool, asset);
      !status.ok())
    return std::move(status).at({.file = input});
  for (size_t i = warnings.size(); i < asset.warnings.size(); ++i)
    session.log.warning(input + ": " + asset.warnings[i]);
  // For several files, the table says this.
  if (arguments.inputs.size() > 1) return asset;
  if (!asset.compressed.empty())
    session.log.note(summary_text(asset));
  else
    session.log.warning("no primitive of " + input + " is in patches or stock Draco");
  return asset;
}

Status run_inspect(const InspectArguments& arguments, const Session& session) {
  const size_t file_count = arguments.inputs.size();
  if (Status status = check_inputs(arguments.inputs); !status.ok()) return status;
  if (file_count > 1 && !arguments.preview.empty())
    return wrong_usage("--preview draws one asset, and there are " + counted(file_count, "file"));
  if (Status status = check_not_an_input(arguments.output, "--output", arguments.inputs); !status.ok())
    return status;
  for (const std::string& path : {arguments.output, arguments.preview})
    if (!path.empty())
      if (Status status = check_output_place(path, session.force); !status.ok()) return status;

  std::vector<InspectedAsset> assets;
  std::vector<Json> results;
  bool spares_output = false;  // the output would replace a file that an asset needs
  const bool as_json = arguments.format == "json";
  const Status status = for_each_file(arguments.inputs, session.log, [&](const std::string& input) {
    Expected<InspectedAsset> asset = inspect_asset(input, arguments, session);
    if (as_json && (asset || file_count > 1))
      results.push_back(asset ? to_json(*asset) : failure_json(input, asset.status()));
    if (!asset) {
      spares_output |= asset.status().code() == StatusCode::kUsage;
      return asset.status();
    }
    assets.push_back(std::move(*asset));
    return Status();
  });
  if (spares_output || (as_json ? results.empty() : assets.empty())) return status;
  const std::string text = as_json           ? report_text(results_json(std::move(results), file_count))
                           : file_count == 1 ? to_text(assets.front(), arguments.wide)
                                             : to_text(assets, arguments.wide);
  if (Status written = write_text(arguments.output, text, session.if_read_only()); !written.ok())
    return written;
  return status;
}

}  // namespace

void add_inspect_command(CLI::App& command, Action& action) {
  auto arguments = std::make_shared<InspectArguments>();
  command
      .add_option(
          "IN", arguments->inputs,
          "The inputs: .gltf, .glb, .drc, .ply, .obj, .stl or .off files, optionally gzipped; - reads stdin")
      ->required();
  add_format_option(command, arguments->format);
  add_text_output_option(command, arguments->output);
  add_wide_option(command, arguments->wide);
  CLI::Option* preview =
      command
          .add_option("--preview", arguments->preview,
                      "Draw the default scene into this .png file, with every patch in its own colour")
          ->check([](const std::string& path) {
            return std::string(path.ends_with(".png") ? "" : "the picture's name must end in .png");
          })
          ->type_name("OUT.png");
  add_parsed_option(
      command, "--preview-size", "WxH",
      "Width and height of the picture in pixels, or one number for both (16 to 4096)",
      "is not a size such as 640x480 or 640, from 16 to 4096 pixels",
      [&size = arguments->preview_size](const std::string& text) { return parse_image_size(text, size); })
      ->needs(preview)
      ->default_str("1200x900");
  add_backend_options(command, arguments->backend);
  add_examples(
      command,
      {{"gltf-psplit inspect dragon.glb", "show patches, points and bytes of each primitive"},
       {"gltf-psplit inspect dragon.glb --preview patches.png", "also draw a picture of the patches"},
       {"gltf-psplit inspect out/*.glb", "one line for each file"},
       {"gltf-psplit inspect dragon.glb --format json | jq .primitives[0].patches", "JSON, for programs"}});
  command.callback([arguments, &action] {
    action = [arguments](const Session& session) { return run_inspect(*arguments, session); };
  });
}

}  // namespace psplit
