#include <algorithm>
#include <cstring>

#include "gltf_ext/tinygltf/model_geometry.h"
#include "psplit/tinygltf.h"

namespace psplit {
namespace {

size_t aligned(size_t bytes) { return (bytes + 3) / 4 * 4; }

// The layout of an accessor's elements in a buffer view of vertex data: elements, and columns of matrices,
// begin at multiples of 4.
struct AccessorLayout {
  size_t columns = 1, column_bytes = 0;  // as decoded, without padding

  explicit AccessorLayout(const tinygltf::Accessor& accessor) {
    const auto type = static_cast<uint32_t>(accessor.type);
    if (type == TINYGLTF_TYPE_MAT2) columns = 2;
    if (type == TINYGLTF_TYPE_MAT3) columns = 3;
    if (type == TINYGLTF_TYPE_MAT4) columns = 4;
    column_bytes = static_cast<size_t>(tinygltf::GetNumComponentsInType(type)) / columns *
                   component_bytes(static_cast<ComponentType>(accessor.componentType));
  }
  size_t stride() const { return columns == 1 ? aligned(column_bytes) : columns * aligned(column_bytes); }
  // Moves the columns of each decoded element to their places.
  void spread(std::span<std::byte> elements) const {
    if (columns == 1 || aligned(column_bytes) == column_bytes) return;
    for (size_t at = 0; at < elements.size(); at += stride())
      for (size_t column = columns; column-- > 1;)
        std::memmove(&elements[at + column * aligned(column_bytes)], &elements[at + column * column_bytes],
                     column_bytes);
  }
};

// The layout of the new buffer: for each geometry its indices, then its attributes.
struct Layout {
  struct Part {
    size_t offset = 0, bytes = 0, stride = 0;
  };
  std::vector<std::vector<Part>> parts;  // of each geometry
  size_t bytes = 0;

  void add(size_t count, size_t stride) {
    parts.back().push_back({bytes, count * stride, stride});
    bytes += aligned(count * stride);
  }
};

Layout lay_out(const tinygltf::Model& model, const std::vector<ModelGeometry>& geometries) {
  Layout layout;
  for (const ModelGeometry& geometry : geometries) {
    layout.parts.emplace_back();
    layout.add(size_t{3} * geometry.stored.face_count(), geometry.index_bytes);
    for (const int accessor : geometry.accessors)
      layout.add(geometry.stored.point_count(),
                 AccessorLayout(model.accessors[static_cast<size_t>(accessor)]).stride());
  }
  return layout;
}

// The number of users of each accessor in glTF's core.
std::vector<size_t> count_users(const tinygltf::Model& model) {
  std::vector<size_t> users(model.accessors.size());
  const auto add = [&](int accessor) {
    if (accessor >= 0 && static_cast<size_t>(accessor) < users.size()) ++users[static_cast<size_t>(accessor)];
  };
  const auto add_all = [&](const std::map<std::string, int>& attributes) {
    for (const auto& [semantic, accessor] : attributes) add(accessor);
  };
  for (const tinygltf::Mesh& mesh : model.meshes)
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      add(primitive.indices);
      add_all(primitive.attributes);
      for (const auto& target : primitive.targets) add_all(target);
    }
  for (const tinygltf::Skin& skin : model.skins) add(skin.inverseBindMatrices);
  for (const tinygltf::Animation& animation : model.animations)
    for (const tinygltf::AnimationSampler& sampler : animation.samplers) {
      add(sampler.input);
      add(sampler.output);
    }
  return users;
}

class ModelEditor {
 public:
  explicit ModelEditor(tinygltf::Model& model)
      : model_(model), users_(count_users(model)), buffer_(static_cast<int>(model.buffers.size())) {}

