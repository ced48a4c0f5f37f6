// What the module exports. All numbers are 32-bit words, and addresses are bytes of the module's memory.
//
// A handle is the address of a decoded stream or container, 0 after an error: last_error then says why. The
// handle's owner frees it. Functions that return "words" give the address of words that stay valid until the
// next call of the same function.
//
// If memory runs out, or if the stack overflows, the call traps, and the instance must not be used any more.
#include "web/src/decoded_container.h"
#include "web/src/decoded_stream.h"
#include "web/src/heap.h"

#define PSPLIT_WEB_EXPORT(name) extern "C" [[clang::export_name(#name)]]

namespace psplit::web {
namespace {

struct LastError {
  uint32_t code = 0;  // a StatusCode
  int32_t patch = -1;
  const char* message = nullptr;
  uint32_t message_bytes = 0;
};

Status error;
LastError last;

bool keep(Status status) {
  error = std::move(status);
  last = {static_cast<uint32_t>(error.code()), static_cast<int32_t>(error.place().patch),
          error.message().data(), static_cast<uint32_t>(error.message().size())};
  return error.ok();
}

template <typename T>
T* keep(Expected<std::unique_ptr<T>> made) {
  return keep(made.status()) ? made->release() : nullptr;
}

std::unique_ptr<uint8_t[]> owned(uint8_t* bytes) { return std::unique_ptr<uint8_t[]>(bytes); }

}  // namespace

PSPLIT_WEB_EXPORT(allocate) void* allocate_bytes(size_t bytes) { return allocate(bytes); }
PSPLIT_WEB_EXPORT(release) void release_bytes(void* memory) { release(memory); }

// code, patch or -1, address and length of the message in UTF-8
PSPLIT_WEB_EXPORT(last_error) const LastError* last_error() { return &last; }

// Draco streams. The bytes are in memory of allocate, which the call takes over.
PSPLIT_WEB_EXPORT(decode_stream) DecodedStream* decode_stream(uint8_t* bytes, size_t size) {
  return keep(DecodedStream::decode(owned(bytes), size));
}
PSPLIT_WEB_EXPORT(free_stream) void free_stream(DecodedStream* stream) { delete stream; }

// faces, points, attributes, memory that holds them
PSPLIT_WEB_EXPORT(stream_counts) const uint32_t* stream_counts(const DecodedStream* stream) {
  static uint32_t words[3];
  const DecodedStream::Patch& patch = stream->patch();
  words[0] = patch.face_count;
  words[1] = patch.point_count;
  words[2] = static_cast<uint32_t>(patch.attributes.size());
  return words;
}
// Draco's attribute type, data type, components, normalized, unique id, coding, bits, range, address of the
// origin
PSPLIT_WEB_EXPORT(stream_attribute) const uint32_t* stream_attribute(const DecodedStream* stream, uint32_t i) {
  static uint32_t words[9];
  const DecodedStream::Attribute& attribute = stream->patch().attributes[i];
  words[0] = attribute.semantic;
  words[1] = static_cast<uint32_t>(attribute.type);
  words[2] = attribute.components;
  words[3] = attribute.normalized;
  words[4] = attribute.unique_id;
  words[5] = static_cast<uint32_t>(attribute.coding);
  words[6] = attribute.bits;
  __builtin_memcpy(&words[7], &attribute.range, sizeof attribute.range);
  words[8] = reinterpret_cast<uint32_t>(attribute.origin);
  return words;
}
PSPLIT_WEB_EXPORT(write_faces)
void write_faces(const DecodedStream* stream, uint32_t index_bytes, uint8_t* out) {
  stream->write_faces(index_bytes, out);
}
PSPLIT_WEB_EXPORT(write_attribute)
bool write_attribute(const DecodedStream* stream, uint32_t i, uint32_t type, uint8_t* out) {
  return stream->write_attribute(stream->patch().attributes[i], static_cast<core::DataType>(type), out);
}
PSPLIT_WEB_EXPORT(write_integers) bool write_integers(const DecodedStream* stream, uint32_t i, int32_t* out) {
  return stream->write_integers(stream->patch().attributes[i], out);
}

// Containers. The bytes are in memory of allocate, which the call takes over.
PSPLIT_WEB_EXPORT(open_container) DecodedContainer* open_container_bytes(uint8_t* bytes, size_t size) {
  return keep(DecodedContainer::open(owned(bytes), size));
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
  return keep(container->decode_all());
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
