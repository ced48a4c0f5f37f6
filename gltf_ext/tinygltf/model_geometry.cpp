#include "gltf_ext/tinygltf/model_geometry.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace psplit {
namespace {

// Some writers know only floats, and write 3.0 for 3.
std::optional<uint32_t> unsigned_value(const tinygltf::Value& value) {
  if (!value.IsNumber()) return std::nullopt;
  const double number = value.GetNumberAsDouble();
  if (!(number >= 0 && number <= 0xffffffffu) || std::floor(number) != number) return std::nullopt;
  return static_cast<uint32_t>(number);
}

template <typename T>
const T* element(const std::vector<T>& array, int64_t index) {
  return index < 0 || static_cast<uint64_t>(index) >= array.size() ? nullptr
                                                                   : &array[static_cast<size_t>(index)];
}

Expected<std::span<const uint8_t>> view_bytes(const tinygltf::Model& model, int index) {
  const tinygltf::BufferView* view = element(model.bufferViews, index);
  const tinygltf::Buffer* buffer = view == nullptr ? nullptr : element(model.buffers, view->buffer);
  if (buffer == nullptr) return invalid_input("the extension has no buffer view");
  const std::span<const uint8_t> bytes(buffer->data);
  if (view->byteOffset > bytes.size() || view->byteLength > bytes.size() - view->byteOffset)
    return invalid_input("the extension's buffer view leaves its buffer");
  return bytes.subspan(view->byteOffset, view->byteLength);
}

// Primitives with equal keys share one geometry.
struct Key {
  uint32_t view = 0;
  std::vector<std::pair<std::string, uint32_t>> attributes{};  // with their unique ids
  std::vector<int> accessors{};                                // of the attributes
  int indices = -1;
  Compression compression = Compression::kPatches;
  bool is_list = true;  // of triangles, not a strip

  auto operator<=>(const Key&) const = default;
};

Expected<Key> key_of(const tinygltf::Primitive& primitive, Compression compression,
                     const tinygltf::Value& extension) {
  const bool is_list = primitive.mode == TINYGLTF_MODE_TRIANGLES;
  if (compression == Compression::kPatches && !is_list)
    return invalid_input("patches are triangle lists, and the mode is another");
  if (!is_list && primitive.mode != TINYGLTF_MODE_TRIANGLE_STRIP)
    return invalid_input("Draco meshes are triangles, and the mode is another");
  if (!extension.IsObject()) return invalid_input("the extension is not an object");
  const auto view = unsigned_value(extension.Get("bufferView"));
  if (!view || *view > 0x7fffffffu) return invalid_input("the extension has no buffer view");
  const tinygltf::Value& attributes = extension.Get("attributes");
  if (!attributes.IsObject() || attributes.Size() == 0) return invalid_input("the extension has no attributes");
  Key key{*view, {}, {}, primitive.indices, compression, is_list};
  const auto add = [&](const std::string& name, const tinygltf::Value& id,
                       const std::map<std::string, int>& accessors, const std::string& semantic) -> Status {
    const auto unique_id = unsigned_value(id);
    const auto accessor = accessors.find(semantic);
    if (!unique_id) return invalid_input("the extension's attribute " + name + " has no unique id");
    if (accessor == accessors.end())
      return invalid_input("the extension's attribute " + name + " has no accessor");
    key.attributes.emplace_back(name, *unique_id);
    key.accessors.push_back(accessor->second);
    return {};
  };
  for (const std::string& semantic : attributes.Keys()) {
    Status status = add(semantic, attributes.Get(semantic), primitive.attributes, semantic);
    if (!status.ok()) return status;
  }
  if (compression != Compression::kPatches || !extension.Has("targets")) return key;
  const tinygltf::Value& targets = extension.Get("targets");
  if (!targets.IsObject()) return invalid_input("the extension's targets are not an object");
  for (const std::string& semantic : targets.Keys()) {
    const tinygltf::Value& ids = targets.Get(semantic);
    if (!ids.IsArray() || ids.ArrayLen() != primitive.targets.size())
      return invalid_input("the extension's " + semantic + " of targets are not as many as the primitive's");
    for (size_t t = 0; t < primitive.targets.size(); ++t) {
      const tinygltf::Value& id = ids.Get(static_cast<int>(t));
      if (id.IsNumber() && id.GetNumberAsInt() == -1) continue;
      Status status = add(name_of_target(t, semantic), id, primitive.targets[t], semantic);
      if (!status.ok()) return status;
    }
  }
  return key;
}

Expected<ModelGeometry> open_geometry(const tinygltf::Model& model, const Key& key, const OlderStreams* older) {
  const auto& [view, attributes, accessors, indices, compression, is_list] = key;
  const Expected<std::span<const uint8_t>> bytes = view_bytes(model, static_cast<int>(view));
  if (!bytes) return bytes.status();
  PrimitiveSource source;
  source.bytes = *bytes;
  source.compression = compression;
  source.older = older;
  for (size_t k = 0; k < attributes.size(); ++k) {
    const auto& [semantic, unique_id] = attributes[k];
    const tinygltf::Accessor* accessor = element(model.accessors, accessors[k]);
    if (accessor == nullptr) return invalid_input("the extension's attribute " + semantic + " has no accessor");
    const int components = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor->type));
    if (components < 1) return invalid_input("the accessor of " + semantic + " has no type");
    if (k > 0 && accessor->count != source.point_count)
      return invalid_input("the accessor of " + semantic + " has another count than others");
    if (accessor->count == 0) return invalid_input("the accessor of " + semantic + " is empty");
    source.point_count = accessor->count;
    source.attributes.push_back({semantic, unique_id, static_cast<ComponentType>(accessor->componentType),
                                 static_cast<uint8_t>(components), accessor->normalized});
  }
  uint32_t index_bytes = 0;
  if (indices >= 0) {
    const tinygltf::Accessor* accessor = element(model.accessors, indices);
    const int type = accessor == nullptr ? 0 : accessor->componentType;
    if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
        type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
      return invalid_input("the indices have no accessor of unsigned integers");
    // A strip's accessor may count the strip's indices. Decoding gives lists.
    if (is_list) source.index_count = accessor->count;
    index_bytes = type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT ? 4 : 2;
  }
  Expected<CompressedPrimitive> stored = CompressedPrimitive::open(std::move(source));
  if (!stored) return stored.status();
  if (index_bytes == 0) index_bytes = stored->least_index_bytes();
  if (index_bytes < stored->least_index_bytes())
    return invalid_input("there are more points than the accessor of the indices can name");
  return ModelGeometry{{}, static_cast<int>(view), indices, index_bytes, accessors, std::move(*stored)};
}

}  // namespace

