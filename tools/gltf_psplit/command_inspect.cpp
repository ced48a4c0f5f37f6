// gltf-psplit inspect: what the patches of an asset are and cost.
#include <CLI/CLI.hpp>
#include <memory>

#include "encoder/draco/draco_backend.h"
#include "tools/gltf_psplit/commands.h"
#include "tools/gltf_psplit/patch_summary.h"

namespace psplit {
namespace {

struct Arguments {
  std::string input, format = "text";
};

struct InspectedPrimitive {
  PrimitiveId id;
  PatchSummary summary;
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

Expected<InspectedPrimitive> inspect_primitive(const Document& document, PrimitiveId id) {
  const Expected<PatchedPrimitive> patched = patched_primitive(document, id);
  if (!patched) return patched.status();
  const Expected<Container> container = parse_container(patched->container);
  if (!container) return container.status();
  const Expected<PatchSummary> summary = summarize_container(patched->container);
  if (!summary) return summary.status();
  InspectedPrimitive inspected{id, *summary, patched->requests, {}};
  inspected.bits.assign(inspected.attributes.size(), 0);
  // All streams of a container are coded alike.
  if (!container->streams.empty()) {
    Expected<std::vector<int>> bits = stream_attribute_bits(container->streams[0], inspected.attributes);
    if (!bits) return bits.status().at({.patch = 0});
    inspected.bits = std::move(*bits);
  }
  return inspected;
}

Json to_json(const InspectedPrimitive& primitive) {
  Json object{{"mesh", primitive.id.mesh}, {"primitive", primitive.id.primitive}};
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

std::string attributes_text(const InspectedPrimitive& primitive) {
  std::string text;
  for (size_t i = 0; i < primitive.attributes.size(); ++i) {
    text += (i == 0 ? "" : ", ") + primitive.attributes[i].semantic + " ";
    text += primitive.bits[i] == 0 ? "exact" : counted(static_cast<uint64_t>(primitive.bits[i]), "bit");
  }
  return text;
}

void add_row(TextTable& table, const std::string& mesh, const std::string& primitive,
             const PatchSummary& summary, const std::string& attributes) {
  table.add({mesh, primitive, with_separators(summary.patches), with_separators(summary.faces),
             with_separators(summary.points), with_separators(summary.references),
             as_share(summary.replication()), with_decimals(summary.balance(), 3),
             with_separators(summary.payload_bytes), with_separators(summary.directory_bytes),
             with_separators(summary.stitch_bytes), with_separators(summary.total_bytes),
             with_decimals(summary.bits_per_point(), 2), attributes});
}

Status run_inspect(const Arguments& arguments, const Session& session) {
  const Expected<Document> document = read_input(arguments.input);
  if (!document) return document.status();
  std::vector<InspectedPrimitive> patched;
  Json others = Json::array();
  std::string others_text;
  for (const PrimitiveId id : all_primitives(*document)) {
    const Place place{.file = arguments.input,
                      .mesh = static_cast<int64_t>(id.mesh),
                      .primitive = static_cast<int64_t>(id.primitive)};
    const Expected<PrimitiveKind> kind = primitive_kind(*document, id);
    if (!kind) return kind.status().at(place);
    if (kind->storage != PrimitiveStorage::kPatches) {
      others.push_back(
          {{"mesh", id.mesh}, {"primitive", id.primitive}, {"storage", storage_name(kind->storage)}});
      others_text +=
          describe_place(id.mesh, id.primitive) + ": " + storage_name(kind->storage) + ", not split\n";
      continue;
    }
    Expected<InspectedPrimitive> inspected = inspect_primitive(*document, id);
    if (!inspected) return inspected.status().at(place);
    patched.push_back(std::move(*inspected));
  }
  if (patched.empty()) session.log.warning("no primitive of " + arguments.input + " is split into patches");

  if (arguments.format == "json") {
    Json primitives = Json::array();
    for (const InspectedPrimitive& primitive : patched) primitives.push_back(to_json(primitive));
    const Json result{{"primitives", std::move(primitives)}, {"others", std::move(others)}};
    return write_text("-", result.dump(2) + "\n");
  }
  TextTable table({"mesh", "primitive", "patches", "faces", "points", "references", "replication", "balance",
                   "payload", "directory", "stitch", "total bytes", "bits/point", "attributes"},
                  0);
  PatchSummary sum;
  for (const InspectedPrimitive& primitive : patched) {
    add_row(table, std::to_string(primitive.id.mesh), std::to_string(primitive.id.primitive), primitive.summary,
            attributes_text(primitive));
    sum += primitive.summary;
  }
  if (patched.size() > 1) add_row(table, "all", "", sum, "");
  return write_text("-", (patched.empty() ? "" : table.to_string()) + others_text);
}

}  // namespace

void add_inspect_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App& command = *app.add_subcommand("inspect", "Show the patches of an asset and what they cost");
  command.add_option("IN", arguments->input, "A .gltf or .glb file; - is a GLB on stdin")->required();
  add_format_option(command, arguments->format);
  command.callback([arguments, &action] {
    action = [arguments](const Session& session) { return run_inspect(*arguments, session); };
  });
}

}  // namespace psplit
