#include "gltf_ext/convert/texture_reads.h"

#include <algorithm>
#include <cmath>

#include "gltf_ext/document/references.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

double scale_of(const Json& transform) {
  double largest = 1;
  for_each_element(transform, "scale", [&](const Json& scale) {
    if (scale.is_number()) largest = std::max(largest, std::fabs(scale.get<double>()));
  });
  return std::isfinite(largest) ? largest : 1;
}

}  // namespace

void collect_texture_reads(const Json& tree, TextureReads& reads) {
  if (!tree.is_structured()) return;
  if (tree.is_object() && field(tree, "index") != nullptr) {
    const auto add = [&](int64_t set, double scale) {
      double& largest = reads.emplace(set, 1).first->second;
      largest = std::max(largest, scale);
    };
    const int64_t stated = integer_field(tree, "texCoord").value_or(0);
    add(stated, 1);
    if (const Json* transform = extension_field(tree, "KHR_texture_transform"))
      add(integer_field(*transform, "texCoord").value_or(stated), scale_of(*transform));
  }
  for (auto member = tree.begin(); member != tree.end(); ++member)
    if (!tree.is_object() || member.key() != "extras") collect_texture_reads(*member, reads);
}

std::set<int64_t> materials_of(const Json& primitive) {
  std::set<int64_t> materials;
  if (const auto material = integer_field(primitive, "material")) materials.insert(*material);
  if (const Json* variants = extension_field(primitive, "KHR_materials_variants"))
    for_each_element(*variants, "mappings", [&](const Json& mapping) {
      if (const auto material = integer_field(mapping, "material")) materials.insert(*material);
    });
  return materials;
}

std::map<std::string, double> texture_scales(const Document& document, std::span<const PrimitiveId> ids) {
  TextureReads reads;
  for (const PrimitiveId id : ids)
    for (const int64_t material : materials_of(primitive_json(document, id)))
      if (const Json* tree = top_level_object(document.json(), "materials", material))
        collect_texture_reads(*tree, reads);
  std::map<std::string, double> scales;
  for (const auto& [set, scale] : reads) scales["TEXCOORD_" + std::to_string(set)] = scale;
  return scales;
}

}  // namespace psplit
