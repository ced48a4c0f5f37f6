// The front of a condensed stream: its skeleton's header, the counts that the directory says, and the numbers
// of its first section. Specification: "condensed streams" (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include "src/core/condensed/condensed_numbers.h"
#include "src/core/condensed/delta_sources.h"
#include "src/core/condensed/skeleton.h"
#include "src/core/draco_header.h"

namespace psplit::core {

// Reads the numbers of attributes, and notes where they end. `attributes` come from the skeleton.
PSPLIT_HD inline Fault read_attribute_numbers(View<const SkeletonAttribute> attributes,
                                              CondensedNumbers& numbers, CondensedStream& stream) {
  CondensedKinds kinds;
  uint64_t others = 0;
  for (size_t i = 1; i < attributes.size() && !numbers.broken(); ++i)
    if (!stream.models.attributes[i].is_delta) others += numbers.number(kinds.bytes);
  const uint32_t delta_count = stream.models.delta_count(static_cast<uint32_t>(attributes.size()));
  for (uint32_t n = 0; n < delta_count; ++n) stream.delta_row_count += numbers.bit();
  for (uint32_t s = 0; s < kDeltaSections && stream.delta_row_count > 0; ++s)
    others += numbers.number(kinds.bytes);
  for (size_t i = 0; i < attributes.size() && !numbers.broken(); ++i) {
    if (attributes[i].is_by_creation(stream.models.attributes[i])) continue;
    ++stream.traversed_count;
    if (!attributes[i].has_wrap_range()) continue;
    numbers.number(kinds.low);
    numbers.number(kinds.extent);
  }
  for (size_t i = 0; i < attributes.size() && !numbers.broken(); ++i)
    for (uint32_t k = 0; k < attributes[i].flag_lists(); ++k) numbers.number(kinds.flags);
  for (size_t i = 0; i < attributes.size() && !numbers.broken(); ++i)
    numbers.skip(set_bits(stream.models.attributes[i]));
  if (stream.models.has_borders) stream.border_count = numbers.number(kinds.border);
  if (numbers.broken() || others > stream.bytes.size()) return Fault::kTruncated;
  stream.first_section = static_cast<size_t>(others);
  stream.numbers_end = numbers.place();
  return Fault::kNone;
}

// Reads the numbers, and notes where they are.
PSPLIT_HD inline Fault read_condensed_counts(View<const SkeletonAttribute> attributes, uint32_t point_count,
                                             DracoHeader& header, CondensedStream& stream) {
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
  if (const Fault fault = read_attribute_numbers(attributes, numbers, stream); fault != Fault::kNone)
    return fault;
  if (stream.border_count > point_count) return Fault::kCounts;
  return finish_edgebreaker_counts(static_cast<uint32_t>(vertices), stream.split_symbol_count, counts);
}

// Reads the header of a condensed stream: what the header of its Draco stream says, and `out`. The counts come
// from the directory's row. All bytes and models must outlive the header, and all of them may be anything.
// `attributes` is memory for the attributes of the skeleton: kMaxAttributes are enough for any. It is used here
// only.
PSPLIT_HD inline Fault read_condensed_header(View<const uint8_t> skeleton, View<const uint8_t> stream,
                                             const CondensedModels& models, uint32_t face_count,
                                             uint32_t point_count, View<SkeletonAttribute> attributes,
                                             DracoHeader& header, CondensedStream& out) {
  if (const Fault fault = read_kind(skeleton.data(), skeleton.size(), header); fault != Fault::kNone)
    return fault;
  if (!header.edgebreaker) return Fault::kMethod;
  header.valence = false;
  if (const Fault fault = read_traversal(header); fault != Fault::kNone) return fault;
  header.attribute_data_count = header.body.u8();
  header.counts.face_count = face_count;
  out.bytes = stream;
  out.models = models;
  uint32_t& count = out.attribute_count;
  if (const Fault fault = read_skeleton(header.body, attributes, count); fault != Fault::kNone) return fault;
  // The head has models for all attributes and all seams.
  if (stream.empty() || count > models.attributes.size() || header.attribute_data_count > models.seams.size() ||
      models.contexts.empty())
    return Fault::kAttribute;
  // Values at borders are known before all others, which only values in order of creation can be.
  if (models.has_borders && (count == 0 || !attributes[0].is_by_creation(models.attributes[0])))
    return Fault::kAttribute;
  out.border_components = count > 0 ? attributes[0].components : 0;
  return read_condensed_counts(attributes.first(count), point_count, header, out);
}
// An overload for the host, whose stack has room for all attributes.
inline Fault read_condensed_header(View<const uint8_t> skeleton, View<const uint8_t> stream,
                                   const CondensedModels& models, uint32_t face_count, uint32_t point_count,
                                   DracoHeader& header, CondensedStream& out) {
  SkeletonAttribute attributes[kMaxAttributes];
  return read_condensed_header(skeleton, stream, models, face_count, point_count, {attributes, kMaxAttributes},
                               header, out);
}

}  // namespace psplit::core
