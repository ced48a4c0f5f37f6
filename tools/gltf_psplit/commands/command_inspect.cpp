// gltf-psplit inspect: what the patches, and the stock Draco streams, of an asset are and cost, and how they
// look.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <chrono>
#include <memory>
#include <optional>

#include "gltf_ext/document/linked_files.h"
#include "gltf_ext/files/files.h"
#include "tools/gltf_psplit/commands/asset_bytes.h"
#include "tools/gltf_psplit/commands/commands.h"
#include "tools/gltf_psplit/commands/help_text.h"
#include "tools/gltf_psplit/commands/many_files.h"
#include "tools/gltf_psplit/commands/output_files.h"
#include "tools/gltf_psplit/commands/output_place.h"
#include "tools/gltf_psplit/commands/patch_summary.h"
#include "tools/gltf_psplit/commands/progress.h"
#include "tools/gltf_psplit/preview/preview.h"

namespace psplit {
namespace {

struct Arguments {
  std::vector<std::string> inputs;
  std::string output = "-", format = "text", preview, preview_size = "1200x900";
  bool wide = false;
  BackendChoice backend;
};

struct InspectedPrimitive {
  PrimitiveId id;
  PrimitiveStorage storage = PrimitiveStorage::kPlain;
  PatchSummary summary;
  std::optional<uint32_t> container_version;  // of patches
  std::optional<StreamCoding> coding;         // none where there is no stream
  std::vector<AttributeRequest> attributes;
  std::vector<int> bits;  // one per attribute; 0 where it is stored exactly
};

struct InspectedAsset {
  std::string file;
  AssetBytes bytes;
  std::vector<InspectedPrimitive> compressed, plain;
  std::vector<std::string> warnings;

