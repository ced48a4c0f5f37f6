// Whole documents: plain glTF to PSPLIT_mesh_draco_patches and back.
#pragma once

#include <functional>
#include <string>

#include "encoder/encode_mesh.h"
#include "gltf_ext/primitives.h"
#include "src/container/container.h"

namespace psplit {

enum class QuantizationVolume { kPrimitive, kMesh, kScene };
enum class Fallback { kNone, kUncompressed };
// How patches are stored: stitched in PSPLIT_mesh_draco_patches, or each as a primitive of its own in
// KHR_draco_mesh_compression, which every loader of that opens; points on borders are then there more than
// once.
enum class Compat { kNone, kKhr };

struct EncodeDocumentOptions {
  uint64_t patches = 0;            // over all primitives together; 0 means by patch_faces
  uint64_t least_patch_faces = 0;  // where `patches` would have fewer faces each, there are fewer patches
  uint64_t patch_faces = 4800;     // a primitive of F faces gets round(F / patch_faces) patches, at least 1
  int position_bits = 14, normal_bits = 10, texcoord_bits = 12, color_bits = 8, generic_bits = 12;
  QuantizationVolume volume = QuantizationVolume::kPrimitive;
  bool refine = true;  // see PartitionOptions for this and what follows
  PartitionMethod method = PartitionMethod::kMultilevel;
  PathDistance distance = PathDistance::kDijkstra;
  int encode_speed = 5;
  bool lossless = false;  // every attribute exactly as it is
  bool drop_degenerate = false;
  bool keep_duplicates = false;
  Fallback fallback = Fallback::kNone;
  Compat compat = Compat::kNone;
  bool verify = true;
};

// What became of one primitive.
struct PrimitiveReport {
  PrimitiveId id;       // in the input: with Compat::kKhr a primitive becomes several
  std::string skipped;  // why it was left as it is ("points", "already has the extension"), or empty
  std::vector<std::string> warnings;  // what it lost
  uint64_t faces = 0, points = 0;     // of the input
  uint64_t bytes = 0;                 // container, or the streams of Compat::kKhr
  std::vector<StreamEntry> streams;   // the container's directory
  bool has_residue = false;
  EncodeStatistics statistics;
};

// Replaces the geometry of every triangle primitive in place. On error the document is unusable.
// EXT_mesh_manifold, whose data refer to indices, is dropped from the meshes of what is replaced.
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
