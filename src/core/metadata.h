// Metadata in front of a stream: trees of named entries, one for each of some attributes, then one for the
// whole geometry. It does not concern the decoder. Draco bitstream specification 2.2, "metadata".
#pragma once

#include "src/core/byte_reader.h"
#include "src/core/fault.h"

namespace psplit::core {

// The calls that walk_metadata makes, and a visitor that ignores them. Each tree begins with `attribute` or
// `geometry`. Its parts follow in depth-first order, from the root on: `begin` (except for the root), `entry`
// for each entry, then `end`.
struct MetadataVisitor {
  PSPLIT_HD void attribute(uint32_t /*unique_id*/) {}
  PSPLIT_HD void geometry() {}
  PSPLIT_HD void begin(View<const uint8_t> /*name*/) {}
  PSPLIT_HD void entry(View<const uint8_t> /*name*/, View<const uint8_t> /*value*/) {}
  PSPLIT_HD void end(uint32_t /*part_count*/) {}  // `part_count` child parts follow
};

// Takes `count` bytes from the reader. The view is empty, and the reader truncated, if fewer are left.
PSPLIT_HD inline View<const uint8_t> take_bytes(ByteReader& reader, uint32_t count) {
  const uint8_t* const bytes = reader.head();
  return reader.skip(count) ? View<const uint8_t>(bytes, count) : View<const uint8_t>();
}

// Metadata may nest; the parts that are still to come are counted, without recursion. At each `end`, the
// announced parts do not exceed the bytes that are left.
template <typename Visitor>
PSPLIT_HD Fault walk_metadata(ByteReader& reader, Visitor& visitor) {
  const uint32_t attribute_count = reader.varint();
  for (uint64_t i = 0; i <= attribute_count; ++i) {
    if (i < attribute_count)
      visitor.attribute(reader.varint());
    else
      visitor.geometry();
    uint64_t missing = 1;
    for (bool is_root = true; missing > 0; is_root = false) {
      --missing;
      if (!is_root) visitor.begin(take_bytes(reader, reader.u8()));
      const uint32_t entry_count = reader.varint();
      for (uint32_t entry = 0; entry < entry_count && !reader.truncated(); ++entry) {
        const View<const uint8_t> name = take_bytes(reader, reader.u8());
        visitor.entry(name, take_bytes(reader, reader.varint()));
      }
      const uint32_t part_count = reader.varint();
      missing += part_count;
      if (reader.truncated()) return Fault::kTruncated;
      if (missing > reader.remaining()) return Fault::kCounts;
      visitor.end(part_count);
    }
  }
  return Fault::kNone;
}

PSPLIT_HD inline Fault skip_metadata(ByteReader& reader) {
  MetadataVisitor nobody;
  return walk_metadata(reader, nobody);
}

}  // namespace psplit::core
