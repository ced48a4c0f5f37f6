// One mesh to one patch container: weld, partition, encode every patch with libdraco, build the stitch map,
// and prove the result by decoding it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "encoder/coding/attribute_coding.h"
#include "encoder/partition/partition.h"
#include "src/export.h"
#include "src/mesh/mesh.h"
#include "src/parallel.h"
#include "src/status.h"

namespace psplit {

struct EncodeOptions {
  uint32_t patch_count = 1;
  int encode_speed = 5;          // 0 (smallest) to 10 (fastest), libdraco's scale for both of its speeds
  bool keep_duplicates = false;  // keep points that are equal in everything apart
  bool drop_degenerate = false;  // drop faces that repeat an index; they draw nothing
  bool drop_unused = false;      // drop points that no face uses
  // The residue's copies hold the true values too, so that its stream means something on its own.
  bool standalone_residue = false;
  bool verify = true;  // decode the container and compare it with the input before returning
  bool refine = true;  // see PartitionOptions for this and what follows
  PartitionMethod method = PartitionMethod::kMultilevel;
  PathDistance distance = PathDistance::kDijkstra;
  // A partition to take: the patch of each face that is not dropped, or empty for one of our own.
  std::span<const uint32_t> patch_of_face{};
  // Told the number of faces of each patch that is encoded, from any thread; changes nothing of the result.
  std::function<void(size_t)> patch_encoded{};
};

struct EncodeStatistics {
  uint32_t patch_count = 0;    // without the residue
  uint64_t merged_points = 0;  // exact duplicates merged
  uint64_t dropped_faces = 0;
  uint64_t dropped_points = 0;
  uint64_t residue_faces = 0;   // faces that repeat an index, which Edgebreaker cannot carry
  uint64_t residue_points = 0;  // points that no other stream has
  double partition_ms = 0;
  double encode_ms = 0;  // all of encode_mesh except verification
  double verify_ms = 0;
};

struct EncodedMesh {
  std::vector<uint8_t> container;  // src/container/patch_container.h
  // Draco's unique id of each attribute of the input, in order.
  std::vector<uint32_t> unique_ids;
  // For each point of the decoded mesh the input point that it came from: what a morph target, or any other
  // array per point, is reordered by.
  std::vector<uint32_t> source_point;
  // What the container decodes to, where it was verified.
  std::optional<Mesh> decoded;
  EncodeStatistics statistics;
};

// `codings` has one entry per attribute of the mesh. `extra_point_data`, where not empty, holds
// point_count * extra_stride bytes that also keep points apart when duplicates are merged (morph targets).
// Byte-identical for any number of threads. Errors: kUsage (a partition of another number of faces),
// kInvalidInput (indices out of range, no POSITION, values that a quantization grid cannot hold), kUnsupported
// (nothing but degenerate faces, where these are dropped, among others), kRuntimeFailure (verification failed:
// a bug).
PSPLIT_EXPORT Expected<EncodedMesh> encode_mesh(const Mesh& mesh, std::span<const AttributeCoding> codings,
                                                const EncodeOptions& options, const ThreadPool& pool,
                                                std::span<const std::byte> extra_point_data = {},
                                                size_t extra_stride = 0);

}  // namespace psplit
