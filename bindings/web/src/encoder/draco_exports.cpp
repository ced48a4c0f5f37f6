// The exports of the encoder of Draco streams. A mesh is built by calls that return where its values go.
#include <optional>
#include <string>
#include <vector>

#include "bindings/web/src/exports.h"
#include "encoder/stream/draco_encoder.h"

namespace psplit::web {
namespace {

// Static objects have no constructors: see exports.cpp.
[[clang::no_destroy]] constinit std::optional<LabelledStream> stream;

// `numbers` are read one after the other, for each attribute: bits, and whether a grid follows: its range, and
// the origin of each component.
std::vector<AttributeCoding> codings_of(const DracoMesh& mesh, const float* numbers) {
  std::vector<AttributeCoding> codings;
  for (const Attribute& attribute : mesh.mesh.attributes) {
    AttributeCoding& coding = codings.emplace_back();
    coding.bits = static_cast<int>(*numbers++);
    if (*numbers++ == 0) continue;
    coding.range = *numbers++;
    coding.origin.assign(numbers, numbers + attribute.component_count);
    numbers += attribute.component_count;
  }
  return codings;
}

// Keeps the stream. Returns words that are valid until free_stream: address and length of the bytes, points,
// and faces. Null after an error.
const uint32_t* keep(Expected<LabelledStream> encoded) {
  static uint32_t words[4];
  if (!keep_error(encoded.status())) return nullptr;
  stream = std::move(*encoded);
  words[0] = reinterpret_cast<uint32_t>(stream->bytes.data());
  words[1] = static_cast<uint32_t>(stream->bytes.size());
  words[2] = stream->point_count;
  words[3] = stream->face_count;
  return words;
}

}  // namespace

PSPLIT_WEB_EXPORT(new_mesh) DracoMesh* new_mesh() { return new DracoMesh; }
PSPLIT_WEB_EXPORT(free_mesh) void free_mesh(DracoMesh* mesh) { delete mesh; }
PSPLIT_WEB_EXPORT(set_point_count) void set_point_count(DracoMesh* mesh, uint32_t count) {
  mesh->mesh.point_count = count;
}
// Returns where the faces go, three numbers of points for each.
PSPLIT_WEB_EXPORT(set_face_count) void* set_face_count(DracoMesh* mesh, uint32_t count) {
  mesh->mesh.faces.resize(count);
  return mesh->mesh.faces.data();
}
// Adds an attribute with a value for each point. Returns where the values go. `semantic` and `type` are
// Draco's.
PSPLIT_WEB_EXPORT(add_attribute)
void* add_attribute(DracoMesh* mesh, uint32_t semantic, uint32_t type, uint32_t components) {
  const DracoLabel label{static_cast<DracoSemantic>(semantic), static_cast<DataType>(type)};
  const std::string name = label.semantic == DracoSemantic::kPosition && mesh->mesh.find("POSITION") == nullptr
                               ? "POSITION"
                               : std::to_string(static_cast<unsigned>(mesh->labels.size()));
  Attribute& attribute = mesh->mesh.attributes.emplace_back(
      Attribute{name,
                component_type_of(label.type).value_or(ComponentType::kFloat32),
                static_cast<uint8_t>(components),
                false,
                {}});
  attribute.values.resize(mesh->mesh.point_count * attribute.stride());
  mesh->labels.push_back(label);
  mesh->share_values.push_back(0);
  return attribute.values.data();
}
PSPLIT_WEB_EXPORT(set_normalized) void set_normalized(DracoMesh* mesh, uint32_t i, bool normalized) {
  mesh->mesh.attributes[i].normalized = normalized;
}
// Returns false, and changes nothing, if a face has a point that does not exist.
PSPLIT_WEB_EXPORT(deduplicate) bool deduplicate_points(DracoMesh* mesh) { return deduplicate(*mesh).ok(); }
PSPLIT_WEB_EXPORT(point_count) uint32_t point_count(const DracoMesh* mesh) { return mesh->mesh.point_count; }

// Both return what keep() does. For the numbers see codings_of().
PSPLIT_WEB_EXPORT(encode_mesh)
const uint32_t* encode_mesh(const DracoMesh* mesh, bool is_sequential, int32_t speed, const float* numbers) {
  stream.reset();
  return keep(encode_as_draco(*mesh, codings_of(*mesh, numbers), is_sequential, speed));
}
// `method` is Draco's, or below 0 the one that Draco chooses.
PSPLIT_WEB_EXPORT(encode_cloud)
const uint32_t* encode_cloud(const DracoMesh* cloud, int32_t method, int32_t speed, const float* numbers) {
  stream.reset();
  std::optional<CloudMethod> stated;
  if (method >= 0) stated = static_cast<CloudMethod>(method);
  return keep(encode_cloud_as_draco(*cloud, codings_of(*cloud, numbers), stated, speed));
}

PSPLIT_WEB_EXPORT(free_stream) void free_stream() { stream.reset(); }

}  // namespace psplit::web
