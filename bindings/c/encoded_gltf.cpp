// An encoded mesh in glTF: its JSON, and a whole file.
#include <algorithm>
#include <set>

#include "bindings/c/encoded.h"
#include "bindings/c/support.h"
#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/json/bound_json.h"
#include "gltf_ext/json/extension_names.h"
#include "gltf_ext/json/glb.h"
#include "gltf_ext/json/json.h"
#include "gltf_ext/json/json_text.h"
#include "src/loader/check_buffers.h"

namespace psplit::c {
namespace {

// What glTF gets of a mesh: accessors, a primitive that refers to them, and the names of extensions.
struct GltfParts {
  Json accessors = Json::array();
  Json primitive{};
  std::set<std::string> extensions{};
};

Json accessor_of(const AttributeRequest& request, uint32_t count, const ValueBounds& bounds) {
  Json accessor{{"componentType", static_cast<int>(request.component_type)}, {"count", count}};
  if (request.normalized) accessor["normalized"] = true;
  accessor["type"] = type_name(*layout_of(request.component_type, request.component_count));
  accessor["min"] = bound_json(bounds.least, request.component_type);
  accessor["max"] = bound_json(bounds.most, request.component_type);
  return accessor;
}

// Sets what the extension and the primitive say of a morph target: the former has an id of each target, or -1.
void add_target(const MorphTarget& target, uint32_t id, size_t accessor, size_t target_count, Json& primitive,
                Json& extension) {
  primitive["targets"][target.number][target.semantic] = accessor;
  Json& ids = extension["targets"][target.semantic];
  if (ids.is_null()) ids = std::vector<int>(target_count, -1);
  ids[target.number] = id;
}

Expected<GltfParts> parts_of(const psplit_encoded& encoded, size_t first_accessor, size_t view) {
  if (encoded.kind == PSPLIT_KIND_DRACO_FILE) return unsupported("glTF has no compressed point clouds");
  const bool is_patches = encoded.kind == PSPLIT_KIND_PATCHES;
  const char* const name = is_patches ? kExtensionName : kStockExtensionName;
  GltfParts parts;
  parts.extensions.insert(name);
  const auto point_count = static_cast<uint32_t>(encoded.source_points.size());
  size_t target_count = 0;
  for (const AttributeRequest& request : encoded.requests)
    if (const auto target = target_of(request.semantic)) {
      if (target->number >= encoded.requests.size())
        return unsupported(request.semantic + ": there are fewer morph targets than that");
      target_count = std::max(target_count, target->number + 1);
    }
  Json extension{{"bufferView", view}, {"attributes", Json::object()}};
  Json& primitive = parts.primitive;
  primitive = {{"attributes", Json::object()}};
  if (target_count > 0) primitive["targets"] = std::vector<Json>(target_count, Json::object());
  for (size_t k = 0; k < encoded.requests.size(); ++k) {
    const AttributeRequest& request = encoded.requests[k];
    if (!layout_of(request.component_type, request.component_count))
      return unsupported(request.semantic + " has " + std::to_string(request.component_count) +
                         " components, which no type of glTF has");
    const size_t accessor = first_accessor + k;
    const auto target = target_of(request.semantic);
    if (target && !is_patches)
      return unsupported(request.semantic + ": " + name + " has no morph targets; encode patches");
    if (target) {
      add_target(*target, request.unique_id, accessor, target_count, primitive, extension);
    } else {
      primitive["attributes"][request.semantic] = accessor;
      extension["attributes"][request.semantic] = request.unique_id;
    }
    if (needs_mesh_quantization(target ? target->semantic : request.semantic, request.component_type,
                                request.normalized))
      parts.extensions.insert(kQuantizationExtensionName);
    parts.accessors.push_back(accessor_of(request, point_count, encoded.storage[k].bounds));
  }
  const bool fits = least_index_bytes(point_count) == 2;
  parts.accessors.push_back(
      {{"componentType", static_cast<int>(fits ? ComponentType::kUint16 : ComponentType::kUint32)},
       {"count", uint64_t{3} * encoded.face_count},
       {"type", "SCALAR"}});
  primitive["indices"] = first_accessor + encoded.requests.size();
  primitive["extensions"][name] = std::move(extension);
  return parts;
}

std::unique_ptr<psplit_output> output_of(std::vector<uint8_t> bytes) {
  return std::unique_ptr<psplit_output>(new psplit_output{std::move(bytes)});
}

Expected<std::unique_ptr<psplit_output>> write_json(const psplit_encoded& encoded, uint32_t first_accessor,
                                                    uint32_t view) {
  Expected<GltfParts> parts = parts_of(encoded, first_accessor, view);
  if (!parts) return parts.status();
  const Json json{{"primitive", std::move(parts->primitive)},
                  {"accessors", std::move(parts->accessors)},
                  {"extensions", parts->extensions}};
  const std::string text = json_line(json);
  std::vector<uint8_t> bytes(text.begin(), text.end());
  bytes.push_back(0);
  return output_of(std::move(bytes));
}

Expected<std::unique_ptr<psplit_output>> write_glb(const psplit_encoded& encoded) {
  Expected<GltfParts> parts = parts_of(encoded, 0, 0);
  if (!parts) return parts.status();
  const size_t padded = (encoded.bytes.size() + 3) / 4 * 4;
  Json json{{"asset", {{"version", "2.0"}, {"generator", "psplit"}}},
            {"extensionsUsed", parts->extensions},
            {"extensionsRequired", parts->extensions},
            {"scene", 0}};
  json["scenes"] = Json::array({{{"nodes", Json::array({0})}}});
  json["nodes"] = Json::array({{{"mesh", 0}}});
  json["meshes"] = Json::array({{{"primitives", Json::array({std::move(parts->primitive)})}}});
  json["accessors"] = std::move(parts->accessors);
  json["bufferViews"] = Json::array({{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", encoded.bytes.size()}}});
  json["buffers"] = Json::array({{{"byteLength", padded}}});
  Expected<std::vector<uint8_t>> file = glb_head(json_line(json), padded);
  if (!file) return file.status();
  file->insert(file->end(), encoded.bytes.begin(), encoded.bytes.end());
  file->resize((file->size() + 3) / 4 * 4);
  return output_of(std::move(*file));
}

}  // namespace
}  // namespace psplit::c

using namespace psplit;
using namespace psplit::c;

psplit_code psplit_encoded_write_json(const psplit_encoded* encoded, uint32_t first_accessor,
                                      uint32_t buffer_view, psplit_output** output, psplit_error* error) {
  return make_handle(output, error, [&]() -> Expected<std::unique_ptr<psplit_output>> {
    if (encoded == nullptr) return null_handle();
    return write_json(*encoded, first_accessor, buffer_view);
  });
}

psplit_code psplit_encoded_write_glb(const psplit_encoded* encoded, psplit_output** output,
                                     psplit_error* error) {
  return make_handle(output, error, [&]() -> Expected<std::unique_ptr<psplit_output>> {
    if (encoded == nullptr) return null_handle();
    return write_glb(*encoded);
  });
}

const void* psplit_output_data(const psplit_output* output) {
  return output == nullptr ? nullptr : output->bytes.data();
}
size_t psplit_output_size(const psplit_output* output) { return output == nullptr ? 0 : output->bytes.size(); }
void psplit_output_free(psplit_output* output) { delete output; }
