#include <algorithm>
#include <cmath>
#include <map>

#include "gltf_ext/json/json.h"
#include "src/container/patch_boxes.h"
#include "tools/gltf_psplit/inspect/inspected_asset.h"
#include "tools/gltf_psplit/report/asset_bytes.h"
#include "tools/gltf_psplit/report/encode_report.h"
#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/patch_summary.h"
#include "tools/gltf_psplit/report/text_layout.h"

namespace psplit {
namespace {

uint64_t whole(double bytes) { return static_cast<uint64_t>(std::llround(std::max(0.0, bytes))); }

struct AttributeSections {
  std::string semantic;
  uint64_t tokens = 0, bits = 0, flags = 0;
};

// Sizes of sections in whole bytes. `ends` has the remainder of rounding.
struct WholeSections {
  uint64_t numbers = 0, borders = 0, symbols = 0, seams = 0, ends = 0, stored = 0;
  std::vector<AttributeSections> attributes;
};

WholeSections whole_sections(const InspectedPrimitive& primitive) {
  const SectionBytes& sections = primitive.sections;
  WholeSections result{whole(sections.numbers),
                       whole(sections.borders),
                       whole(sections.symbols),
                       whole(sections.seams),
                       0,
                       0,
                       {}};
  const uint64_t condensed = whole(sections.total());
  uint64_t sum = result.numbers + result.borders + result.symbols + result.seams;
  for (size_t i = 0; i < sections.attributes.size(); ++i) {
    const SectionBytes::Attribute& bytes = sections.attributes[i];
    const AttributeSections attribute{
        i < primitive.section_attributes.size() ? primitive.section_attributes[i] : "unused",
        whole(bytes.tokens), whole(bytes.bits), whole(bytes.flags)};
    sum += attribute.tokens + attribute.bits + attribute.flags;
    result.attributes.push_back(attribute);
  }
  result.ends = condensed - std::min(condensed, sum);
  result.stored = primitive.summary.payload_bytes - std::min(primitive.summary.payload_bytes, condensed);
  return result;
}

// A title and a table with a row for each section that has bytes; empty if no patch is condensed.
std::string sections_text(const InspectedPrimitive& primitive) {
  const PatchSummary& summary = primitive.summary;
  if (summary.condensed_patches == 0) return "";
  TextTable table({"bytes", "share", "bits/point", "section"}, 0);
  table.align_last_left();
  const auto add = [&](const std::string& section, uint64_t bytes) {
    if (bytes == 0) return;
    const auto count = static_cast<double>(bytes);
    table.add({with_separators(bytes), as_share(count / static_cast<double>(summary.total_bytes)),
               with_decimals(8 * count / static_cast<double>(std::max<uint64_t>(1, summary.points)), 2),
               section});
  };
  const WholeSections sections = whole_sections(primitive);
  add("directory", summary.directory_bytes);
  add("head", summary.head_bytes - primitive.boxes_bytes);
  add("boxes of patches", primitive.boxes_bytes);
  add("stitch map", summary.stitch_bytes);
  add("plain numbers of patches", sections.numbers);
  add("connectivity: symbols", sections.symbols);
  add("connectivity: seams", sections.seams);
  add("values at borders, stored once", sections.borders);
  for (const AttributeSections& attribute : sections.attributes) {
    add(attribute.semantic + ": tokens", attribute.tokens);
    add(attribute.semantic + ": plain bits", attribute.bits);
    add(attribute.semantic + ": flags", attribute.flags);
  }
  add("ends of sections", sections.ends);
  add("streams that are not condensed", sections.stored);
  return describe_place(primitive.id.mesh, primitive.id.primitive) + ": " +
         with_separators(summary.condensed_patches) + " of " + counted(summary.patches, "patch") +
         " condensed\n" + table.to_string();
}

// Sizes of sections in bytes. The sections, the directory, the head and the stitch map are the whole container.
Json sections_json(const InspectedPrimitive& primitive) {
  const WholeSections sections = whole_sections(primitive);
  Json attributes = Json::array();
  for (const AttributeSections& attribute : sections.attributes)
    attributes.push_back({{"semantic", attribute.semantic},
                          {"tokens", attribute.tokens},
                          {"bits", attribute.bits},
                          {"flags", attribute.flags}});
  return {{"numbers", sections.numbers}, {"borders", sections.borders}, {"symbols", sections.symbols},
          {"seams", sections.seams},     {"ends", sections.ends},       {"stored_streams", sections.stored},
          {"attributes", attributes}};
}

// Of all positions that are in a box.
PatchBox box_of_all(std::span<const PatchBox> boxes) {
  PatchBox all = no_box();
  for (const PatchBox& box : boxes)
    for (size_t axis = 0; axis < all.low.size(); ++axis) {
      all.low[axis] = std::min(all.low[axis], box.low[axis]);
      all.high[axis] = std::max(all.high[axis], box.high[axis]);
    }
  return all;
}

// A line about the boxes of the streams; empty if there are none.
std::string boxes_text(const InspectedPrimitive& primitive) {
  if (primitive.boxes.empty()) return "";
  const PatchBox all = box_of_all(primitive.boxes);
  const auto corner = [](const std::array<double, 3>& position) {
    std::string text;
    for (const double number : position) text += (text.empty() ? "" : ", ") + with_digits(number, 4);
    return text;
  };
  return describe_place(primitive.id.mesh, primitive.id.primitive) + ": boxes of " +
         counted(primitive.boxes.size(), "stream") + " in " + counted(primitive.boxes_bytes, "byte") +
         ", from " + corner(all.low) + " to " + corner(all.high) + "\n";
}

// The box of each stream, the residue's last; null for one without positions.
Json boxes_json(const InspectedPrimitive& primitive) {
  const auto described = [](const PatchBox& box) {
    return box.low[0] > box.high[0] ? Json(nullptr) : Json({{"low", box.low}, {"high", box.high}});
  };
  Json streams = Json::array();
  for (const PatchBox& box : primitive.boxes) streams.push_back(described(box));
  return {{"bytes", primitive.boxes_bytes},
          {"all", described(box_of_all(primitive.boxes))},
          {"streams", std::move(streams)}};
}

const char* storage_name(PrimitiveStorage storage) {
  switch (storage) {
    case PrimitiveStorage::kPlain: return "plain";
    case PrimitiveStorage::kPatches: return "patches";
    case PrimitiveStorage::kStockDraco: return "draco";
  }
  return "";
}

Json to_json(const InspectedPrimitive& primitive) {
  Json object{{"mesh", primitive.id.mesh},
              {"primitive", primitive.id.primitive},
              {"storage", storage_name(primitive.storage)}};
  if (primitive.storage == PrimitiveStorage::kPlain) {
    object["faces"] = primitive.summary.faces;
    object["points"] = primitive.summary.points;
    return object;
  }
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
  if (primitive.summary.condensed_patches > 0) object["sections"] = sections_json(primitive);
  if (!primitive.boxes.empty()) object["boxes"] = boxes_json(primitive);
  return object;
}

std::string storage_text(const InspectedPrimitive& primitive) {
  return std::string(storage_name(primitive.storage)) +
         (primitive.summary.condensed_patches > 0 ? " (condensed)" : "");
}

// "POSITION 14 bits, JOINTS_0 exact, 69 morph targets of POSITION 8 to 11 bits"
std::string attributes_text(const InspectedPrimitive& primitive) {
  const auto bits_text = [](int bits) {
    return bits == 0 ? "exact" : counted(static_cast<uint64_t>(bits), "bit");
  };
  std::string text;
  const auto add = [&](const std::string& what, const std::string& bits) {
    text += (text.empty() ? "" : ", ") + what + " " + bits;
  };
  std::map<std::string, std::vector<int>> targets;  // the bits of each, by semantic
  for (size_t i = 0; i < primitive.attributes.size(); ++i)
    if (const auto target = target_of(primitive.attributes[i].semantic))
      targets[target->semantic].push_back(primitive.bits[i]);
    else
      add(primitive.attributes[i].semantic, bits_text(primitive.bits[i]));
  for (const auto& [semantic, bits] : targets) {
    const auto [least, most] = std::ranges::minmax(bits);
    add(counted(bits.size(), "morph target") + " of " + semantic,
        least == most ? bits_text(most) : bits_text(least) + " to " + bits_text(most));
  }
  return text;
}

// Each set of attributes once, with the number of primitives that have it.
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
        with_separators(summary.directory_bytes), with_separators(summary.head_bytes),
        with_separators(summary.stitch_bytes), with_separators(summary.total_bytes),
        with_decimals(summary.bits_per_point(), 2), attributes})
    row.push_back(cell);
  table.add(std::move(row));
}

