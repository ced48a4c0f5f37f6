// The front of a Draco point cloud: its coding and its number of points. Draco bitstream specification 2.2,
// "header", and for bitstream 2.3 libdraco. The two differ only in how attributes follow a kD-tree.
#pragma once

#include "src/core/stream_header.h"

namespace psplit::core {

struct CloudHeader : StreamHeader {
  bool is_kd_tree = false;  // otherwise sequential
  uint32_t minor = 0;       // of bitstream 2.`minor`: 2 or 3
};

PSPLIT_HD inline Fault read_cloud_header(const uint8_t* bytes, size_t size, CloudHeader& header) {
  ByteReader& reader = header.body;
  reader = ByteReader(bytes, size);
  StreamFront front;
  if (const Fault fault = read_front(reader, front); fault != Fault::kNone) return fault;
  constexpr uint8_t kSequential = 0, kKdTree = 1;
  if (front.kind != StreamKind::kPointCloud) return Fault::kNotDraco;
  if (front.major != 2 || front.minor < 2 || front.minor > 3) return Fault::kVersion;
  if (front.method != kSequential && front.method != kKdTree) return Fault::kMethod;
  if (front.has_metadata)
    if (const Fault fault = skip_metadata(reader); fault != Fault::kNone) return fault;
  header.is_cloud = true;
  header.is_kd_tree = front.method == kKdTree;
  header.minor = front.minor;
  header.point_count = reader.u32();
  if (reader.truncated()) return Fault::kTruncated;
  return header.point_count >> 31 != 0 ? Fault::kCounts : Fault::kNone;  // libdraco's number is signed
}

}  // namespace psplit::core
