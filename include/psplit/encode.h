// The door of the encoder: from meshes to Draco streams, and to containers of patches. Everything that encodes
// goes through it: the command, C, Python, the web.
//
// One mesh takes one call:
//
//   Expected<Mesh> mesh = mesh_of(view);
//   Expected<EncodedMesh> encoded = encode(std::move(*mesh), {}, pool);
//
// Meshes that belong together, as the primitives of a glTF mesh, share their grids. plan() chooses these for
// all of them, and encode() then takes one after the other.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "psplit/base.h"
#include "psplit/decode.h"
#include "psplit/mesh.h"
#include "psplit/parallel.h"

namespace psplit {

// ---- How values are stored ----

inline constexpr int kMostGridBits = 30;  // of a component on a quantization grid: libdraco's limit

// How the values of one attribute are stored. bits == 0 keeps them exactly as they are.
struct AttributeCoding {
  int bits = 0;             // 1 to kMostGridBits; only for kFloat32 attributes
  bool octahedral = false;  // NORMAL: unit vectors on an octahedral grid of `bits` (2 or more)
  // The grid of every other quantized attribute: value = origin + i * range / (2^bits - 1). Each component has
  // an origin of its own. Meshes that must fit together need the same grid. The encoder fits grids that
  // libdraco reproduces to the bit.
  std::vector<float> origin;
  float range = 0;
  bool exact = false;  // every value is on the grid, and comes back as it is
};

// A sentence about an attribute, which it names.
struct PrecisionNote {
  std::string text;
  bool is_warning = false;  // something is lost: the caller gave the bits, so that nothing was done
};

// The attributes whose bits the user states.
struct GivenBits {
  bool position = false, normal = false, texcoord = false, color = false, generic = false;
};

// Bits of a component on its quantization grid; 0 keeps the values exactly as they are.
struct CodingOptions {
  int position_bits = 14, normal_bits = 10, texcoord_bits = 12, color_bits = 8, generic_bits = 12;
  bool lossless = false;  // every attribute exactly as it is
  // Grids of given bits stay, even if they lose what the mesh tells apart.
  GivenBits given{};
  std::set<std::string> exact{};  // names of attributes that are kept exactly
  // Of morph targets. Their step is that which the grid of the attribute that they change would have with so
  // many bits; 0: the step that it has.
  int morph_bits = 0;

  // For callers who do not know what the user states: bits that differ from the default count as given.
  PSPLIT_EXPORT void give_changed_bits();
};

// ---- Into how many patches meshes are cut, and how ----

// Primitives of at least this many faces are split if the caller states no limit. Two patches then cost about
// 2 % of the primitive's bytes (docs/benchmarks.md).
inline constexpr uint64_t kMinFaces = 20000;
// Faces of a patch if decoding is to take the least time. On one thread and on several, patches of this size
// decode fastest (docs/benchmarks.md).
inline constexpr uint64_t kSpeedPatchFaces = 4800;
// The most patches if bytes count more. Four patches keep four threads busy, at less than a third of the cost
// of 16 patches.
inline constexpr uint64_t kMostPatchesForSize = 4;

// Into how many patches primitives are cut: by `count`, otherwise by `faces`. If both are 0, a primitive of
// kMinFaces or more is cut into 2, 4, 8, 16 or a multiple of 16 patches of about 30,000 faces.
struct PatchTarget {
  uint64_t count = 0;        // of all primitives together
  uint64_t least_faces = 0;  // `count` is reduced until each patch has at least this many faces
  uint64_t faces = 0;        // of a patch: a primitive of F faces gets round(F / faces) patches, at least 1
  uint64_t most = 0;         // of a primitive, if count and faces are 0; 0 means no bound
  // Smaller primitives stay whole. 0 means kMinFaces if count and faces are 0, and no bound otherwise.
  uint64_t min_faces = 0;
  bool always = false;  // store meshes that stay whole as one patch, too, and patches whatever they cost

