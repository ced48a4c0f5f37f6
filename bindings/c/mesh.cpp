// Opens and describes meshes.
#include "bindings/c/mesh.h"

#include <algorithm>

#include "src/container/claims.h"
#include "src/container/patch_container.h"
#include "src/container/stored_type.h"
#include "src/loader/check_buffers.h"
#include "src/loader/older_streams.h"

namespace psplit::c {
namespace {

DracoSemantic semantic_of(const std::string& name) {
  if (name == "POSITION") return DracoSemantic::kPosition;
  if (name == "NORMAL") return DracoSemantic::kNormal;
  if (name.starts_with("COLOR_")) return DracoSemantic::kColor;
  if (name.starts_with("TEXCOORD_")) return DracoSemantic::kTexCoord;
  return DracoSemantic::kGeneric;
}

Expected<std::vector<AttributeRequest>> read_requests(const psplit_source& source) {
  const Expected<std::vector<psplit_attribute_request>> elements =
      read_array(source.attributes, source.attribute_count, "psplit_attribute_request");
  if (!elements) return elements.status();
  std::vector<AttributeRequest> requests;
  for (const psplit_attribute_request& element : *elements) {
    if (element.name == nullptr) return wrong_usage("an attribute has no name");
    if (element.reserved != 0) return wrong_usage("psplit_attribute_request: `reserved` is not 0");
    const std::string name = element.name;
    const std::optional<ComponentType> type = component_type_of(element.type);
    if (!type) return unsupported(name + " has the type " + std::to_string(element.type));
    if (element.components > 16)
      return invalid_input(name + " has " + std::to_string(element.components) + " components");
    requests.push_back(
        {name, element.unique_id, *type, static_cast<uint8_t>(element.components), element.normalized != 0});
  }
  return requests;
}

// Names that glTF would allow, or empty ones.
std::vector<std::string> names_of(std::span<const StreamAttribute> attributes) {
  std::vector<std::string> names(attributes.size());
  const Expected<std::vector<AttributeRequest>> requests = gltf_attributes(attributes);
  for (size_t i = 0; requests && i < names.size(); ++i) names[i] = (*requests)[i].semantic;
  return names;
}

Status check_count(const char* what, uint64_t stated, uint64_t count) {
  if (stated == 0 || stated == count) return {};
  return invalid_input("the caller has " + std::to_string(stated) + " " + what + ", the stream has " +
                       std::to_string(count));
}

// A file of a bitstream before 2.2. Its values have types of glTF.
Expected<std::unique_ptr<psplit_mesh>> open_older_file(const psplit_source& source,
                                                       std::span<const uint8_t> bytes, const Status& refusal) {
  Expected<StreamDescription> description = describe_older(built_in_older_streams(), bytes, refusal);
  if (!description) return description.status();
  Expected<std::vector<AttributeRequest>> requests = gltf_attributes(description->attributes);
  if (!requests) return requests.status();
  if (Status status = check_count("points", source.point_count, description->point_count); !status.ok())
    return status;
  if (Status status = check_count("indices", source.index_count, uint64_t{3} * description->face_count);
      !status.ok())
    return status;
  if (Status status = check_results(description->point_count, description->face_count, *requests, bytes.size());
      !status.ok())
    return status;
  auto mesh = std::make_unique<psplit_mesh>();
  mesh->kind = PSPLIT_KIND_DRACO_FILE;
  for (size_t i = 0; i < requests->size(); ++i) {
    const AttributeRequest& request = (*requests)[i];
    mesh->attributes.push_back({request.semantic, request.unique_id, description->attributes[i].semantic,
                                stored_type(request.component_type), request.component_count,
                                request.normalized, request.value_bytes()});
  }
  mesh->file = {bytes, std::move(*description), std::move(*requests)};
  return mesh;
}

Expected<std::unique_ptr<psplit_mesh>> open_file(const psplit_source& source, std::span<const uint8_t> bytes) {
  if (source.attribute_count > 0) return wrong_usage("a whole Draco stream takes no attributes");
  Expected<StreamOutline> outline = outline_stream(bytes);
  if (!outline) return open_older_file(source, bytes, outline.status());
  const StreamDescription& description = outline->description;
  if (Status status = check_count("points", source.point_count, description.point_count); !status.ok())
    return status;
  if (Status status = check_count("indices", source.index_count, uint64_t{3} * description.face_count);
      !status.ok())
    return status;
  auto mesh = std::make_unique<psplit_mesh>();
  mesh->kind = PSPLIT_KIND_DRACO_FILE;
  std::vector<std::string> names = names_of(description.attributes);
  uint64_t point_bytes = 0;
  for (size_t i = 0; i < names.size(); ++i) {
    const StreamAttribute& stored = description.attributes[i];
    const GeometryAttribute decoded{
        stored, {}, (source.flags & PSPLIT_INTEGERS) != 0 && outline->stored[i].has_integers};
    point_bytes += decoded.stride();
    mesh->attributes.push_back({std::move(names[i]), stored.unique_id, stored.semantic, decoded.type(),
                                decoded.component_count(), stored.normalized, decoded.stride(),
                                decoded.are_integers});
  }
  if (Status status = check_results(description.point_count, description.face_count, point_bytes, bytes.size());
      !status.ok())
    return status;
  mesh->file = {bytes, std::move(outline->description)};
  return mesh;
}

Expected<std::unique_ptr<psplit_mesh>> open_mesh(const psplit_source* from) {
  const Expected<psplit_source> source = read_struct(from, "psplit_source");
  if (!source) return source.status();
  const bool is_file = source->kind == PSPLIT_KIND_DRACO_FILE;
  if (!is_file && source->kind != PSPLIT_KIND_PATCHES && source->kind != PSPLIT_KIND_DRACO)
    return wrong_usage("kind " + std::to_string(source->kind) + " cannot be opened");
  const uint32_t known = PSPLIT_COPY | (is_file ? PSPLIT_INTEGERS : 0);
  if ((source->flags & ~known) != 0)
    return wrong_usage("a psplit_source of this kind has no flags " + std::to_string(source->flags & ~known));
  const Expected<SourceBytes> bytes =
      source_bytes(source->data, source->size, (source->flags & PSPLIT_COPY) != 0);
  if (!bytes) return bytes.status();
  const std::span<const uint8_t> stored(bytes->data, bytes->size);
  if (is_file) {
    Expected<std::unique_ptr<psplit_mesh>> mesh = open_file(*source, stored);
    if (mesh) (*mesh)->bytes = bytes->copy;
    return mesh;
  }
  Expected<std::vector<AttributeRequest>> requests = read_requests(*source);
  if (!requests) return requests.status();
  return open_primitive({stored, std::move(*requests), source->point_count, source->index_count,
                         source->kind == PSPLIT_KIND_DRACO ? Compression::kDraco : Compression::kPatches},
                        bytes->copy);
}

}  // namespace

Expected<std::unique_ptr<psplit_mesh>> open_primitive(PrimitiveSource source,
                                                      std::shared_ptr<const void> bytes) {
  const psplit_kind kind = source.compression == Compression::kDraco ? PSPLIT_KIND_DRACO : PSPLIT_KIND_PATCHES;
  source.older = built_in_older_streams();
  Expected<CompressedPrimitive> primitive = CompressedPrimitive::open(std::move(source));
  if (!primitive) return primitive.status();
  auto mesh = std::make_unique<psplit_mesh>();
  mesh->kind = kind;
  mesh->bytes = std::move(bytes);
  for (const AttributeRequest& request : primitive->attributes())
    mesh->attributes.push_back({request.semantic, request.unique_id, semantic_of(request.semantic),
                                stored_type(request.component_type), request.component_count,
                                request.normalized, request.value_bytes()});
  mesh->primitive = std::move(*primitive);
  return mesh;
}

}  // namespace psplit::c

