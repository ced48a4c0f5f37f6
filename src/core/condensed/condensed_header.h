// The front of a condensed stream: its skeleton's header, the counts that the directory says, and the numbers
// of its first section. Specification: "condensed streams" (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include "src/core/condensed/condensed_numbers.h"
#include "src/core/stream_header.h"

namespace psplit::core {

// Counts the attributes of a skeleton. `reader` is behind the number of attribute data.
PSPLIT_HD inline Fault count_attributes(ByteReader reader, uint32_t& count) {
  const uint32_t group_count = reader.u8();
  reader.skip(uint64_t{3} * group_count);
  count = 0;
  for (uint32_t group = 0; group < group_count && !reader.truncated(); ++group) {
    const uint32_t attributes = reader.varint();
    // A description takes more than 4 bytes.
    if (attributes > reader.remaining() / 4) return Fault::kTruncated;
    for (uint32_t i = 0; i < attributes; ++i) {
      reader.skip(4);
      reader.varint();
    }
    reader.skip(attributes);
    count += attributes;
  }
  return reader.truncated() ? Fault::kTruncated : Fault::kNone;
}

// Reads the numbers that come before the attributes' own, and notes where they are.
PSPLIT_HD inline Fault read_condensed_counts(uint32_t point_count, StreamHeader& header) {
  CondensedStream& stream = header.condensed;
  CondensedNumbers numbers(stream.numbers(0));
  CondensedKinds kinds;
  ConnectivityCounts& counts = header.counts;
  stream.interior_count = numbers.number(kinds.count);
  const int64_t vertices = int64_t{point_count} - numbers.signed_number(kinds.vertices);
  stream.split_symbol_count = numbers.number(kinds.splits);
  const uint64_t components = uint64_t{numbers.number(kinds.count)} + 1;
  if (stream.interior_count >= counts.face_count || vertices < 0 || vertices > 0xffffffffu)
    return Fault::kCounts;
  counts.symbol_count = counts.face_count - stream.interior_count;
  if (components > counts.symbol_count || stream.interior_count > components) return Fault::kCounts;
  stream.component_count = static_cast<uint32_t>(components);

  stream.start_faces_at = numbers.place();
  if (stream.has_start_face_bits()) numbers.skip(components);
  counts.split_count = numbers.number(kinds.count);
  stream.events_at = numbers.place();
  if (counts.split_count > counts.face_count || !numbers.justify(uint64_t{3} * counts.split_count))
    return Fault::kCounts;
  for (uint32_t i = 0; i < counts.split_count; ++i) numbers.split_event(kinds.event);
  stream.seams_at = numbers.place();
  numbers.skip(header.attribute_data_count);
  stream.lengths_at = numbers.place();
  uint64_t others = 0;
  for (uint32_t i = 1; i < stream.attribute_count && !numbers.broken(); ++i)
    others += numbers.number(kinds.bytes);
  if (numbers.broken() || others > stream.bytes.size()) return Fault::kTruncated;
  stream.first_section = static_cast<size_t>(others);
  return finish_edgebreaker_counts(static_cast<uint32_t>(vertices), stream.split_symbol_count, counts);
}

// Reads the header of a condensed stream: a PatchDecoder with it decodes the stream like a Draco stream. The
// counts are those of the directory's row. All bytes and models must outlive the header, and all of them may be
// anything.
PSPLIT_HD inline Fault read_condensed_header(View<const uint8_t> skeleton, View<const uint8_t> stream,
                                             const CondensedModels& models, uint32_t face_count,
                                             uint32_t point_count, StreamHeader& header) {
  if (const Fault fault = read_kind(skeleton.data(), skeleton.size(), header); fault != Fault::kNone)
    return fault;
  if (!header.edgebreaker) return Fault::kMethod;
  header.valence = false;
  if (const Fault fault = read_traversal(header); fault != Fault::kNone) return fault;
  header.attribute_data_count = header.body.u8();
  header.counts.face_count = face_count;
  header.condensed.bytes = stream;
  header.condensed.models = models;
  const Fault fault = count_attributes(header.body, header.condensed.attribute_count);
  if (fault != Fault::kNone) return fault;
  // The head has models for all attributes and all seams.
  if (stream.empty() || header.condensed.attribute_count > models.attributes.size() ||
      header.attribute_data_count > models.seams.size() || models.contexts.empty())
    return Fault::kAttribute;
  return read_condensed_counts(point_count, header);
}

}  // namespace psplit::core