  // Whether the caller asks for patches, and does not leave it to the size of each primitive.
  bool is_given() const { return count > 0 || faces > 0 || always; }
};

// 2, 4, 8, 16 or a multiple of 16 patches of about 30,000 faces, and one patch below `min_faces`. Threads then
// get equal work, and the bytes beyond those of a single stream are about 2 % (docs/benchmarks.md).
PSPLIT_EXPORT uint64_t default_patch_count(uint64_t faces, uint64_t min_faces = kMinFaces);

// The number of patches of each primitive, given its number of faces.
PSPLIT_EXPORT std::vector<uint32_t> patch_counts(Span<const uint64_t> faces, const PatchTarget& target);

// How the faces are cut into patches, by their connectivity alone.
enum class PartitionMethod {
  kMultilevel,  // levels of cells; the coarsest graph is cut in halves, and borders are refined at each level
  kPaper,       // farthest-point samples, clusters of faces around them, k-means of the clusters
};

// How the paper's method measures the distance between faces.
enum class PathDistance {
  kDijkstra,  // shortest paths along edges and over the centres of faces
  kGeodesic,  // fast marching, straight across faces
};

// ---- Options ----

// What becomes of a mesh.
enum class Storage : uint8_t {
  kAsFits,     // a container of patches; one Draco stream if the mesh is not split
  kContainer,  // a container, of one patch if the mesh is not split; see also PatchTarget::always
  kStreams,    // each patch as a Draco stream of its own. Points at borders are in several
  kOneStream,  // one Draco stream, which drops unused points and degenerate faces
  kInOrder,    // one sequential Draco stream, which keeps all faces and points, and their order
  // One Draco point cloud of a mesh without faces, which keeps all points. As in libdraco, it is a kD-tree,
  // with an order of its own, at speeds below 10 if all attributes are integers or on a grid; otherwise
  // sequential, in their order. In a tree the three components of normals are on a grid, and not on an
  // octahedron.
  kCloud,
};

// The order of patches in their container. Decoders that get it byte by byte have the first ones first.
struct PatchOrder {
  enum class By : uint8_t {
    kCut,   // as they were cut: neighbours are near to each other
    kSize,  // first those with the largest area
    kNear,  // first those whose nearest point is nearest to `point`
  };
  By by = By::kCut;
  std::array<double, 3> point{};  // in the coordinates of POSITION
};

// Whether a container's streams are condensed, if that saves bytes: coded with tables that all patches share.
enum class Condense : uint8_t {
  kNo,
  kFast,      // what decodes more slowly must save bytes worth it
  kSmallest,  // the fewest bytes
};

// What patches may take more than one stream, in percent, if nobody asks for them.
inline constexpr uint32_t kMostSplitPercent = 3;

inline constexpr int kMostEncodeSpeed = 10;

// The defaults are those of `gltf-psplit encode`. The bits of attributes are those of CodingOptions.
struct EncodeOptions : CodingOptions {
  PatchTarget patches{};
  Storage storage = Storage::kAsFits;
  // One of these replaces position_bits. Meshes that share a grid share the bits that suffice for all of them.
  bool position_bits_by_edges = false;  // the fewest bits that the edges allow
  double max_position_error = 0;        // the fewest bits for an error of at most this, in the mesh's own units
  int encode_speed = 5;  // 0 (fewest bytes for most meshes) to 10 (fastest), libdraco's scale for its speeds
  // Each stream gets the fewest bytes that one of Draco's predictions gives it, in place of what encode_speed
  // chooses. They are tried for each attribute of each patch, so encoding takes longer. Decoding should, too,
  // where predictions are those of speed 0. Any Draco decoder reads the streams. libdraco cannot choose so: no
  // effect with by_libdraco.
  bool choose_by_bytes = false;
  bool by_libdraco = false;  // libdraco encodes the streams, for reference: to the same bytes, in more time
  Condense condense = Condense::kNo;
  PatchOrder order{};
  // Store the box of each patch: 6 bytes each, and 28 of a mesh. A viewer chooses by them what it shows first.
  bool boxes = false;
  bool keep_degenerate = false;  // keep faces that repeat an index; they draw nothing
  bool keep_unused = false;      // keep points that no face uses; not with kStreams
  bool keep_duplicates = false;  // keep points that are equal in every attribute apart
  bool refine = true;            // false keeps the jagged borders of plain clustering
  PartitionMethod method = PartitionMethod::kMultilevel;
  PathDistance distance = PathDistance::kDijkstra;
  bool verify = true;  // decode the result, and compare it with the input

