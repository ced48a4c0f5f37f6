// The front of a Draco mesh stream: its kind and its counts. Draco bitstream specification 2.2, "header". Point
// clouds have a front of their own (cloud_header.h).
#pragma once

#include "src/core/connectivity.h"
#include "src/core/metadata.h"

namespace psplit::core {

struct DracoHeader {
  bool edgebreaker = false;  // otherwise a sequential mesh or a point cloud
  bool valence = false;      // Edgebreaker's valence traversal, otherwise the standard one
  ConnectivityCounts counts;
  bool is_cloud = false;              // sequential points without a list of faces
  uint32_t point_count = 0;           // sequential meshes and point clouds only
  uint32_t attribute_data_count = 0;  // the number of attribute data, which may have seams
  ByteReader body;                    // reads what follows the header

  // Whether 16-bit numbers are enough for all corners, vertices and points.
  PSPLIT_HD bool fits_16_bits() const {
    constexpr uint32_t kMost = 0xffff - 8;
    return counts.face_count <= kMaxFaces<uint16_t> && counts.vertex_limit < kMost && point_count < kMost;
  }
};

// The checks of libdraco, and one that 32-bit numbers are enough for corners and vertices. Sets the limit of
// vertices. The other counts are set.
PSPLIT_HD inline Fault finish_edgebreaker_counts(uint32_t vertex_count, uint32_t split_symbol_count,
                                                 ConnectivityCounts& counts) {
  const uint64_t faces = counts.face_count, vertices = vertex_count;
  if (faces >= kMaxFaces<uint32_t> || vertices > 3 * faces || counts.symbol_count > faces ||
      faces > uint64_t{counts.symbol_count} + counts.symbol_count / 3 ||
      split_symbol_count > counts.symbol_count || counts.split_count > faces ||
      vertices * (vertices > 0 ? vertices - 1 : 0) / 2 < 3 * faces / 2)
    return Fault::kCounts;
  counts.vertex_limit = vertex_count + split_symbol_count;
  return Fault::kNone;
}

PSPLIT_HD inline Fault read_traversal(DracoHeader& header) {
  const uint8_t traversal = header.body.u8();
  if (traversal != 0 && traversal != 2) return header.body.truncated() ? Fault::kTruncated : Fault::kMethod;
  header.valence = traversal == 2;
  return Fault::kNone;
}

PSPLIT_HD inline Fault read_edgebreaker_counts(DracoHeader& header) {
  ByteReader& reader = header.body;
  if (const Fault fault = read_traversal(header); fault != Fault::kNone) return fault;
  ConnectivityCounts& counts = header.counts;
  const uint32_t vertex_count = reader.varint();
  counts.face_count = reader.varint();
  header.attribute_data_count = reader.u8();
  counts.symbol_count = reader.varint();
  const uint32_t split_symbol_count = reader.varint();
  counts.split_count = reader.varint();
  if (reader.truncated()) return Fault::kTruncated;
  return finish_edgebreaker_counts(vertex_count, split_symbol_count, counts);
}

PSPLIT_HD inline Fault read_sequential_counts(DracoHeader& header) {
  ByteReader& reader = header.body;
  header.counts.face_count = reader.varint();
  header.point_count = reader.varint();
  if (reader.truncated()) return Fault::kTruncated;
  // Every face takes at least three bytes.
  return header.counts.face_count > reader.remaining() / 3 ? Fault::kCounts : Fault::kNone;
}

enum class StreamKind : uint8_t { kPointCloud = 0, kMesh = 1 };  // the numbers are Draco's

// What all Draco streams begin with.
struct StreamFront {
  uint32_t major = 0, minor = 0;  // the version of the bitstream
  StreamKind kind = StreamKind::kMesh;
  uint8_t method = 0;
  bool has_metadata = false;
};

PSPLIT_HD inline Fault read_front(ByteReader& reader, StreamFront& front) {
  constexpr uint8_t kMagic[5] = {'D', 'R', 'A', 'C', 'O'};
  for (const uint8_t letter : kMagic)
    if (reader.u8() != letter) return Fault::kNotDraco;
  front.major = reader.u8(), front.minor = reader.u8();
  front.kind = static_cast<StreamKind>(reader.u8());
  front.method = reader.u8();
  constexpr uint32_t kHasMetadata = 0x8000;
  front.has_metadata = (reader.u16() & kHasMetadata) != 0;
  return reader.truncated() ? Fault::kTruncated : Fault::kNone;
}

// Reads up to what a mesh of the header's kind begins with.
PSPLIT_HD inline Fault read_kind(const uint8_t* bytes, size_t size, DracoHeader& header) {
  ByteReader& reader = header.body;
  reader = ByteReader(bytes, size);
  StreamFront front;
  if (const Fault fault = read_front(reader, front); fault != Fault::kNone) return fault;
  constexpr uint8_t kSequential = 0, kEdgebreaker = 1;
  if (front.kind != StreamKind::kMesh) return Fault::kNotDraco;
  if (front.major != 2 || front.minor != 2) return Fault::kVersion;
  if (front.method != kSequential && front.method != kEdgebreaker) return Fault::kMethod;
  if (front.has_metadata)
    if (const Fault fault = skip_metadata(reader); fault != Fault::kNone) return fault;
  header.edgebreaker = front.method == kEdgebreaker;
  return Fault::kNone;
}

PSPLIT_HD inline Fault read_stream_header(const uint8_t* bytes, size_t size, DracoHeader& header) {
  if (const Fault fault = read_kind(bytes, size, header); fault != Fault::kNone) return fault;
  return header.edgebreaker ? read_edgebreaker_counts(header) : read_sequential_counts(header);
}

}  // namespace psplit::core
