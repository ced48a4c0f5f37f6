// How a document is encoded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "encoder/encode.h"
#include "gltf_ext/document/asset_records.h"
#include "src/export.h"

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

// For each primitive the grids of its attributes, by their names.
using StatedGrids = std::map<PrimitiveId, std::map<std::string, AttributeCoding>>;

// The options of the encoder, for all meshes of an asset. Storage::kAsFits and kContainer follow from the
// options here; kOneStream writes stock Draco alone, one stream for each primitive, and leaves none that can be
// encoded as it is. Bits that differ from their defaults count as given.
struct EncodeDocumentOptions : EncodeOptions {
  QuantizationVolume volume = QuantizationVolume::kMesh;
  // Attributes that are left out, such as "TEXCOORD_1". kUsage if the asset needs one of them, as a texture its
  // coordinates.
  std::vector<std::string> skip{};
  Fallback fallback = Fallback::kNone;  // kCoarse not with Compat::kKhr
  double coarse_share = kCoarseShare;   // of the faces of a mesh that its coarse primitives have
  Compat compat = Compat::kNone;        // kKhr: without condensed streams and boxes; no unused points are kept
  // Names of options that the caller gave and that primitives in patches, which stay as they are, would ignore.
  // Then they are an error.
  std::string options_of_patches{};
  // Grids that streams stated before the document was decoded. Values that are on them keep them.
  StatedGrids stated{};

  // Condensed are also primitives that stay whole, or as they are in stock Draco: each becomes one condensed
  // patch, if that makes the file smaller. expand_document restores all that.
  bool condenses() const { return condense != Condense::kNo && compat == Compat::kNone; }
  // The options of each mesh.
  PSPLIT_EXPORT EncodeOptions of_meshes() const;
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
