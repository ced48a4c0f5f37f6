// Whole documents: plain glTF to PSPLIT_mesh_draco_patches and back.
#pragma once

#include <functional>
#include <string>

#include "encoder/encode_mesh.h"
#include "gltf_ext/primitive/primitives.h"
#include "src/container/container.h"

namespace psplit {

enum class QuantizationVolume { kPrimitive, kMesh, kScene };
enum class Fallback { kNone, kUncompressed };
// How patches are stored: stitched in PSPLIT_mesh_draco_patches, or each as a primitive of its own in
// KHR_draco_mesh_compression, which every loader of that opens; points on borders are then there more than
// once.
enum class Compat { kNone, kKhr };

// From how many faces on a primitive is split where nobody says how: two patches then cost about 2 % of its
// bytes (docs/benchmarks.md).
inline constexpr uint64_t kMinFaces = 20000;
// What Compat::kKhr splits a primitive into at most: each patch is a draw call.
inline constexpr uint64_t kMostPatchPrimitives = 8;

struct EncodeDocumentOptions {
  // How many patches: `patches`, else by `patch_faces`, else as default_patch_count says.
  uint64_t patches = 0;            // over all primitives together; 0 means by patch_faces
  uint64_t least_patch_faces = 0;  // where `patches` would have fewer faces each, there are fewer patches
  uint64_t patch_faces = 0;        // a primitive of F faces gets round(F / patch_faces) patches, at least 1
  uint64_t most_patches = 0;       // of a primitive, by default_patch_count; 0 means no bound
  // Smaller primitives stay whole. 0 means kMinFaces for default_patch_count, and no bound otherwise.
  uint64_t min_faces = 0;
  bool always_patches = false;  // primitives that stay whole are stored as one patch of the extension, too
  int position_bits = 14, normal_bits = 10, texcoord_bits = 12, color_bits = 8, generic_bits = 12;
  QuantizationVolume volume = QuantizationVolume::kMesh;
  bool refine = true;  // see PartitionOptions for this and what follows
  PartitionMethod method = PartitionMethod::kMultilevel;
  PathDistance distance = PathDistance::kDijkstra;
  int encode_speed = 5;
  bool lossless = false;         // every attribute exactly as it is
  bool keep_degenerate = false;  // faces that repeat an index
  bool keep_unused = false;      // points that no face uses; Compat::kKhr has no place for them
  bool keep_duplicates = false;  // points that are equal in everything
  Fallback fallback = Fallback::kNone;
  Compat compat = Compat::kNone;
  bool verify = true;
};

// How the output stores a primitive.
enum class StoredAs {
  kAsItWas,
  kPatches,         // PSPLIT_mesh_draco_patches
  kDraco,           // KHR_draco_mesh_compression, one stream
  kPatchPrimitives  // several primitives in KHR_draco_mesh_compression
};

// What became of one primitive.
struct PrimitiveReport {
  PrimitiveId id;       // in the input: with Compat::kKhr a primitive becomes several
  std::string skipped;  // why it was left as it is ("points", "already has the extension"), or empty
  std::vector<std::string> warnings;  // what it lost
  StoredAs stored_as = StoredAs::kAsItWas;
  // Its geometry is that of a primitive before it, and is stored with that one: sums leave its bytes out.
  bool repeated = false;
  uint64_t faces = 0, points = 0;  // of the input, where it was read
  uint64_t input_bytes = 0;        // gltf_ext/primitive/geometry_bytes.h
  uint64_t bytes =
      0;  // of the output's container or streams, a fallback aside; input_bytes where it is as it was
  std::vector<StreamEntry> streams;  // the container's directory
  bool has_residue = false;
  EncodeStatistics statistics;
};

// 2, 4, 8, 16 or a multiple of 16 patches of about 30,000 faces, and one below `min_faces`: threads are busy
// alike, and the bytes over one stream are about 2 % (docs/benchmarks.md).
uint64_t default_patch_count(uint64_t faces, uint64_t min_faces = kMinFaces);

// Replaces the geometry of every triangle primitive in place: what is split by PSPLIT_mesh_draco_patches, and
// what stays whole by KHR_draco_mesh_compression. Left as they are, unless patches were asked for by number, by
// size or by always_patches: stock Draco that would not become smaller, and plain geometry that is smaller than
// its stream. On error the document is unusable. EXT_mesh_manifold, whose data refer to indices, is dropped
// from the meshes of what is replaced. `progress` is told of faces, patch by patch, from any thread.
Expected<std::vector<PrimitiveReport>> encode_document(Document& document, const EncodeDocumentOptions& options,
                                                       const DecodeBackend& backend, const ThreadPool& pool,
                                                       const Progress& progress = {});

// Decodes every patched and every stock Draco primitive into plain accessors, in place.
Status decode_document(Document& document, const DecodeBackend& backend, const ThreadPool& pool,
                       const Progress& progress = {});

// Turns every plain triangle primitive into stock KHR_draco_mesh_compression, one stream each, and says of each
// what became of it; statistics are those of no patches.
Expected<std::vector<PrimitiveReport>> encode_document_stock(Document& document,
                                                             const EncodeDocumentOptions& options,
                                                             const ThreadPool& pool);

// A mesh from a PLY file or `generate` as a document of one node.
Document document_from_mesh(const Mesh& mesh);

}  // namespace psplit