  // With the bits that plan() begins with, and what follows from them about which are given.
  EncodeOptions with_first_bits() const;
  bool chooses_position_bits() const { return position_bits_by_edges || max_position_error > 0; }
  // Whether patches may cost what they cost. Otherwise kMostSplitPercent limits it.
  bool asks_for_patches() const { return patches.is_given() || patches.min_faces > 0; }
};

// Values beside the attributes, such as morph targets: `width` bytes for each point.
struct PointData {
  Span<const std::byte> values;
  size_t width = 0;
};

// How one attribute is stored, in place of what the options say about all attributes of its kind.
struct OwnCoding {
  int bits = 0;                           // 1 to 30; 0: exactly
  std::optional<AttributeCoding> grid{};  // has the bits, too
};

// ---- A mesh, and what it becomes ----

// A mesh on its way through the encoder.
struct MeshToEncode {
  Mesh mesh;
  size_t group = 0;  // meshes of a group share a grid for positions, and one for weights
  // Points that differ in these are not merged. The caller's, until the mesh is encoded.
  std::vector<PointData> distinct{};
  std::map<size_t, OwnCoding> own_codings{};  // by attribute
  // By how much textures enlarge coordinates (KHR_texture_transform), by attribute.
  std::map<std::string, double> texture_scales{};
  // The grid of each attribute that the input states, with 0 bits for none; empty if there are none at all.
  // Values that are on it keep it, so that encoding the output of an encoder changes nothing.
  std::vector<AttributeCoding> stated{};

  bool is_condensed_later = false;  // by the caller, who has more streams to condense
  bool needs_container = false;     // Storage::kAsFits stores it as a container, also if it is not split

  // plan() sets all of these.
  std::vector<AttributeCoding> codings{};  // of each attribute; until encode() the caller may change them
  std::vector<PrecisionNote> notes{};      // what was done for its precision, and what it loses
  std::vector<Attribute> unrounded{};      // weights and morph targets as they were
  uint32_t patch_count = 1;
};

// The caller's arrays as a mesh. Values of an attribute that is named twice, too few bytes, and types that are
// neither glTF's nor those of indices are errors: kUsage, kUnsupported.
PSPLIT_EXPORT Expected<Mesh> mesh_of(const MeshView& view);

// A mesh of a group that is left as it is, on the grid of its positions.
struct KeptMesh {
  size_t group = 0;
  AttributeCoding positions{};
};

class StoredBytes;  // bytes that do not have to fit into memory

struct EncodeStatistics {
  uint32_t patch_count = 0;    // without the residue
  uint64_t merged_points = 0;  // duplicates that were merged
  uint64_t dropped_faces = 0;
  uint64_t dropped_points = 0;
  uint64_t residue_faces = 0;   // faces that repeat an index, which Edgebreaker cannot encode
  uint64_t residue_points = 0;  // points that no other stream has
  // The largest distance between a position of the input and its decoded position. Nothing if it was not
  // verified.
  std::optional<double> position_error;
  double partition_ms = 0;
  double encode_ms = 0;  // all of encoding except decoding and verifying the whole
  double verify_ms = 0;
};

// A container of patches, or a Draco stream without a container.
struct EncodedPiece {
  bool is_container = true;
  std::vector<uint8_t> bytes;
  std::shared_ptr<StoredBytes> stored;  // the bytes of a mesh that was encoded in parts, instead of `bytes`
  std::vector<StreamEntry> entries;     // the directory's rows; that of a lone stream has no stitch map
  uint32_t head_bytes = 0;              // of the container's head: what condensed streams share, and boxes
  uint32_t point_count = 0, face_count = 0;
  uint32_t used_point_count = 0;  // without those that no face uses, which come last
  // What it decodes to, and for each decoded point the input point that it was. Morph targets and other arrays
  // per point are reordered accordingly. Of a mesh in parts `bounds` instead: of the decoded values of each
  // attribute.
  Mesh decoded;
  std::vector<uint32_t> source_point;
  std::vector<ValueBounds> bounds;

