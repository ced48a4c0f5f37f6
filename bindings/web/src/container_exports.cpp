// The exports of the module that decodes containers as well.
#include "bindings/web/src/decoded_container.h"
#include "bindings/web/src/exports.h"

namespace psplit::web {

#if !defined(PSPLIT_WITHOUT_CONDENSED)
// Tells the module that decodes condensed patches from the one that refuses them.
PSPLIT_WEB_EXPORT(reads_condensed) bool reads_condensed() { return true; }
#endif
namespace {

// address and length of a list of words
const uint32_t* list_words(const std::vector<uint32_t>& list) {
  static uint32_t words[2];
  words[0] = reinterpret_cast<uint32_t>(list.data());
  words[1] = static_cast<uint32_t>(list.size());
  return words;
}

}  // namespace

// Containers. The bytes are in memory of allocate, which the call takes over: as many as DecodedContainer's
// Arrival says.
PSPLIT_WEB_EXPORT(open_container)
DecodedContainer* open_container_bytes(uint8_t* bytes, size_t size, DecodedContainer::Arrival arrival) {
  return handle_of(DecodedContainer::open(owned(bytes), size, arrival));
}
// Chooses `count` patches of an outline. The stitch map is in memory of allocate, which the call takes over;
// null if patches share no values. Returns the streams that they need.
PSPLIT_WEB_EXPORT(choose_patches)
const uint32_t* choose_patches(DecodedContainer* container, const uint32_t* patches, size_t count,
                               uint8_t* stitch_map) {
  return list_words(container->choose({patches, patches + count}, owned(stitch_map)));
}
PSPLIT_WEB_EXPORT(place_chosen) bool place_chosen(DecodedContainer* container) {
  return keep_error(container->place_chosen());
}
// Returns the number of streams that have arrived; failed_stage tells of a failure.
PSPLIT_WEB_EXPORT(arrive) uint32_t arrive(DecodedContainer* container, size_t arrived) {
  return container->arrive(arrived);
}
PSPLIT_WEB_EXPORT(free_container) void free_container(DecodedContainer* container) { delete container; }

// streams, residue, whether streams are condensed, the addresses of the streams' first faces and first points
// (a number for each stream, and the mesh's count), the address and the length of the container's bytes,
// whether patches share values at borders, the bytes to the end of the head, the address of the rows, and words
// of a row: bytes of the stream, faces, points, references, bytes of the stitch map, and others
PSPLIT_WEB_EXPORT(container_counts) const uint32_t* container_counts(const DecodedContainer* handle) {
  static uint32_t words[11];
  const PatchContainer& container = handle->container();
  words[0] = static_cast<uint32_t>(container.entries.size());
  words[1] = container.has_residue;
  words[2] = container.condensed_count() > 0;
  words[3] = reinterpret_cast<uint32_t>(container.face_base.data());
  words[4] = reinterpret_cast<uint32_t>(container.owned_base.data());
  words[5] = reinterpret_cast<uint32_t>(container.bytes.data());
  words[6] = static_cast<uint32_t>(container.bytes.size());
  words[7] = container.has_borders();
  words[8] = static_cast<uint32_t>(container.header_bytes);
  words[9] = reinterpret_cast<uint32_t>(container.entries.data());
  words[10] = sizeof(StreamEntry) / sizeof(uint32_t);
  return words;
}

// The attributes that the first stream stores, which it decodes for that. Null after an error. Address and
// number of words; for each attribute Draco's attribute type, data type, components, normalized, unique id.
PSPLIT_WEB_EXPORT(describe_container) const uint32_t* describe_container(DecodedContainer* container) {
  static uint32_t words[2];
  if (!keep_error(container->describe())) return nullptr;
  words[0] = reinterpret_cast<uint32_t>(container->stored().data());
  words[1] = static_cast<uint32_t>(container->stored().size() * sizeof(DecodedContainer::StoredAttribute) /
                                   sizeof(uint32_t));
  return words;
}
// Requests an attribute. `name` is glTF's semantic in UTF-8, for messages.
PSPLIT_WEB_EXPORT(request_attribute)
void request_attribute(DecodedContainer* container, const char* name, size_t name_bytes, uint32_t unique_id,
                       uint32_t component_type, uint32_t components, uint32_t normalized) {
  container->request({std::string(name, name_bytes), unique_id, static_cast<ComponentType>(component_type),
                      static_cast<uint8_t>(components), normalized != 0});
}

// The streams [first, end), as DecodedContainer says.
PSPLIT_WEB_EXPORT(begin_range) bool begin_range(DecodedContainer* container, uint32_t first, uint32_t end) {
  return keep_error(container->begin({first, end}));
}
PSPLIT_WEB_EXPORT(decode_streams) uint32_t decode_streams(DecodedContainer* container) {
  return container->decode_streams();
}
// A Stage. Its error is kept.
PSPLIT_WEB_EXPORT(failed_stage) uint32_t failed_stage(const DecodedContainer* container) {
  keep_error(container->failure());
  return static_cast<uint32_t>(container->failed_stage());
}
// These are read after decode_streams: the faces of the range, each with three 32-bit numbers of the mesh's
// points; the values of its points of a request, tightly packed; and a byte for each stream of the container.
PSPLIT_WEB_EXPORT(range_faces) const void* range_faces(const DecodedContainer* container) {
  return container->part().faces.data();
}
PSPLIT_WEB_EXPORT(range_values) const void* range_values(const DecodedContainer* container, uint32_t i) {
  return container->part().attributes[i].values.data();
}
PSPLIT_WEB_EXPORT(resolved_streams) const void* resolved_streams(const DecodedContainer* container) {
  return container->is_resolved().data();
}

// What the lead needs of a range.
PSPLIT_WEB_EXPORT(stitching) const uint32_t* stitching(DecodedContainer* container) {
  return list_words(container->stitching());
}
PSPLIT_WEB_EXPORT(add_stitching)
void add_stitching(DecodedContainer* container, uint32_t first, const uint32_t* words, size_t count) {
  container->add_stitching(first, {words, count});
}
// Returns the corner and the index of each index to change; null after an error.
PSPLIT_WEB_EXPORT(resolve_rest) const uint32_t* resolve_rest(DecodedContainer* container) {
  return keep_error(container->resolve_rest()) ? list_words(container->corrections()) : nullptr;
}

}  // namespace psplit::web
