// How a document is encoded.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "encoder/coding/choose_codings.h"
#include "encoder/coding/position_bits.h"
#include "encoder/partition/partition.h"

namespace psplit {

// Which meshes share one quantization grid per attribute.
enum class QuantizationVolume { kPrimitive, kMesh, kScene };
enum class Fallback { kNone, kUncompressed };
// How patches are stored. kNone: stitched, in PSPLIT_mesh_draco_patches. kKhr: each as a primitive of its own
// in KHR_draco_mesh_compression, which every loader of that extension opens; points on borders are then stored
// more than once.
enum class Compat { kNone, kKhr };

// Primitives of at least this many faces are split if the caller states no limit. Two patches then cost about
// 2 % of the primitive's bytes (docs/benchmarks.md).
inline constexpr uint64_t kMinFaces = 20000;
// The most patches that Compat::kKhr splits a primitive into: each patch is a draw call.
inline constexpr uint64_t kMostPatchPrimitives = 8;

struct EncodeDocumentOptions {
  // The number of patches: `patches`, otherwise by `patch_faces`, otherwise default_patch_count.
  uint64_t patches = 0;            // of all primitives together; 0 means by patch_faces
  uint64_t least_patch_faces = 0;  // `patches` is reduced until each has at least this many faces
  uint64_t patch_faces = 0;        // a primitive of F faces gets round(F / patch_faces) patches, at least 1
  uint64_t most_patches = 0;       // of a primitive, by default_patch_count; 0 means no bound
  // Smaller primitives stay whole. 0 means kMinFaces for default_patch_count, and no bound otherwise.
  uint64_t min_faces = 0;
  bool always_patches = false;  // store primitives that stay whole as one patch of the extension, too
  int position_bits = 14, normal_bits = 10, texcoord_bits = 12, color_bits = 8, generic_bits = 12;
  // One of these replaces position_bits (encoder/coding/position_bits.h). Primitives that share a grid share
  // the bits that suffice for all of them.
  bool position_bits_by_edges = false;  // the fewest bits that the edges allow
  double max_position_error = 0;        // the fewest bits for an error of at most this, in the mesh's own units
  QuantizationVolume volume = QuantizationVolume::kMesh;
  bool refine = true;  // see PartitionOptions for this and the next two
  PartitionMethod method = PartitionMethod::kMultilevel;
  PathDistance distance = PathDistance::kDijkstra;
  int encode_speed = 5;
  bool lossless = false;            // keep every attribute exactly
  bool keep_degenerate = false;     // keep faces that repeat an index
  bool keep_unused = false;         // keep points that no face uses; Compat::kKhr cannot store them
  bool keep_duplicates = false;     // keep points that are equal in every attribute apart
  std::vector<std::string> skip{};  // attributes that are left out: see drop_attributes.h
  Fallback fallback = Fallback::kNone;
  Compat compat = Compat::kNone;
  // Condense the streams of patches, with models that they share: fewer bytes, for loaders that read containers
  // of version 3. Primitives that stay whole become one condensed patch if that saves bytes. A stock Draco
  // stream that stays whole is condensed as it is, and so are patches of the input; both can be restored
  // (expand_document.h). Not with Compat::kKhr.
  bool condense = false;
  bool condense_smallest = false;  // also if that decodes more slowly
  bool verify = true;
  // Names of options that the caller gave and that primitives in patches, which stay as they are, would ignore.
  // Then they are an error.
  std::string options_of_patches{};

  bool chooses_position_bits() const { return position_bits_by_edges || max_position_error > 0; }
  CodingOptions coding() const {
    const int first_bits = chooses_position_bits() ? kMostPositionBits : position_bits;
    return {first_bits, normal_bits, texcoord_bits, color_bits, generic_bits, lossless};
  }
};

}  // namespace psplit
