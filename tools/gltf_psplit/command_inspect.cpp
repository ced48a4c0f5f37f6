// gltf-psplit inspect: what the patches, and the stock Draco streams, of an asset are and cost, and how they
// look.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <chrono>
#include <memory>
#include <optional>

#include "gltf_ext/files.h"
#include "gltf_ext/linked_files.h"
#include "tools/gltf_psplit/commands.h"
#include "tools/gltf_psplit/output_files.h"
#include "tools/gltf_psplit/patch_summary.h"
#include "tools/gltf_psplit/preview/preview.h"
#include "tools/gltf_psplit/progress.h"

namespace psplit {
namespace {

struct Arguments {
  std::string input, format = "text", preview, preview_size = "1200x900";
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

std::string attributes_text(const InspectedPrimitive& primitive) {
  std::string text;
  for (size_t i = 0; i < primitive.attributes.size(); ++i) {
    text += (i == 0 ? "" : ", ") + primitive.attributes[i].semantic + " ";
    text += primitive.bits[i] == 0 ? "exact" : counted(static_cast<uint64_t>(primitive.bits[i]), "bit");
  }
  return text;
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

std::string to_text(std::span<const InspectedPrimitive> primitives) {
  if (primitives.empty()) return "";
  TextTable table(
      {"mesh", "primitive", "storage", "coding", "patches", "faces", "points", "references", "replication",
       "balance", "payload", "directory", "stitch", "total bytes", "bits/point", "attributes"},
      0);
  PatchSummary sum;
  for (const InspectedPrimitive& primitive : primitives) {
    add_row(table,
            {std::to_string(primitive.id.mesh), std::to_string(primitive.id.primitive), storage_text(primitive),
             primitive.coding ? coding_name(*primitive.coding) : ""},
            primitive.summary, attributes_text(primitive));
    sum += primitive.summary;
  }
  if (primitives.size() > 1) add_row(table, {"all", "", "", ""}, sum, "");
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

Status write_preview(const Document& document, const Arguments& arguments, const Session& session) {
  const auto begin = std::chrono::steady_clock::now();
  const Expected<Image> image = [&] {
    ProgressBar bar("drawing", session.log);
    return draw_preview(document, *parse_size(arguments.preview_size), find_backend(arguments.backend),
                        session.pool, bar.callback());
  }();
  if (!image) return image.status().at({.file = arguments.input});
  const auto file = encode_png(*image);
  if (!file) return file.status().at({.file = arguments.preview});
  if (Status status = write_file(arguments.preview, {*file}); !status.ok()) return status;
  const double wall_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  session.log.note(arguments.preview + ": " + std::to_string(image->size.width) + " x " +
                   std::to_string(image->size.height) + " pixels; " + as_duration(wall_ms));
  return {};
}

Status run_inspect(const Arguments& arguments, const Session& session) {
  const Expected<Document> document = read_input(arguments.input, session.log, arguments.backend.name);
  if (!document) return document.status();
  if (Status status = check_not_an_input(arguments.preview, "--preview", *document); !status.ok())
    return status;
  Json warnings = Json::array();
  for (const LinkedFile& link : linked_files(*document)) {
    const std::string text = describe_dangling(link);
    if (text.empty()) continue;
    session.log.warning(text);
    warnings.push_back(text);
  }
  if (!arguments.preview.empty())
    if (Status status = write_preview(*document, arguments, session); !status.ok()) return status;
  const DescribeStream describe = find_describer(arguments.backend.name);
  std::vector<InspectedPrimitive> all;
  for (const PrimitiveId id : all_primitives(*document)) all.emplace_back().id = id;
  std::vector<Status> statuses(all.size());
  session.pool.for_each(all.size(),
                        [&](size_t i) { statuses[i] = inspect_primitive(*document, describe, all[i]); });

  std::vector<InspectedPrimitive> compressed;
  Json others = Json::array();
  std::string others_text;
  for (size_t i = 0; i < all.size(); ++i) {
    const auto [mesh, primitive] = all[i].id;
    if (!statuses[i].ok())
      return std::move(statuses[i])
          .at({.file = arguments.input,
               .mesh = static_cast<int64_t>(mesh),
               .primitive = static_cast<int64_t>(primitive)});
    if (all[i].storage != PrimitiveStorage::kPlain) {
      compressed.push_back(std::move(all[i]));
      continue;
    }
    const char* storage = storage_name(all[i].storage);
    others.push_back({{"mesh", mesh}, {"primitive", primitive}, {"storage", storage}});
    others_text += describe_place(mesh, primitive) + ": " + storage + ", not split\n";
  }
  if (compressed.empty())
    session.log.warning("no primitive of " + arguments.input + " is split into patches, or stock Draco");

  if (arguments.format == "json") {
    Json primitives = Json::array();
    for (const InspectedPrimitive& primitive : compressed) primitives.push_back(to_json(primitive));
    const Json result{{"primitives", std::move(primitives)},
                      {"others", std::move(others)},
                      {"warnings", std::move(warnings)}};
    return write_text("-", report_text(result));
  }
  return write_text("-", to_text(compressed) + others_text);
}

}  // namespace

void add_inspect_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App& command =
      *app.add_subcommand("inspect", "Show the patches and Draco streams of an asset, and what they cost");
  command
      .add_option("IN", arguments->input,
                  "A .gltf, .glb, .drc, .ply, .obj, .stl or .off file, packed by gzip or not; - is stdin")
      ->required();
  add_format_option(command, arguments->format);
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
  command.callback([arguments, &action] {
    action = [arguments](const Session& session) { return run_inspect(*arguments, session); };
  });
}

}  // namespace psplit