using namespace psplit;
using namespace psplit::c;

Expected<const StreamDescription*> psplit_mesh::description() const {
  if (file && file->description.coding != StreamCoding::kCloudKdTree) return &file->description;
  const std::lock_guard lock(mutex_);
  if (!description_) {
    if (patch_count() == 0) return invalid_input("the container has no patches");
    Expected<StreamDescription> description = file ? describe_stream(file->stream)
                                              : primitive->older() != nullptr
                                                  ? primitive->older()->describe(primitive->bytes())
                                                  : describe_patch(primitive->container(), 0);
    if (!description) return description.status();
    description_ = std::move(*description);
  }
  return &*description_;
}

psplit_code psplit_mesh_open(const psplit_source* source, psplit_mesh** mesh, psplit_error* error) {
  return make_handle(mesh, error, [&] { return open_mesh(source); });
}
void psplit_mesh_free(psplit_mesh* mesh) { delete mesh; }

psplit_code psplit_mesh_get_info(const psplit_mesh* mesh, psplit_mesh_info* info, psplit_error* error) {
  return guarded(error, [&]() -> Status {
    if (mesh == nullptr) return null_handle();
    psplit_mesh_info value{};
    value.kind = mesh->kind;
    value.coding =
        mesh->file ? static_cast<psplit_coding>(mesh->file->description.coding) : PSPLIT_CODING_UNKNOWN;
    value.point_count = mesh->point_count();
    value.face_count = mesh->face_count();
    value.attribute_count = static_cast<uint32_t>(mesh->attributes.size());
    value.patch_count = mesh->patch_count();
    value.has_residue = mesh->primitive && mesh->primitive->has_residue();
    value.least_index_size = least_index_bytes(mesh->point_count());
    return write_struct(info, value, "psplit_mesh_info");
  });
}

