// Whole glTF documents: encoded, decoded, and condensed streams expanded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "psplit/base.h"
#include "psplit/decode.h"
#include "psplit/document.h"
#include "psplit/encode.h"
#include "psplit/parallel.h"

namespace psplit {

// ---- Options ----

// Which meshes share one quantization grid of positions, and one of weights.
enum class QuantizationVolume { kPrimitive, kMesh, kScene };
// What loaders without the extension find: nothing; the geometry itself, uncompressed; or coarse primitives,
// with a few of the faces.
enum class Fallback { kNone, kUncompressed, kCoarse };
// The share of a mesh's faces that its coarse primitives keep. At this share, the Dragon's coarse form takes
// 4 % of the bytes of its patches (docs/manual.md).
inline constexpr double kCoarseShare = 0.005;
// The coarse form of a mesh keeps at least this many faces, or a tenth of them if that is less. With
// Fallback::kCoarse, primitives that have no more than this do not become patches.
inline constexpr uint64_t kLeastCoarseFaces = 100;
// How patches are stored. kNone: stitched, in PSPLIT_mesh_draco_patches. kKhr: each as a primitive of its own
// in KHR_draco_mesh_compression, which every loader of that extension opens; points on borders are then stored
// more than once.
enum class Compat { kNone, kKhr };

// How morph targets are stored. kSparse keeps all deltas as they are, but takes -0 for 0 in deltas that are
// zero unless EncodeOptions::lossless is set. kPatches rounds deltas to a grid of the step of what they change
// (CodingOptions::morph_bits); deltas without such a grid, and targets of primitives outside of containers, are
// stored as by kSparse.
enum class MorphTargets {
  kAsFits,   // kPatches for primitives that are in containers anyway: split, condensed, or PatchTarget::always
  kKeep,     // as in the input
  kSparse,   // as sparse accessors where that takes fewer bytes; all-zero targets take none
  kPatches,  // as attributes of the patches. A primitive with targets gets a container
};

// Whether meshoptimizer compresses the data that stay in buffer views, such as animations, morph targets and
// points, and by which extension: EXT_meshopt_compression or KHR_meshopt_compression. The latter is smaller, as
// its codec of attributes is of version 1, and views of the former that the document has become views of it.
enum class MeshoptRest { kNo, kExt, kKhr };
// Precision of animations and of EXT_mesh_gpu_instancing when meshoptimizer compresses them. Key times and
// splines are exact.
inline constexpr int kLeastAnimationBits = 2, kMostAnimationBits = 24;
inline constexpr int kLeastRotationBits = 4, kMostRotationBits = 16, kMostWeightBits = 16;
struct AnimationBits {
  int translation = 16, scale = 16;  // of the largest component of a track or of all instances, with its sign
  int rotation = 12;
  int weight = 8;  // of morph targets: multiples of 2^-weight
};

// The most patches that Compat::kKhr splits a primitive into: each patch is a draw call.
inline constexpr uint64_t kMostPatchPrimitives = 8;

// For each primitive the grids of its attributes, by their names.
using StatedGrids = std::map<PrimitiveId, std::map<std::string, AttributeCoding>>;

// In EncodeDocumentOptions::skip: of each primitive, the texture coordinates that no texture of its materials
// reads, tangents without a normal texture or anisotropy, COLOR_1 and later sets, and joints and weights
// without a skin; unless the asset needs them for anything else.
inline constexpr const char* kUnusedAttributes = "unused";

// The options of the encoder, for all meshes of an asset. Storage::kAsFits and kContainer follow from the
// options here; kOneStream writes stock Draco alone, one stream for each primitive, and leaves no encodable
// primitive as it is. Bits that differ from their defaults count as given.
struct EncodeDocumentOptions : EncodeOptions {
  QuantizationVolume volume = QuantizationVolume::kMesh;
  // Attributes to leave out, such as "TEXCOORD_1", or kUnusedAttributes. kUsage if the asset needs one that is
  // named, for example the coordinates of a texture.
  std::vector<std::string> skip{};
  MorphTargets morph_targets = MorphTargets::kAsFits;  // accessors that meshoptimizer compressed stay so
  Fallback fallback = Fallback::kNone;                 // kCoarse not with Compat::kKhr
  double coarse_share = kCoarseShare;                  // of the faces of a mesh that its coarse primitives have
  Compat compat = Compat::kNone;  // kKhr: without condensed streams and boxes; no unused points are kept
  // Data whose precision is not stated below are compressed without loss. Must be kNo with a limit of memory.
  MeshoptRest meshopt = MeshoptRest::kNo;
  AnimationBits animation_bits{};  // no effect with `lossless`
  // Names of the caller's options that have no effect on primitives that are in patches already. If there is
  // such a primitive, they are an error.
  std::string options_of_patches{};
  // Grids that the streams stated before the document was decoded. Attributes whose values are on them keep
  // them.
  StatedGrids stated{};

