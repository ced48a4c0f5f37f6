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
// Of the faces of a mesh. The Dragon's coarse form then has 4 % of the bytes of its patches (docs/manual.md).
inline constexpr double kCoarseShare = 0.005;
// A mesh keeps at least so many faces, or a tenth if that is less. Primitives that have no more do not become
// patches if there are to be coarse ones.
inline constexpr uint64_t kLeastCoarseFaces = 100;
// How patches are stored. kNone: stitched, in PSPLIT_mesh_draco_patches. kKhr: each as a primitive of its own
// in KHR_draco_mesh_compression, which every loader of that extension opens; points on borders are then stored
// more than once.
enum class Compat { kNone, kKhr };

// How morph targets are stored. kSparse keeps all deltas as they are, but takes -0 for 0 in deltas that are
// zero unless EncodeOptions::lossless is set. kPatches rounds deltas to a grid of the step of what they change
// (CodingOptions::morph_bits); those that have no such grid, and targets of primitives that no container has,
// are stored as by kSparse.
enum class MorphTargets {
  kAsFits,   // kPatches for primitives that are in containers anyway: split, condensed, or PatchTarget::always
  kKeep,     // as in the input
  kSparse,   // as sparse accessors where that takes fewer bytes. Targets that are zero everywhere take none
  kPatches,  // as attributes of the patches. A primitive with targets gets a container
};

// Whether meshoptimizer compresses what stays in buffer views, such as animations, morph targets and points,
// and the extension that says so: EXT_meshopt_compression or KHR_meshopt_compression.
enum class MeshoptRest { kNo, kExt, kKhr };
// Of animations, and of EXT_mesh_gpu_instancing, that meshoptimizer compresses. Times of keys, and splines, are
// exact.
inline constexpr int kLeastAnimationBits = 2, kMostAnimationBits = 24;
inline constexpr int kLeastRotationBits = 4, kMostRotationBits = 16, kMostWeightBits = 16;
struct AnimationBits {
  int translation = 16, scale = 16;  // of the largest component of a track or of the instances, with its sign
  int rotation = 12;
  int weight = 8;  // of morph targets: multiples of 2^-weight
};

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
  MorphTargets morph_targets = MorphTargets::kAsFits;  // accessors that meshoptimizer compressed stay so
  Fallback fallback = Fallback::kNone;                 // kCoarse not with Compat::kKhr
  double coarse_share = kCoarseShare;                  // of the faces of a mesh that its coarse primitives have
  Compat compat = Compat::kNone;  // kKhr: without condensed streams and boxes; no unused points are kept
  // Whatever else has to be exact or has no precision here is compressed without loss. kNo with limits of
  // memory.
  MeshoptRest meshopt = MeshoptRest::kNo;
  AnimationBits animation_bits{};  // no effect with `lossless`
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
  std::vector<std::string> notes;               // what was done for its precision, and what that costs
  std::vector<std::string> warnings;            // what it lost
  std::vector<std::string> dropped_attributes;  // those of EncodeDocumentOptions::skip that it had
  StoredAs stored_as = StoredAs::kAsItWas;
  // An earlier primitive has the same geometry, which is stored once: sums leave this primitive's bytes out.
  bool repeated = false;
  // The streams are those of the input, condensed without loss.
  bool keeps_streams = false;
  uint64_t faces = 0, points = 0;  // of the input; 0 if it was not read
  // Of its attributes, its indices and the morph targets that its streams store, as the input stores them.
  uint64_t input_bytes = 0;
  // Those of the output's container or streams, without a fallback; input_bytes for kAsItWas.
  uint64_t bytes = 0;
  std::vector<StreamEntry> streams;  // the container's directory
  bool has_residue = false;
  uint64_t head_bytes = 0;          // of its container
  AttributeCoding position_coding;  // 0 bits: positions are stored exactly, or by the input's encoder
  EncodeStatistics statistics;
};

// ---- Encoding and decoding ----

// Replaces the geometry of every triangle primitive in place: primitives that are split become
// PSPLIT_mesh_draco_patches, and primitives that stay whole become KHR_draco_mesh_compression. Two kinds are
// left as they are, unless patches were asked for (PatchTarget::is_given): stock Draco that would not become
// smaller, and plain geometry that is smaller than its stream. EXT_mesh_manifold is dropped from the meshes of
// replaced primitives, because its data refer to indices. Then all that is wanted is condensed
// (EncodeDocumentOptions::condense).
//
// Primitives that are in patches already stay as they are, except with Compat::kKhr. They are decoded once and
// checked whole; an invalid one is an error.
//
// With limits.memory, plain primitives that do not fit into memory are encoded part by part, and always become
// patches, or streams of their own with Compat::kKhr; the buffers should be mapped (FileAccess::kMap). One that
// exceeds a container, or what can be condensed in memory, becomes several primitives. kUnsupported if such a
// primitive would share its grid with others, or with keep_unused its points.
//
// After an error the document is unusable. `progress` counts faces, patch by patch, and is called from any
// thread.
PSPLIT_EXPORT Expected<std::vector<PrimitiveReport>> encode_document(
    Document& document, const EncodeDocumentOptions& options, const DecodeBackend& backend,
    const ThreadPool& pool, const Progress& progress = {}, const OutOfCoreOptions& limits = {});

struct Finding;

// Decodes every primitive in patches and every primitive in stock Draco into plain accessors, in place. If they
// are too large for `limit`, the CPU decodes all primitives in patches, window by window, into a temporary
// file, which becomes a buffer of the document; the file that write_document makes is the same. Primitives in
// stock Draco are decoded one after the other, each of them in memory. Coarse primitives are dropped. Views
// that meshoptimizer compressed become plain, too. An exception: a buffer that ends with other data, at an odd
// multiple of 4, is followed by 8 bytes more. After an error the document may be of no use. Primitives in
// patches are decoded by the CPU, which also compares copies of points, unless `backend` is CUDA's or
// libdraco's. `corrections`, if it is not null, gets the counts of accessors of stock Draco that its streams
// contradict: the document has those of the streams.
PSPLIT_EXPORT Status decode_document(Document& document, const DecodeBackend& backend, const ThreadPool& pool,
                                     const Progress& progress = {}, const MemoryLimit& limit = {},
                                     std::vector<Finding>* corrections = nullptr);

struct ExpandReport {
  size_t primitives = 0;                       // all of the document
  size_t to_patches = 0;                       // those whose container has Draco streams now
  size_t to_draco = 0;                         // those that are KHR_draco_mesh_compression now
  uint64_t bytes_before = 0, bytes_after = 0;  // of these primitives' containers and streams; shared ones once
};

// Expands every container of condensed streams in place. A container of one patch without residue becomes the
// stream of KHR_draco_mesh_compression that its patch is. If its stitch map joins points, these are apart then,
// so it needs a primitive without a fallback, morph targets or other attributes. All others become containers
// of Draco streams. Streams are those that libdraco's encoder wrote, bit for bit. Nothing else in the document
// changes, except the lists of used extensions: it is what the encoder would have made without condensing. All
// primitives are decoded once, by `backend`, and what is written by the CPU: what decode_document refuses is
// refused here. After an error the document is unusable.
PSPLIT_EXPORT Expected<ExpandReport> expand_document(Document& document, const DecodeBackend& backend,
                                                     const ThreadPool& pool);

}  // namespace psplit
