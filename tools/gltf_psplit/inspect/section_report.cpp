#include "tools/gltf_psplit/inspect/section_report.h"

#include <cmath>

#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/text_layout.h"

namespace psplit {
namespace {

uint64_t whole(double bytes) { return static_cast<uint64_t>(std::llround(std::max(0.0, bytes))); }

struct AttributeSections {
  std::string semantic;
  uint64_t tokens = 0, bits = 0, flags = 0;
};

// In whole bytes. What rounding leaves over is among the ends.
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

}  // namespace

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
  add("head", summary.head_bytes);
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

}  // namespace psplit
