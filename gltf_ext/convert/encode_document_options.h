// How a document is encoded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "encoder/coding/choose_codings.h"
#include "encoder/coding/position_bits.h"
#include "encoder/encode_mesh.h"
#include "encoder/partition/partition.h"
#include "encoder/patch_counts.h"

namespace psplit {

// Which meshes share one quantization grid of positions, and one of weights.
enum class QuantizationVolume { kPrimitive, kMesh, kScene };
// What loaders without the extension find: nothing; the geometry itself, uncompressed; or coarse primitives,
// with a few of the faces.
enum class Fallback { kNone, kUncompressed, kCoarse };
// Of the faces of a mesh. The Dragon's coarse form then has 4 % of the bytes of its patches (docs/manual.md).
inline constexpr double kCoarseShare = 0.005;
// A mesh keeps at least so many faces, or a tenth if that is less. Primitives that have no more do not become
// patches if there are to be coarse ones.
inline constexpr uint64_t kLeastCoarseFaces = 100;
// How patches are stored. kNone: stitched, in PSPLIT_mesh_draco_patches. kKhr: each as a primitive of its own
// in KHR_draco_mesh_compression, which every loader of that extension opens; points on borders are then stored
// more than once.
enum class Compat { kNone, kKhr };

// The most patches that Compat::kKhr splits a primitive into: each patch is a draw call.
inline constexpr uint64_t kMostPatchPrimitives = 8;

// What patches may take more than one stream, in percent, if nobody asks for them.
inline constexpr uint32_t kMostSplitPercent = 3;

struct EncodeDocumentOptions {
  PatchTarget patches{};
  int position_bits = 14, normal_bits = 10, texcoord_bits = 12, color_bits = 8, generic_bits = 12;
  // Those of them that the user states. All others may grow where they would make equal what a mesh tells apart
  // (encoder/coding/precision_guard.h). Bits that differ from these defaults count as stated.
  GivenBits given_bits{};
  // One of these replaces position_bits (encoder/coding/position_bits.h). Primitives that share a grid share
  // the bits that suffice for all of them.
  bool position_bits_by_edges = false;  // the fewest bits that the edges allow
  double max_position_error = 0;        // the fewest bits for an error of at most this, in the mesh's own units
  QuantizationVolume volume = QuantizationVolume::kMesh;
  bool refine = true;  // see PartitionOptions for this and the next two
  PartitionMethod method = PartitionMethod::kMultilevel;
  PathDistance distance = PathDistance::kDijkstra;
  PatchOrder order{};  // the order of each primitive's patches; with OutOfCoreOptions, of each part's
  bool boxes = false;  // store the box of each patch; not with Compat::kKhr
  int encode_speed = 5;
  bool choose_by_bytes = false;  // in place of encode_speed; see EncodeOptions
  bool by_libdraco = false;      // libdraco encodes the streams, for reference: to the same bytes, in more time
  bool lossless = false;         // keep every attribute exactly
  bool keep_degenerate = false;  // keep faces that repeat an index
  bool keep_unused = false;      // keep points that no face uses; Compat::kKhr cannot store them
  bool keep_duplicates = false;  // keep points that are equal in every attribute apart
  // Attributes that are left out, such as "TEXCOORD_1". kUsage if the asset needs one of them, as a texture its
  // coordinates.
  std::vector<std::string> skip{};
  Fallback fallback = Fallback::kNone;  // kCoarse not with Compat::kKhr
  double coarse_share = kCoarseShare;   // of the faces of a mesh that its coarse primitives have
  Compat compat = Compat::kNone;
  // Condense what is stored without it, if that makes the file smaller: fewer bytes, for loaders that decode
  // condensed streams. So patches share their tables, and a primitive that stays whole, or as it is in stock
  // Draco, becomes one condensed patch. expand_document restores all that. Not with Compat::kKhr.
  bool condense = false;
  bool condense_smallest = false;  // also if that decodes more slowly
  bool verify = true;
  // Names of options that the caller gave and that primitives in patches, which stay as they are, would ignore.
  // Then they are an error.
  std::string options_of_patches{};

  // The most patches of a primitive.
  uint64_t most_patches() const {
    if (patches.most > 0) return patches.most;
    return compat == Compat::kKhr ? kMostPatchPrimitives : UINT64_MAX;
  }
  // Whether patches may cost what they cost. Otherwise kMostSplitPercent limits it.
  bool asks_for_patches() const { return patches.is_given() || patches.min_faces > 0; }
  bool condenses() const { return condense && compat == Compat::kNone; }
  bool chooses_position_bits() const { return position_bits_by_edges || max_position_error > 0; }
  // By which they are chosen if not by the edges.
  std::optional<double> chosen_position_error() const {
    return position_bits_by_edges ? std::nullopt : std::optional(max_position_error);
  }
  CodingOptions coding() const {
    CodingOptions coding{position_bits, normal_bits, texcoord_bits, color_bits,
                         generic_bits,  lossless,    given_bits};
    coding.give_changed_bits();
    if (!chooses_position_bits()) return coding;
    coding.position_bits = kMostPositionBits;
    coding.given.position = !position_bits_by_edges;
    return coding;
  }
};

// How much of an asset is in memory. Meshes that do not fit are encoded part by part, with temporary files.
// The least memory that works.
inline constexpr uint64_t kLeastMemory = uint64_t{128} << 20;

struct OutOfCoreOptions {
  uint64_t memory = 0;              // of the process, in bytes, at least kLeastMemory; 0: no limit
  std::filesystem::path temporary;  // the folder of temporary files, which have no names
  uint64_t most_part_faces = 0;     // smaller parts than the memory allows; 0: no limit
  // The most points of a container; the next container is another primitive.
  uint64_t most_container_points = 0xfffffffe;
  bool to_glb = false;  // the result must fit into a GLB: it is refused as soon as it is known that it does not
  std::function<void(const std::string&)> note{};  // gets a sentence about the temporary space before the work
};

}  // namespace psplit
