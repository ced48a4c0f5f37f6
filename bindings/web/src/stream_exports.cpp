// The exports of both decoders for Draco streams.
#include "bindings/web/src/decoded_stream.h"
#include "bindings/web/src/exports.h"

namespace psplit::web {

// Draco streams. The bytes are in memory of allocate, which the call takes over.
PSPLIT_WEB_EXPORT(decode_stream) DecodedStream* decode_stream(uint8_t* bytes, size_t size) {
  return handle_of(DecodedStream::decode(owned(bytes), size));
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
// origin, number of stored values
PSPLIT_WEB_EXPORT(stream_attribute) const uint32_t* stream_attribute(const DecodedStream* stream, uint32_t i) {
  static uint32_t words[10];
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
  words[9] = stream->patch().groups[attribute.group].sequence.count;
  return words;
}
// Three 32-bit numbers of points for each face.
PSPLIT_WEB_EXPORT(stream_faces) const void* stream_faces(const DecodedStream* stream) {
  return stream->faces();
}
PSPLIT_WEB_EXPORT(write_faces)
void write_faces(const DecodedStream* stream, uint32_t index_bytes, void* out) {
  stream->write_faces(index_bytes, out);
}
PSPLIT_WEB_EXPORT(write_attribute)
bool write_attribute(const DecodedStream* stream, uint32_t i, uint32_t type, uint8_t* out) {
  return stream->write_attribute(stream->patch().attributes[i], static_cast<DataType>(type), out);
}
PSPLIT_WEB_EXPORT(write_integers) bool write_integers(const DecodedStream* stream, uint32_t i, int32_t* out) {
  return stream->write_integers(stream->patch().attributes[i], out);
}
#if defined(PSPLIT_ONLY_DRACO)  // which draco3d's interface asks for
PSPLIT_WEB_EXPORT(write_value_numbers)
void write_value_numbers(const DecodedStream* stream, uint32_t i, uint32_t* out) {
  stream->write_value_numbers(stream->patch().attributes[i], out);
}
#endif

}  // namespace psplit::web
