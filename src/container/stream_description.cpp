#include "src/container/stream_description.h"

#include <map>
#include <set>

namespace psplit {
namespace {

// glTF's type for a Draco type. glTF attributes cannot be 32-bit integers or doubles, so these become floats.
ComponentType component_type(core::DataType type) {
  switch (type) {
    case core::DataType::kInt8: return ComponentType::kInt8;
    case core::DataType::kUint8:
    case core::DataType::kBool: return ComponentType::kUint8;
    case core::DataType::kInt16: return ComponentType::kInt16;
    case core::DataType::kUint16: return ComponentType::kUint16;
    default: return ComponentType::kFloat32;
  }
}

bool is_gltf_component_count(uint8_t count) { return (count >= 1 && count <= 4) || count == 9 || count == 16; }

// A semantic that glTF allows for the attribute's data. Attributes that share a name are numbered. `used`
// counts the attributes of each name: hostile streams have thousands.
std::string gltf_semantic(const StreamAttribute& attribute, ComponentType type,
                          std::map<std::string, uint32_t>& used) {
  const int components = attribute.components;
  const bool is_float = type == ComponentType::kFloat32;
  const auto is_first = [&](DracoSemantic semantic, const char* name) {
    return attribute.semantic == semantic && is_float && components == 3 && used[name]++ == 0;
  };
  if (is_first(DracoSemantic::kPosition, "POSITION")) return "POSITION";
  if (is_first(DracoSemantic::kNormal, "NORMAL")) return "NORMAL";
  std::string prefix = "_GENERIC_";
  if (attribute.semantic == DracoSemantic::kTexCoord && is_float && components == 2) prefix = "TEXCOORD_";
  if (attribute.semantic == DracoSemantic::kColor && components >= 3 && components <= 4 &&
      type != ComponentType::kInt8 && type != ComponentType::kInt16)
    prefix = "COLOR_";
  return prefix + std::to_string(used[prefix]++);
}

}  // namespace

const char* coding_name(StreamCoding coding) {
  switch (coding) {
    case StreamCoding::kSequential: return "sequential";
    case StreamCoding::kEdgebreaker: return "edgebreaker";
    case StreamCoding::kEdgebreakerPredictive: return "edgebreaker-predictive";
    case StreamCoding::kEdgebreakerValence: return "edgebreaker-valence";
    case StreamCoding::kCloudSequential: return "cloud-sequential";
    case StreamCoding::kCloudKdTree: return "cloud-kd-tree";
  }
  return "";
}

Expected<std::vector<AttributeRequest>> gltf_attributes(Span<const StreamAttribute> attributes) {
  std::vector<AttributeRequest> requests;
  std::set<uint32_t> unique_ids;
  std::map<std::string, uint32_t> used;
  for (const StreamAttribute& attribute : attributes) {
    if (!is_gltf_component_count(attribute.components))
      return unsupported("an attribute has " + std::to_string(attribute.components) +
                         " components, which no glTF type has");
    if (!unique_ids.insert(attribute.unique_id).second)
      return invalid_input("two attributes have the unique id " + std::to_string(attribute.unique_id));
    AttributeRequest request;
    request.unique_id = attribute.unique_id;
    request.component_type = component_type(attribute.type);
    request.component_count = attribute.components;
    request.semantic = gltf_semantic(attribute, request.component_type, used);
    request.normalized = request.component_type != ComponentType::kFloat32 &&
                         (attribute.normalized || request.semantic.starts_with("COLOR_"));
    requests.push_back(std::move(request));
  }
  if (!used.contains("POSITION")) return invalid_input("has no positions");
  return requests;
}

}  // namespace psplit
