#include <map>
#include <set>

#include "psplit/decode.h"

namespace psplit {
namespace {

// glTF's type for a Draco type. glTF attributes cannot be 32-bit integers or doubles, so these become floats.
ComponentType component_type(DataType type) {
  switch (type) {
    case DataType::kInt8: return ComponentType::kInt8;
    case DataType::kUint8:
    case DataType::kBool: return ComponentType::kUint8;
    case DataType::kInt16: return ComponentType::kInt16;
    case DataType::kUint16: return ComponentType::kUint16;
    default: return ComponentType::kFloat32;
  }
}

bool is_gltf_component_count(uint8_t count) { return (count >= 1 && count <= 4) || count == 9 || count == 16; }

// Whether glTF allows the attribute's data for its semantic: floats, or integers of 8 or 16 bits with
// KHR_mesh_quantization. Integers of normals are parts of one.
bool suits_semantic(const StreamAttribute& attribute, ComponentType type) {
  const bool is_float = type == ComponentType::kFloat32;
  const bool is_signed = type == ComponentType::kInt8 || type == ComponentType::kInt16;
  switch (attribute.semantic) {
    case DracoSemantic::kPosition: return attribute.components == 3;
    case DracoSemantic::kNormal:
      return attribute.components == 3 && (is_float || (is_signed && attribute.normalized));
    case DracoSemantic::kTexCoord: return attribute.components == 2;
    case DracoSemantic::kColor: return attribute.components >= 3 && attribute.components <= 4 && !is_signed;
    case DracoSemantic::kGeneric: break;
  }
  return false;
}

// A semantic that glTF allows for the attribute's data. Attributes that share a name are numbered. `used`
// counts the attributes of each name: hostile streams have thousands.
std::string gltf_semantic(const StreamAttribute& attribute, ComponentType type,
                          std::map<std::string, uint32_t>& used) {
  const bool suits = suits_semantic(attribute, type);
  const auto is_first = [&](DracoSemantic semantic, const char* name) {
    return attribute.semantic == semantic && suits && used[name]++ == 0;
  };
  if (is_first(DracoSemantic::kPosition, "POSITION")) return "POSITION";
  if (is_first(DracoSemantic::kNormal, "NORMAL")) return "NORMAL";
  std::string prefix = "_GENERIC_";
  if (attribute.semantic == DracoSemantic::kTexCoord && suits) prefix = "TEXCOORD_";
  if (attribute.semantic == DracoSemantic::kColor && suits) prefix = "COLOR_";
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