  PatchSummary sum() const {
    PatchSummary sum;
    for (const InspectedPrimitive& primitive : compressed) sum += primitive.summary;
    return sum;
  }
};

const char* storage_name(PrimitiveStorage storage) {
  switch (storage) {
    case PrimitiveStorage::kPlain: return "plain";
    case PrimitiveStorage::kPatches: return "patches";
    case PrimitiveStorage::kStockDraco: return "draco";
  }
  return "";
}

// The stream's coding, and the bits of each attribute asked for.
Status add_coding(const StreamDescription& stream, InspectedPrimitive& primitive) {
  primitive.coding = stream.coding;
  primitive.bits.clear();
  for (const AttributeRequest& request : primitive.attributes) {
    const auto found = std::ranges::find(stream.attributes, request.unique_id, &StreamAttribute::unique_id);
    if (found == stream.attributes.end())
      return invalid_input("Draco stream: no attribute for " + request.semantic + " (unique id " +
                           std::to_string(request.unique_id) + ")");
    primitive.bits.push_back(found->bits);
  }
  return {};
}

Status inspect_patches(const Document& document, const DescribeStream& describe, InspectedPrimitive& out) {
  const Expected<StoredPrimitive> patched = stored_primitive(document, out.id, kExtensionName);
  if (!patched) return patched.status();
  const Expected<Container> container = parse_container(patched->bytes);
  if (!container) return container.status();
  const Expected<PatchSummary> summary = summarize_container(patched->bytes);
  if (!summary) return summary.status();
  out.summary = *summary;
  out.container_version = container->version;
  out.attributes = patched->requests;
  out.bits.assign(out.attributes.size(), 0);
  if (container->streams.empty()) return {};
  // All streams of a container are coded alike, but for that of the residue, which is the last.
  const Expected<StreamDescription> stream = describe(container->streams[0]);
  return (stream ? add_coding(*stream, out) : stream.status()).at({.patch = 0});
}

Status inspect_stock(const Document& document, const DescribeStream& describe, InspectedPrimitive& out) {
  const Expected<StoredPrimitive> stock = stored_primitive(document, out.id, kStockExtensionName);
  if (!stock) return stock.status();
  const Expected<StreamDescription> stream = describe(stock->bytes);
  if (!stream) return stream.status();
  out.summary = summarize_stream(*stream, stock->bytes.size());
  out.attributes = stock->requests;
  return add_coding(*stream, out);
}

// Of a plain primitive there is nothing but its storage.
Status inspect_primitive(const Document& document, const DescribeStream& describe, InspectedPrimitive& out) {
  const Expected<PrimitiveKind> kind = primitive_kind(document, out.id);
  if (!kind) return kind.status();
  out.storage = kind->storage;
  switch (kind->storage) {
    case PrimitiveStorage::kPatches: return inspect_patches(document, describe, out);
    case PrimitiveStorage::kStockDraco: return inspect_stock(document, describe, out);
    case PrimitiveStorage::kPlain: break;
  }
  return {};
}

Json to_json(const InspectedPrimitive& primitive) {
  Json object{{"mesh", primitive.id.mesh},
              {"primitive", primitive.id.primitive},
              {"storage", storage_name(primitive.storage)}};
  if (primitive.storage == PrimitiveStorage::kPlain) return object;
  object["container_version"] =
      primitive.container_version ? Json(*primitive.container_version) : Json(nullptr);
  object["coding"] = primitive.coding ? Json(coding_name(*primitive.coding)) : Json(nullptr);
  append_summary(object, primitive.summary);
  Json attributes = Json::array();
  for (size_t i = 0; i < primitive.attributes.size(); ++i) {
    const AttributeRequest& request = primitive.attributes[i];
    Json attribute{{"semantic", request.semantic}, {"componentType", static_cast<int>(request.component_type)}};
    attribute["bits"] = primitive.bits[i] == 0 ? Json(nullptr) : Json(primitive.bits[i]);
    attributes.push_back(std::move(attribute));
  }
  object["attributes"] = std::move(attributes);
  return object;
}

// Tells old versions only: they are rare.
std::string storage_text(const InspectedPrimitive& primitive) {
  const uint32_t version = primitive.container_version.value_or(kContainerVersion);
  return storage_name(primitive.storage) +
         (version == kContainerVersion ? std::string() : " (version " + std::to_string(version) + ")");
}

Json to_json(const InspectedAsset& asset) {
  Json result{{"file", asset.file}, {"bytes", asset.bytes.files}, {"texture_bytes", asset.bytes.textures}};
  for (const auto& [name, primitives] :
       {std::pair("primitives", &asset.compressed), {"others", &asset.plain}}) {
    result[name] = Json::array();
    for (const InspectedPrimitive& primitive : *primitives) result[name].push_back(to_json(primitive));
  }
  result["warnings"] = asset.warnings;
  return result;
}

std::string attributes_text(const InspectedPrimitive& primitive) {
  std::string text;
  for (size_t i = 0; i < primitive.attributes.size(); ++i) {
    text += (i == 0 ? "" : ", ") + primitive.attributes[i].semantic + " ";
    text += primitive.bits[i] == 0 ? "exact" : counted(static_cast<uint64_t>(primitive.bits[i]), "bit");
  }
  return text;
}

// "POSITION 14 bits, NORMAL 10 bits: all but 2 primitives" would need explaining: so each set of attributes
// once, with how many primitives have it.
std::string attribute_sets_text(const InspectedAsset& asset) {
  std::vector<std::pair<std::string, uint64_t>> sets;
  for (const InspectedPrimitive& primitive : asset.compressed) {
    const std::string text = attributes_text(primitive);
    const auto found = std::ranges::find(sets, text, &std::pair<std::string, uint64_t>::first);
    if (found == sets.end())
      sets.emplace_back(text, 1);
    else
      ++found->second;
  }
  std::string lines;
  for (const auto& [text, count] : sets)
    lines += counted(count, "primitive") + ": " + wrap_text(text, kTableWidth - 16, 4) + "\n";
  return lines;
}

void add_row(TextTable& table, const std::vector<std::string>& names, const PatchSummary& summary,
             const std::string& attributes) {
  std::vector<std::string> row = names;
  for (const std::string& cell :
       {with_separators(summary.patches), with_separators(summary.faces), with_separators(summary.points),
        with_separators(summary.references), as_share(summary.replication()),
        with_decimals(summary.balance(), 3), with_separators(summary.payload_bytes),
        with_separators(summary.directory_bytes), with_separators(summary.stitch_bytes),
        with_separators(summary.total_bytes), with_decimals(summary.bits_per_point(), 2), attributes})
    row.push_back(cell);
  table.add(std::move(row));
}

std::string primitives_table(const InspectedAsset& asset, bool wide) {
  if (asset.compressed.empty()) return "";
  TextTable table(
      {"mesh", "primitive", "storage", "coding", "patches", "faces", "points", "references", "replication",
       "balance", "payload", "directory", "stitch", "total bytes", "bits/point", "attributes"},
      0);
  table.align_last_left();
  for (const InspectedPrimitive& primitive : asset.compressed)
    add_row(table,
            {std::to_string(primitive.id.mesh), std::to_string(primitive.id.primitive), storage_text(primitive),
             primitive.coding ? coding_name(*primitive.coding) : ""},
            primitive.summary, attributes_text(primitive));
  if (asset.compressed.size() > 1) add_row(table, {"all", "", "", ""}, asset.sum(), "");
  if (wide) return table.to_string();
  table.keep_columns(std::vector<std::string>{"mesh", "primitive", "storage", "coding", "patches", "faces",
                                              "points", "replication", "total bytes", "bits/point"});
  return table.to_string() + attribute_sets_text(asset);
}

// The table, and what is not in it.
std::string to_text(const InspectedAsset& asset, bool wide) {
  std::string text = primitives_table(asset, wide);
  for (const InspectedPrimitive& primitive : asset.plain)
    text += describe_place(primitive.id.mesh, primitive.id.primitive) + ": plain, not split\n";
  return text;
}

// "dragon.glb: 1.18 MB, 45 patches"
std::string summary(const InspectedAsset& asset) {
  const std::string bytes = sizes_text({{0, 0}, asset.bytes});
  const PatchSummary sum = asset.sum();
  return asset.file + ": " + bytes + (bytes.empty() ? "" : ", ") + "mesh data " + as_bytes(sum.total_bytes) +
         " in " + counted(asset.compressed.size(), "primitive") + " and " + counted(sum.patches, "patch");
}

// A line a file.
std::string to_text(std::span<const InspectedAsset> assets, bool wide) {
  TextTable table({"bytes", "textures", "primitives", "in patches", "draco", "plain", "patches", "faces",
                   "points", "references", "mesh bytes", "bits/point", "file"},
                  0);
  table.align_last_left();
  for (const InspectedAsset& asset : assets) {
    const PatchSummary sum = asset.sum();
    const auto split = static_cast<size_t>(
        std::ranges::count(asset.compressed, PrimitiveStorage::kPatches, &InspectedPrimitive::storage));
    table.add({with_separators(asset.bytes.files), with_separators(asset.bytes.textures),
               with_separators(asset.compressed.size() + asset.plain.size()), with_separators(split),
               with_separators(asset.compressed.size() - split), with_separators(asset.plain.size()),
               with_separators(sum.patches), with_separators(sum.faces), with_separators(sum.points),
               with_separators(sum.references), with_separators(sum.total_bytes),
               with_decimals(sum.bits_per_point(), 2), asset.file});
  }
  if (!wide)
    table.keep_columns(std::vector<std::string>{"bytes", "textures", "in patches", "draco", "plain", "patches",
                                                "faces", "mesh bytes", "file"});
  return table.to_string();
}

// WxH, or one number for both; nothing where it is neither, or no size for a picture.
std::optional<ImageSize> parse_size(const std::string& text) {
  constexpr int kLeast = 16, kMost = 4096;
  const char* const end = text.data() + text.size();
  ImageSize size;
  auto read = std::from_chars(text.data(), end, size.width);
  size.height = size.width;
  if (read.ec == std::errc() && read.ptr != end && *read.ptr == 'x')
    read = std::from_chars(read.ptr + 1, end, size.height);
  if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
  const auto [least, most] = std::minmax(size.width, size.height);
  return least >= kLeast && most <= kMost ? std::optional(size) : std::nullopt;
}

Status write_preview(const Document& document, const std::string& input, const Arguments& arguments,
                     const Session& session) {
  const auto begin = std::chrono::steady_clock::now();
  const Expected<Image> image = [&] {
    ProgressBar bar("drawing", session.log);
    return draw_preview(document, *parse_size(arguments.preview_size), find_backend(arguments.backend),
                        session.pool, bar.callback());
  }();
  if (!image) return image.status().at({.file = input});
  const auto file = encode_png(*image);
  if (!file) return file.status().at({.file = arguments.preview});
  if (Status status = write_file(arguments.preview, {*file}); !status.ok()) return status;
  const double wall_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  session.log.note(arguments.preview + ": " + std::to_string(image->size.width) + " x " +
                   std::to_string(image->size.height) + " pixels; " + as_duration(wall_ms));
  return {};
}

Expected<InspectedAsset> inspect_asset(const std::string& input, const Arguments& arguments,
                                       const Session& session) {
  const Expected<Document> document = read_input(input, session.log, arguments.backend.name);
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
  const DescribeStream describe = find_describer(arguments.backend.name);
  std::vector<InspectedPrimitive> all;
  for (const PrimitiveId id : all_primitives(*document)) all.emplace_back().id = id;
  std::vector<Status> statuses(all.size());
  session.pool.for_each(all.size(),
                        [&](size_t i) { statuses[i] = inspect_primitive(*document, describe, all[i]); });

  InspectedAsset asset{.file = input,
                       .bytes = bytes_on_disk(document->source.string()),
                       .compressed = {},
                       .plain = {},
                       .warnings = warnings};
  for (size_t i = 0; i < all.size(); ++i) {
    const auto [mesh, primitive] = all[i].id;
    if (!statuses[i].ok())
      return std::move(statuses[i])
          .at({.file = input,
               .mesh = static_cast<int64_t>(mesh),
               .primitive = static_cast<int64_t>(primitive)});
    const bool plain = all[i].storage == PrimitiveStorage::kPlain;
    (plain ? asset.plain : asset.compressed).push_back(std::move(all[i]));
  }
  // Of several files the table says so.
  if (arguments.inputs.size() > 1) return asset;
  if (!asset.compressed.empty())
    session.log.note(summary(asset));
  else
    session.log.warning("no primitive of " + input + " is split into patches, or stock Draco");
  return asset;
}

Status run_inspect(const Arguments& arguments, const Session& session) {
  const size_t file_count = arguments.inputs.size();
  if (Status status = check_inputs(arguments.inputs); !status.ok()) return status;
  if (file_count > 1 && !arguments.preview.empty())
    return {StatusCode::kUsage, "--preview draws one asset, and there are " + counted(file_count, "file")};
  if (Status status = check_not_an_input(arguments.output, "--output", arguments.inputs); !status.ok())
    return status;
  for (const std::string& path : {arguments.output, arguments.preview})
    if (!path.empty())
      if (Status status = check_output_place(path); !status.ok()) return status;

  std::vector<InspectedAsset> assets;
  std::vector<Json> results;
  bool spares_output = false;  // an asset needs the file of its name
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
  if (Status written = write_text(arguments.output, text); !written.ok()) return written;
  return status;
}

}  // namespace

void add_inspect_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App& command =
      *app.add_subcommand("inspect", "Show the patches and Draco streams of an asset, and what they cost");
  command
      .add_option("IN", arguments->inputs,
                  "Files, .gltf, .glb, .drc, .ply, .obj, .stl or .off, packed by gzip or not; - is stdin")
      ->required();
  add_format_option(command, arguments->format);
  add_text_output_option(command, arguments->output);
  command.add_flag("--wide", arguments->wide, "All columns, and not only those that fit 100 columns");
  CLI::Option* preview =
      command
          .add_option("--preview", arguments->preview,
                      "A .png file for a picture of the default scene, every patch in its own colour")
          ->check([](const std::string& path) {
            return std::string(path.ends_with(".png") ? "" : "the picture's name must end in .png");
          })
          ->type_name("OUT.png");
  command
      .add_option("--preview-size", arguments->preview_size,
                  "Width and height of the picture, or one number for both: 16 to 4096 pixels")
      ->check([](const std::string& text) {
        return std::string(parse_size(text) ? "" : text + " is not WxH, or not of 16 to 4096 pixels");
      })
      ->needs(preview)
      ->capture_default_str()
      ->type_name("WxH");
  add_backend_options(command, arguments->backend);
  add_examples(command,
               {{"gltf-psplit inspect dragon.glb", "patches, points and bytes of each primitive"},
                {"gltf-psplit inspect dragon.glb --preview patches.png", "and a picture of its patches"},
                {"gltf-psplit inspect out/*.glb", "a line a file"},
                {"gltf-psplit inspect dragon.glb --format json | jq .primitives[0].patches", "for programs"}});
  command.callback([arguments, &action] {
    action = [arguments](const Session& session) { return run_inspect(*arguments, session); };
  });
}

}  // namespace psplit