std::string primitives_table(const InspectedAsset& asset, bool wide) {
  if (asset.compressed.empty()) return "";
  TextTable table(
      {"mesh", "primitive", "storage", "coding", "patches", "faces", "points", "references", "replication",
       "balance", "payload", "directory", "head", "stitch", "total bytes", "bits/point", "attributes"},
      0);
  table.align_last_left();
  for (const InspectedPrimitive& primitive : asset.compressed)
    add_row(table,
            {std::to_string(primitive.id.mesh), std::to_string(primitive.id.primitive), storage_text(primitive),
             primitive.coding ? coding_name(*primitive.coding) : ""},
            primitive.summary, attributes_text(primitive));
  if (asset.compressed.size() > 1) add_row(table, {"all", "", "", ""}, asset.sum(), "");
  std::string sections;
  for (const InspectedPrimitive& primitive : asset.compressed)
    sections += boxes_text(primitive) + sections_text(primitive);
  if (wide) return table.to_string() + sections;
  table.keep_columns(std::vector<std::string>{"mesh", "primitive", "storage", "coding", "patches", "faces",
                                              "points", "replication", "total bytes", "bits/point"});
  return table.to_string() + attribute_sets_text(asset) + sections;
}

}  // namespace

Json to_json(const InspectedAsset& asset) {
  Json result{{"file", asset.file}, {"bytes", asset.bytes.files}, {"texture_bytes", asset.bytes.textures}};
  for (const auto& [name, primitives] :
       {std::pair("primitives", &asset.compressed), {"others", &asset.plain}}) {
    result[name] = Json::array();
    for (const InspectedPrimitive& primitive : *primitives) result[name].push_back(to_json(primitive));
  }
  result["coarse"] = coarse_json(asset.coarse);
  result["warnings"] = asset.warnings;
  return result;
}