psplit_code psplit_mesh_get_attribute(const psplit_mesh* mesh, uint32_t attribute, psplit_attribute_info* info,
                                      psplit_error* error) {
  return guarded(error, [&]() -> Status {
    if (mesh == nullptr) return null_handle();
    if (attribute >= mesh->attributes.size())
      return wrong_usage("there is no attribute " + std::to_string(attribute));
    const MeshAttribute& described = mesh->attributes[attribute];
    psplit_attribute_info value{};
    value.unique_id = described.unique_id;
    value.semantic = static_cast<psplit_semantic>(described.semantic);
    value.type = static_cast<psplit_type>(described.type);
    value.components = described.components;
    value.normalized = described.normalized;
    value.value_size = static_cast<uint32_t>(described.value_bytes);
    value.is_integers = described.is_integers;
    value.name = described.name.c_str();
    return write_struct(info, value, "psplit_attribute_info");
  });
}

namespace {

// The first attribute for which is_wanted is true, or -1.
template <typename IsWanted>
int32_t find_attribute(const psplit_mesh* mesh, IsWanted is_wanted) {
  if (mesh == nullptr) return -1;
  const auto found = std::find_if(mesh->attributes.begin(), mesh->attributes.end(), is_wanted);
  return found == mesh->attributes.end() ? -1 : static_cast<int32_t>(found - mesh->attributes.begin());
}

}  // namespace

int32_t psplit_mesh_find_name(const psplit_mesh* mesh, const char* name) {
  if (name == nullptr) return -1;
  return find_attribute(mesh, [&](const MeshAttribute& attribute) { return attribute.name == name; });
}
int32_t psplit_mesh_find_id(const psplit_mesh* mesh, uint32_t unique_id) {
  return find_attribute(mesh, [&](const MeshAttribute& attribute) { return attribute.unique_id == unique_id; });
}
int32_t psplit_mesh_find_semantic(const psplit_mesh* mesh, psplit_semantic semantic, uint32_t skip) {
  return find_attribute(mesh, [&](const MeshAttribute& attribute) {
    return static_cast<psplit_semantic>(attribute.semantic) == semantic && skip-- == 0;
  });
}

psplit_code psplit_mesh_get_quantization(const psplit_mesh* mesh, uint32_t attribute,
                                         psplit_quantization* quantization, psplit_error* error) {
  return guarded(error, [&]() -> Status {
    if (mesh == nullptr) return null_handle();
    if (attribute >= mesh->attributes.size())
      return wrong_usage("there is no attribute " + std::to_string(attribute));
    const Expected<const StreamDescription*> description = mesh->description();
    if (!description) return description.status().at(mesh->place);
    const StreamAttribute* found = nullptr;
    if (mesh->file && attribute < (*description)->attributes.size()) {
      found = &(*description)->attributes[attribute];
    } else if (mesh->primitive) {
      for (const StreamAttribute& stored : (*description)->attributes)
        if (stored.unique_id == mesh->attributes[attribute].unique_id) found = &stored;
    }
    if (found == nullptr)
      return invalid_input("the stream has no attribute with the unique id " +
                           std::to_string(mesh->attributes[attribute].unique_id));
    psplit_quantization value{};
    value.bits = found->bits;
    value.range = found->range;
    value.origin_count = static_cast<uint32_t>(found->origin.size());
    value.origin = found->origin.empty() ? nullptr : found->origin.data();
    return write_struct(quantization, value, "psplit_quantization");
  });
}

psplit_code psplit_mesh_get_patch(const psplit_mesh* mesh, uint32_t patch, psplit_patch_info* info,
                                  psplit_error* error) {
  return guarded(error, [&]() -> Status {
    if (mesh == nullptr) return null_handle();
    if (patch >= mesh->patch_count()) return wrong_usage("there is no patch " + std::to_string(patch));
    psplit_patch_info value{};
    if (mesh->primitive) {
      const PatchSizes sizes = mesh->primitive->patch(patch);
      value.face_count = sizes.face_count;
      value.point_count = sizes.point_count;
      value.stream_size = sizes.stream_bytes;
      value.first_face = sizes.first_face;
      value.first_owned_point = sizes.first_owned_point;
      value.owned_point_count = sizes.owned_point_count;
      value.is_residue = mesh->primitive->has_residue() && patch + 1 == mesh->patch_count();
    } else {
      value.face_count = mesh->face_count();
      value.point_count = value.owned_point_count = mesh->point_count();
    }
    return write_struct(info, value, "psplit_patch_info");
  });
}