  PSPLIT_EXPORT uint64_t size() const;  // in bytes
};

struct EncodedMesh {
  // One in most cases. A mesh in parts may exceed a container, and patches may be streams of their own. If
  // pieces share a point, each has it.
  std::vector<EncodedPiece> pieces;
  // In the order of the input's attributes: how to request each from a decoder, and how it is stored.
  std::vector<AttributeRequest> requests;
  std::vector<AttributeCoding> codings;
  std::vector<PrecisionNote> notes;  // what was done for its precision, and what it loses
  EncodeStatistics statistics;       // of all pieces together

  bool is_in_container() const { return !pieces.empty() && pieces.front().is_container; }
};

// ---- Encoding ----

// Chooses how the attributes of all meshes are stored, and into how many patches each is cut. Grids whose bits
// are not given are finer where they would lose what a mesh tells apart. Values of quantized attributes that
// exceed glTF's limits by rounding noise are set to the limits, and weights are rounded to their grid so that
// they keep their sum. `failed`, if it is not null, gets the number of the mesh of an error. Errors: kUsage for
// options that are out of their range, or contradict each other; kInvalidInput, kUnsupported for meshes that
// cannot be encoded; kUsage if no bits suffice for max_position_error.
PSPLIT_EXPORT Status plan(Span<MeshToEncode* const> meshes, const EncodeOptions& options,
                          const ThreadPool& pool, Span<const KeptMesh> kept = {}, size_t* failed = nullptr);

// Encodes a mesh that was planned with the same options: merges equal points, drops what draws nothing, cuts
// it into mesh.patch_count patches or fewer (kMostSplitPercent), encodes these, stitches and condenses them,
// and decodes the result to compare it. Progress counts faces, patch by patch, and is called from any thread.
// The result is byte-identical for any number of threads. Errors: kCancelled; kUnsupported (among others, only
// degenerate faces that are to be dropped); kRuntimeFailure (verification failed, which is a bug). The patch is
// the place of an error, if it has one.
PSPLIT_EXPORT Expected<EncodedMesh> encode(const MeshToEncode& mesh, const EncodeOptions& options,
                                           const ThreadPool& pool, const Watch& watch = {});
// The same, which frees the faces and values of the mesh as soon as it can.
PSPLIT_EXPORT Expected<EncodedMesh> encode(MeshToEncode&& mesh, const EncodeOptions& options,
                                           const ThreadPool& pool, const Watch& watch = {});

// Plans and encodes one mesh.
PSPLIT_EXPORT Expected<EncodedMesh> encode(Mesh mesh, const EncodeOptions& options, const ThreadPool& pool,
                                           const Watch& watch = {});

// ---- libdraco, for comparison ----

// Decodes each stream with libdraco to a mesh of libdraco's, one thread for each patch. Stock streams may be of
// any bitstream that libdraco knows. Errors: kInvalidInput. Checks before each task whether to stop, and
// reports progress in tasks. Thread-safe.
PSPLIT_EXPORT DecodeBackend draco_backend();

// For loaders (loader.h, tinygltf.h): what decodes bitstreams before 2.2. Null in a build without libdraco.
PSPLIT_EXPORT const OlderStreams* older_streams();

// The version of the libdraco that this was built with; empty if there is none.
PSPLIT_EXPORT std::string draco_version();
inline bool has_draco() { return !draco_version().empty(); }

}  // namespace psplit