std::string to_text(const InspectedAsset& asset, bool wide) {
  std::string text = primitives_table(asset, wide);
  for (const InspectedPrimitive& primitive : asset.plain)
    text += describe_place(primitive.id.mesh, primitive.id.primitive) + ": plain, " +
            counted(primitive.summary.faces, "face") + ", " + counted(primitive.summary.points, "point") + "\n";
  const std::string coarse = coarse_text(asset.coarse);
  return text + coarse + (coarse.empty() ? "" : "\n");
}

std::string summary_text(const InspectedAsset& asset) {
  const std::string bytes = sizes_text({{0, 0}, asset.bytes});
  const PatchSummary sum = asset.sum();
  return asset.file + ": " + bytes + (bytes.empty() ? "" : ", ") + "mesh data " + as_bytes(sum.total_bytes) +
         " in " + counted(asset.compressed.size(), "primitive") + " and " + counted(sum.patches, "patch");
}

std::string to_text(std::span<const InspectedAsset> assets, bool wide) {
  TextTable table({"bytes", "textures", "primitives", "in patches", "draco", "plain", "patches", "faces",
                   "points", "references", "mesh bytes", "bits/point", "file"},
                  0);
  table.align_last_left();
  for (const InspectedAsset& asset : assets) {
    const PatchSummary sum = asset.sum();
    uint64_t faces = sum.faces, points = sum.points;
    for (const InspectedPrimitive& primitive : asset.plain) {
      faces += primitive.summary.faces;
      points += primitive.summary.points;
    }
    const auto split = static_cast<size_t>(
        std::ranges::count(asset.compressed, PrimitiveStorage::kPatches, &InspectedPrimitive::storage));
    table.add({with_separators(asset.bytes.files), with_separators(asset.bytes.textures),
               with_separators(asset.compressed.size() + asset.plain.size()), with_separators(split),
               with_separators(asset.compressed.size() - split), with_separators(asset.plain.size()),
               with_separators(sum.patches), with_separators(faces), with_separators(points),
               with_separators(sum.references), with_separators(sum.total_bytes),
               with_decimals(sum.bits_per_point(), 2), asset.file});
  }
  if (!wide)
    table.keep_columns(std::vector<std::string>{"bytes", "textures", "in patches", "draco", "plain", "patches",
                                                "faces", "mesh bytes", "file"});
  return table.to_string();
}

}  // namespace psplit