Expected<std::vector<ModelGeometry>> find_geometries(const tinygltf::Model& model,
                                                     const ModelOptions& options) {
  if (options.known_extensions)
    for (const std::string& name : model.extensionsRequired)
      if (name != kExtensionName && name != kStockExtensionName &&
          std::find(options.known_extensions->begin(), options.known_extensions->end(), name) ==
              options.known_extensions->end())
        return unsupported("the extension " + name + " is required, and not known");

  std::vector<ModelGeometry> geometries;
  std::map<Key, size_t> known;
  for (size_t m = 0; m < model.meshes.size(); ++m)
    if (model.meshes[m].extensions.contains(kExtensionName))
      return invalid_input("has coarse primitives in place of its own: prepare_for_tinygltf replaces them",
                           Place{.mesh = static_cast<int64_t>(m)});
  for (size_t m = 0; m < model.meshes.size(); ++m)
    for (size_t p = 0; p < model.meshes[m].primitives.size(); ++p) {
      const tinygltf::Primitive& primitive = model.meshes[m].primitives[p];
      auto extension = primitive.extensions.find(kExtensionName);
      const bool has_patches = extension != primitive.extensions.end();
      if (!has_patches) extension = primitive.extensions.find(kStockExtensionName);
      if (extension == primitive.extensions.end()) continue;
      const PrimitivePlace at{m, p};
      Expected<Key> key =
          key_of(primitive, has_patches ? Compression::kPatches : Compression::kDraco, extension->second);
      if (!key) return key.status().at(at.place());
      const auto [found, is_new] = known.try_emplace(std::move(*key), geometries.size());
      if (is_new) {
        Expected<ModelGeometry> geometry = open_geometry(model, found->first, options.older);
        if (!geometry) return geometry.status().at(at.place());
        geometries.push_back(std::move(*geometry));
      }
      geometries[found->second].users.push_back(at);
    }
  // Each geometry is justified by its own bytes. Several may share these, so all together must be justified
  // too.
  std::map<int, uint64_t> view_bytes;
  uint64_t result_bytes = 0, stored_bytes = 0;
  for (const ModelGeometry& geometry : geometries) {
    view_bytes[geometry.view] = geometry.stored.bytes().size();
    result_bytes += uint64_t{3} * geometry.stored.face_count() * geometry.index_bytes;
    for (size_t k = 0; k < geometry.accessors.size(); ++k) result_bytes += geometry.stored.value_bytes(k);
  }
  for (const auto& [view, bytes] : view_bytes) stored_bytes += bytes;
  if (result_bytes > most_result_bytes(stored_bytes))
    return invalid_input("the primitives claim more data than their bytes justify");
  return geometries;
}

}  // namespace psplit
