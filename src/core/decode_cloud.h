// One Draco point cloud to points and integers.
//
//   header       cloud_header.h         the number of points, and which coding follows
//   attributes
//     sequential attribute_decoder.h    as in a mesh without faces: decode_patch.h
//     kD-tree    kd_tree_attributes.h   groups and descriptions, and for each group:
//       tree     kd_tree.h              numbers of points in halves of boxes -> integers by point
//   output       patch.h                integers -> values of the attribute's type (value_writer.h)
#pragma once

#include "src/core/kd_tree_attributes.h"
#include "src/core/workspace.h"

namespace psplit::core {

// To libdraco, integers of no point are a failure.
template <typename Index>
PSPLIT_HD Fault check_integers(const Patch<Index>& cloud) {
  for (uint32_t i = 0; cloud.point_count == 0 && i < cloud.attributes.size(); ++i)
    if (cloud.attributes[i].coding != Coding::kRaw) return Fault::kCounts;
  return Fault::kNone;
}

// Decodes a cloud whose header was read, to a patch without faces. Index must be wide enough: see
// StreamHeader::fits_16_bits. The bytes may be anything: a fault names their error, and no memory but theirs
// and the arena's is touched. Thread-safe, as long as each thread has an arena of its own.
template <typename Index, StreamKinds kKinds = StreamKinds::kBoth>
PSPLIT_HD Fault decode_cloud(const CloudHeader& header, Arena& arena, Patch<Index>& out) {
  if (header.is_kd_tree) return KdTreeAttributes<Index>(header, arena, out).decode();
  const Fault fault = decode_patch<Index, kKinds>(header, arena, out);
  return fault == Fault::kNone ? check_integers(out) : fault;
}

// Like decode_cloud, but without values: reads the descriptions of attributes; of kD-trees without their grids.
template <typename Index>
PSPLIT_HD Fault outline_cloud(const CloudHeader& header, Arena& arena, Patch<Index>& out) {
  if (header.is_kd_tree) return KdTreeAttributes<Index>(header, arena, out).outline();
  const Fault fault = outline_patch<Index>(header, arena, out);
  return fault == Fault::kNone ? check_integers(out) : fault;
}

// Enough memory to decode any cloud that an encoder wrote, if `values` holds.
template <typename Index>
PSPLIT_HD size_t cloud_workspace_bytes(const CloudHeader& header, size_t stream_bytes,
                                       const ValueCounts& values) {
  if (header.is_kd_tree) return KdTreeAttributes<Index>::bytes(values);
  // While a table is read it has a slot for each symbol that may come. A mesh has memory for that anyway.
  return workspace_bytes<Index>(header, stream_bytes, values) +
         RansTable::slot_bytes(uint64_t{values.points} * values.components, stream_bytes);
}

}  // namespace psplit::core
