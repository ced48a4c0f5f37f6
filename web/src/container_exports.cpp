// The exports of the module that decodes containers as well.
#include "web/src/decoded_container.h"
#include "web/src/exports.h"

namespace psplit::web {

// Containers. The bytes are in memory of allocate, which the call takes over.
PSPLIT_WEB_EXPORT(open_container) DecodedContainer* open_container_bytes(uint8_t* bytes, size_t size) {
  return handle_of(DecodedContainer::open(owned(bytes), size));
}
PSPLIT_WEB_EXPORT(free_container) void free_container(DecodedContainer* container) { delete container; }

// version, patches, residue, faces, points, references
PSPLIT_WEB_EXPORT(container_counts) const uint32_t* container_counts(const DecodedContainer* handle) {
  static uint32_t words[6];
  const PatchContainer& container = handle->container();
  words[0] = container.version;
  words[1] = container.patch_count();
  words[2] = container.has_residue;
  words[3] = container.face_count();
  words[4] = container.point_count();
  words[5] = static_cast<uint32_t>(container.reference_count());
  return words;
}
// Requests an attribute. `name` is glTF's semantic in UTF-8, for messages.
PSPLIT_WEB_EXPORT(request_attribute)
void request_attribute(DecodedContainer* container, const char* name, size_t name_bytes, uint32_t unique_id,
                       uint32_t component_type, uint32_t components, uint32_t normalized) {
  container->request({std::string(name, name_bytes), unique_id, static_cast<ComponentType>(component_type),
                      static_cast<uint8_t>(components), normalized != 0});
}
PSPLIT_WEB_EXPORT(decode_container) bool decode_container(DecodedContainer* container) {
  return keep_error(container->decode_all());
}
// After decode_container: three 32-bit numbers of points for each face, and the values of the requests in their
// order, tightly packed.
PSPLIT_WEB_EXPORT(container_faces) const void* container_faces(const DecodedContainer* container) {
  return container->mesh().faces.data();
}
PSPLIT_WEB_EXPORT(container_values)
const void* container_values(const DecodedContainer* container, uint32_t i) {
  return container->mesh().attributes[i].values.data();
}

}  // namespace psplit::web