  // Whether streams are condensed. Unsplit primitives, and kept stock Draco ones, are condensed as well: each
  // becomes one condensed patch, if that makes the file smaller. expand_document restores the streams.
  bool condenses() const { return condense != Condense::kNo && compat == Compat::kNone; }
  // The options of each mesh.
  PSPLIT_EXPORT EncodeOptions of_meshes() const;
};

// How much of an asset is in memory. Meshes that do not fit are encoded part by part, with temporary files.
// kLeastMemory is the lowest possible limit.
inline constexpr uint64_t kLeastMemory = uint64_t{128} << 20;

struct OutOfCoreOptions {
  uint64_t memory = 0;              // of the process, in bytes, at least kLeastMemory; 0: no limit
  std::filesystem::path temporary;  // the folder of temporary files, which have no names
  uint64_t most_part_faces = 0;     // smaller parts than the memory allows; 0: no limit
  // The most points of a container; the next container is another primitive.
  uint64_t most_container_points = 0xfffffffe;
  bool to_glb = false;  // the result must fit into a GLB; the error comes as soon as it is known not to fit
  std::function<void(const std::string&)> note{};  // called first, with a sentence about temporary space
};

// ---- Reports ----

// How the output stores a primitive.
enum class StoredAs {
  kAsItWas,
  kPatches,         // PSPLIT_mesh_draco_patches
  kDraco,           // KHR_draco_mesh_compression, one stream
  kPatchPrimitives  // several primitives in KHR_draco_mesh_compression
};

struct PrimitiveReport {
  PrimitiveId id;       // in the input: with Compat::kKhr a primitive becomes several
  std::string skipped;  // why it was left as it is ("points or lines", "already in patches"), or empty
  std::vector<std::string> notes;               // how its precision was kept, and at what cost
  std::vector<std::string> warnings;            // what was lost
  std::vector<std::string> dropped_attributes;  // its attributes that EncodeDocumentOptions::skip left out
  // Attributes that kUnusedAttributes would leave out. Empty if the primitive has no material, or if any of its
  // attributes was left out.
  std::vector<std::string> unused_attributes;
  StoredAs stored_as = StoredAs::kAsItWas;
  // An earlier primitive has the same geometry, which is stored once: sums leave this primitive's bytes out.
  bool repeated = false;
  // The input's own streams were kept, and condensed without loss.
  bool keeps_streams = false;
  uint64_t faces = 0, points = 0;  // of the input; 0 if it was not read
  // The bytes in the input of its attributes, its indices and the morph targets that its streams now store.
  uint64_t input_bytes = 0;
  // The bytes of the output's container or streams, without a fallback; input_bytes for kAsItWas.
  uint64_t bytes = 0;
  std::vector<StreamEntry> streams;  // the container's directory
  bool has_residue = false;
  uint64_t head_bytes = 0;          // of its container
  AttributeCoding position_coding;  // 0 bits: stored exactly, or coded by the input's encoder
  EncodeStatistics statistics;
};

// ---- Encoding and decoding ----

// Replaces the geometry of every triangle primitive in place: primitives that are split become
// PSPLIT_mesh_draco_patches, and primitives that stay whole become KHR_draco_mesh_compression. Two kinds are
// left as they are, unless patches were asked for (PatchTarget::is_given): stock Draco that would not become
// smaller, and plain geometry that is smaller than its stream. EXT_mesh_manifold is dropped from the meshes of
// replaced primitives, because its data refer to indices. At the end, the selected streams are condensed
// (EncodeDocumentOptions::condense).
//
// Primitives that are in patches already stay as they are, except with Compat::kKhr. Each is decoded once to
// check it; an invalid one is an error.
//
// With limits.memory, plain primitives that do not fit into memory are encoded part by part, and always become
// patches, or streams of their own with Compat::kKhr; the buffers should be mapped (FileAccess::kMap). A
// primitive that exceeds a container, or the memory for condensing, becomes several primitives. kUnsupported if
// a primitive encoded in parts shares its grid with others, or, with keep_unused, its points.
//
// After an error the document is unusable. `progress` counts faces, patch by patch, and is called from any
// thread.
PSPLIT_EXPORT Expected<std::vector<PrimitiveReport>> encode_document(
    Document& document, const EncodeDocumentOptions& options, const DecodeBackend& backend,
    const ThreadPool& pool, const Progress& progress = {}, const OutOfCoreOptions& limits = {});

struct Finding;

// Decodes every primitive in patches and every primitive in stock Draco into plain accessors, in place. If they
// exceed `limit`, the CPU decodes all primitives in patches, window by window, into a temporary file, which
// becomes a buffer of the document; write_document writes the same file in both cases. Primitives in stock
// Draco are decoded one after the other, each of them in memory. Coarse primitives are dropped. Views that
// meshoptimizer compressed become plain as well. A buffer that ends with other data, at an odd multiple of 4,
// is followed by 8 more bytes. After an error the document may be unusable. Primitives in patches are decoded
// by the CPU, which also compares copies of points, unless `backend` is CUDA's or libdraco's. `corrections`, if
// it is not null, gets a finding for each accessor of stock Draco whose count its stream contradicts; the
// document gets the stream's count.
PSPLIT_EXPORT Status decode_document(Document& document, const DecodeBackend& backend, const ThreadPool& pool,
                                     const Progress& progress = {}, const MemoryLimit& limit = {},
                                     std::vector<Finding>* corrections = nullptr);

struct ExpandReport {
  size_t primitives = 0;                       // in the document
  size_t to_patches = 0;                       // whose container now has Draco streams
  size_t to_draco = 0;                         // now KHR_draco_mesh_compression
  uint64_t bytes_before = 0, bytes_after = 0;  // of these primitives' containers and streams; shared ones once
};

// Expands every container of condensed streams in place. A container of one patch without residue becomes
// KHR_draco_mesh_compression, with its patch as the stream. Points that its stitch map joined are then
// separate, so such a primitive must have no fallback, morph targets or other attributes. All other containers
// become containers of Draco streams. Each stream equals libdraco's output, bit for bit. Nothing else in the
// document changes, except the lists of used extensions: the result equals the encoder's output without
// condensing. `backend` decodes all primitives once to check them, and the CPU decodes the written streams; the
// errors of decode_document apply. After an error the document is unusable.
PSPLIT_EXPORT Expected<ExpandReport> expand_document(Document& document, const DecodeBackend& backend,
                                                     const ThreadPool& pool);

}  // namespace psplit