  void set(const ModelGeometry& geometry, const std::vector<Layout::Part>& parts) {
    const size_t index_count = size_t{3} * geometry.stored.face_count();
    const int indices = accessor_for(geometry, geometry.indices);
    tinygltf::Accessor& accessor = model_.accessors[static_cast<size_t>(indices)];
    accessor.type = TINYGLTF_TYPE_SCALAR;
    accessor.componentType = geometry.index_bytes == 2 ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT
                                                       : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    point(accessor, index_count, parts[0], TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    for (const PrimitivePlace& user : geometry.users) primitive(user).indices = indices;
    for (size_t k = 0; k < geometry.accessors.size(); ++k) {
      const int number = accessor_for(geometry, geometry.accessors[k]);
      point(model_.accessors[static_cast<size_t>(number)], geometry.stored.point_count(), parts[1 + k],
            TINYGLTF_TARGET_ARRAY_BUFFER);
      const std::string& name = geometry.stored.attributes()[k].semantic;
      const auto target = target_of(name);
      for (const PrimitivePlace& user : geometry.users)
        (target ? primitive(user).targets[target->number][target->semantic]
                : primitive(user).attributes[name]) = number;
    }
    for (const PrimitivePlace& user : geometry.users) {
      primitive(user).mode = TINYGLTF_MODE_TRIANGLES;
      for (const char* const extension : kDracoExtensions) primitive(user).extensions.erase(extension);
    }
    // Indices give back the view that they borrowed.
    model_.bufferViews[static_cast<size_t>(geometry.view)].target = 0;
    if (geometry.indices >= 0 && geometry.indices != indices) {
      tinygltf::Accessor& left = model_.accessors[static_cast<size_t>(geometry.indices)];
      if (left.bufferView == geometry.view) left.bufferView = -1;
    }
  }

  void finish(std::vector<unsigned char> data) {
    model_.buffers.emplace_back();
    model_.buffers.back().data = std::move(data);
    for (std::vector<std::string>* list : {&model_.extensionsUsed, &model_.extensionsRequired})
      for (const char* const extension : kDracoExtensions) std::erase(*list, extension);
  }

 private:
  tinygltf::Primitive& primitive(const PrimitivePlace& place) {
    return model_.meshes[place.mesh].primitives[place.primitive];
  }

  // The accessor itself if nothing else uses it, otherwise a copy. A new one if there is none.
  int accessor_for(const ModelGeometry& geometry, int accessor) {
    if (accessor >= 0 && users_[static_cast<size_t>(accessor)] == geometry.users.size()) return accessor;
    model_.accessors.push_back(accessor < 0 ? tinygltf::Accessor()
                                            : model_.accessors[static_cast<size_t>(accessor)]);
    return static_cast<int>(model_.accessors.size() - 1);
  }

  void point(tinygltf::Accessor& accessor, size_t count, const Layout::Part& part, int target) {
    tinygltf::BufferView view;
    view.buffer = buffer_;
    view.byteOffset = part.offset;
    view.byteLength = part.bytes;
    view.byteStride = target == TINYGLTF_TARGET_ARRAY_BUFFER ? part.stride : 0;
    view.target = target;
    accessor.bufferView = static_cast<int>(model_.bufferViews.size());
    accessor.byteOffset = 0;
    accessor.count = count;
    accessor.sparse.isSparse = false;
    model_.bufferViews.push_back(std::move(view));
  }

  tinygltf::Model& model_;
  const std::vector<size_t> users_;
  const int buffer_;
};

}  // namespace

Status decode_model(tinygltf::Model& model, const ModelOptions& options) {
  const Expected<std::vector<ModelGeometry>> geometries = find_geometries(model, options);
  if (!geometries) return geometries.status();
  if (geometries->empty()) return {};

  const Layout layout = lay_out(model, *geometries);
  std::vector<unsigned char> data(layout.bytes);
  const std::span<std::byte> bytes = std::as_writable_bytes(std::span(data));
  std::vector<PrimitiveLoad> loads;
  for (size_t g = 0; g < geometries->size(); ++g) {
    const std::vector<Layout::Part>& parts = layout.parts[g];
    PrimitiveBuffers out{bytes.subspan(parts[0].offset, parts[0].bytes), (*geometries)[g].index_bytes};
    for (size_t k = 1; k < parts.size(); ++k)
      out.attributes.push_back({bytes.subspan(parts[k].offset, parts[k].bytes), parts[k].stride});
    loads.push_back({(*geometries)[g].stored, std::move(out)});
  }
  const std::vector<Status> statuses = decode_primitives(loads, options);
  for (size_t g = 0; g < statuses.size(); ++g)
    if (!statuses[g].ok()) return Status(statuses[g]).at((*geometries)[g].users.front().place());

  for (size_t g = 0; g < geometries->size(); ++g)
    for (size_t k = 0; k < (*geometries)[g].accessors.size(); ++k) {
      const int accessor = (*geometries)[g].accessors[k];
      AccessorLayout(model.accessors[static_cast<size_t>(accessor)]).spread(loads[g].out.attributes[k].bytes);
    }
  ModelEditor editor(model);
  for (size_t g = 0; g < geometries->size(); ++g) editor.set((*geometries)[g], layout.parts[g]);
  editor.finish(std::move(data));
  return {};
}

}  // namespace psplit
