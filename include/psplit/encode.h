// The encoder's interface: it turns meshes into Draco streams, and into containers of patches. The command and
// the packages for C, Python and the web all encode through it.
//
// One mesh takes one call:
//
//   Expected<Mesh> mesh = mesh_of(view);
//   Expected<EncodedMesh> encoded = encode(std::move(*mesh), {}, pool);
//
// Meshes that belong together, such as the primitives of a glTF mesh, share quantization grids. plan() chooses
// the grids for all of them; encode() then encodes them one by one.
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
  bool exact = false;  // every value is on the grid, and decodes to the same value
};

// A sentence about the precision of one attribute, whose name it contains.
struct PrecisionNote {
  std::string text;
  bool is_warning = false;  // precision is lost, because the caller's own number of bits was kept
};

// The attributes whose bits the user states.
struct GivenBits {
  bool position = false, normal = false, texcoord = false, color = false, generic = false;
};

// Bits of each component on its quantization grid; 0 keeps the values exactly.
struct CodingOptions {
  int position_bits = 14, normal_bits = 10, texcoord_bits = 12, color_bits = 8, generic_bits = 12;
  bool lossless = false;  // every attribute exactly as it is
  // Attributes whose bits are given keep them, even if values that differ in the mesh then become equal.
  GivenBits given{};
  std::set<std::string> exact{};  // names of attributes that are kept exactly
  // Of morph targets: their deltas have the step that the grid of their base attribute would have with this
  // number of bits; 0: the step that it has.
  int morph_bits = 0;

  // For callers who do not know what the user states: bits that differ from the default count as given.
  PSPLIT_EXPORT void give_changed_bits();
};

// ---- Into how many patches meshes are cut, and how ----

// Primitives of at least this many faces are split if the caller states no limit. Two patches of such a
// primitive cost about 2 % of its bytes (docs/benchmarks.md).
inline constexpr uint64_t kMinFaces = 20000;
// Faces of a patch for the shortest decoding time. Patches of this size decode fastest on one thread and on
// several (docs/benchmarks.md).
inline constexpr uint64_t kSpeedPatchFaces = 4800;
// The most patches if size matters more than time. Four patches keep four threads busy, for less than a third
// of the bytes that 16 patches cost.
inline constexpr uint64_t kMostPatchesForSize = 4;

// Into how many patches primitives are cut: by `count`, otherwise by `faces`. If both are 0, a primitive of
// kMinFaces or more is cut into 2, 4, 8, 16 or a multiple of 16 patches of about 30,000 faces.
struct PatchTarget {
  uint64_t count = 0;        // of all primitives together
  uint64_t least_faces = 0;  // `count` is reduced until each patch has at least this many faces
  uint64_t faces = 0;        // per patch: a primitive of F faces gets round(F / faces) patches, at least 1
  uint64_t most = 0;         // of a primitive, if count and faces are 0; 0 means no bound
  // Smaller primitives stay whole. 0 means kMinFaces if count and faces are 0, and no bound otherwise.
  uint64_t min_faces = 0;
  bool always = false;  // store unsplit meshes as one patch as well, and never reduce patches to save bytes

  // Whether the caller asks for patches, instead of leaving the choice to each primitive's size.
  bool is_given() const { return count > 0 || faces > 0 || always; }
};

// 2, 4, 8, 16 or a multiple of 16 patches of about 30,000 faces, and one patch below `min_faces`. Threads then
// get equal work, for about 2 % more bytes than a single stream (docs/benchmarks.md).
PSPLIT_EXPORT uint64_t default_patch_count(uint64_t faces, uint64_t min_faces = kMinFaces);

// The number of patches of each primitive, given its number of faces.
PSPLIT_EXPORT std::vector<uint32_t> patch_counts(Span<const uint64_t> faces, const PatchTarget& target);

// How the faces are cut into patches. Attributes do not matter.
enum class PartitionMethod {
  kMultilevel,  // levels of cells; the coarsest graph is cut in halves, and borders are refined at each level
  kPaper,       // farthest-point samples, clusters of faces around them, k-means of the clusters
};

// How PartitionMethod::kPaper measures the distance between faces.
enum class PathDistance {
  kDijkstra,  // shortest paths along edges and over the centres of faces
  kGeodesic,  // fast marching, straight across faces
};

// ---- Options ----

// The form in which a mesh is stored.
enum class Storage : uint8_t {
  kAsFits,     // a container of patches; one Draco stream if the mesh is not split
  kContainer,  // a container, of one patch if the mesh is not split; see PatchTarget::always
  kStreams,    // each patch as a Draco stream of its own; several streams have the points on borders
  kOneStream,  // one Draco stream, which drops unused points and degenerate faces
  kInOrder,    // one sequential Draco stream, which keeps all faces and points, and their order
  // One Draco point cloud of a mesh without faces, which keeps all points. As in libdraco, it is a kD-tree,
  // with an order of its own, at speeds below 10 if all attributes are integers or on a grid; otherwise
  // sequential, in their order. In a tree the three components of normals are on a grid, and not on an
  // octahedron.
  kCloud,
};

// The order of patches in their container, in which decoders receive them while the container arrives.
struct PatchOrder {
  enum class By : uint8_t {
    kCut,   // as they were cut: neighbouring patches are close in the order
    kSize,  // by area, the largest first
    kNear,  // by the distance of their nearest point to `point`, the nearest first
  };
  By by = By::kCut;
  std::array<double, 3> point{};  // in the coordinates of POSITION
};

// Whether a container's streams are condensed, that is, coded with tables that all patches share, where this
// saves bytes.
enum class Condense : uint8_t {
  kNo,
  kFast,      // slower codings only where they save enough bytes
  kSmallest,  // the fewest bytes
};

// How many percent more bytes than one stream patches may take if the caller does not ask for patches.
inline constexpr uint32_t kMostSplitPercent = 3;

inline constexpr int kMostEncodeSpeed = 10;

// The defaults equal the command's (`gltf-psplit encode`). CodingOptions has the bits of attributes.
struct EncodeOptions : CodingOptions {
  PatchTarget patches{};
  Storage storage = Storage::kAsFits;
  // Each of these two replaces position_bits. Meshes that share a grid get the bits that suffice for all of
  // them.
  bool position_bits_by_edges = false;  // the fewest bits that the edges allow
  double max_position_error = 0;        // the fewest bits for an error of at most this, in the mesh's own units
  int encode_speed = 5;  // 0 (fewest bytes for most meshes) to 10 (fastest), libdraco's scale for its speeds
  // Each stream gets the fewest bytes that one of Draco's predictions gives it, in place of what encode_speed
  // chooses. All are tried for each attribute of each patch, so encoding takes longer. Decoding is slower as
  // well where the predictions of speed 0 win. Any Draco decoder reads the streams. Has no effect with
  // by_libdraco: libdraco cannot choose this way.
  bool choose_by_bytes = false;
  bool by_libdraco = false;  // libdraco encodes the streams, as a reference: the same bytes, in more time
  Condense condense = Condense::kNo;
  PatchOrder order{};
  // Store the box of each patch: 6 bytes each, and 28 per mesh. A viewer chooses by the boxes which patches it
  // shows first.
  bool boxes = false;
  bool keep_degenerate = false;  // keep faces that repeat an index, though they draw nothing
  bool keep_unused = false;      // keep points that no face uses; not with kStreams
  bool keep_duplicates = false;  // do not merge points that are equal in every attribute
  bool refine = true;            // false keeps the jagged borders of plain clustering
  PartitionMethod method = PartitionMethod::kMultilevel;
  PathDistance distance = PathDistance::kDijkstra;
  bool verify = true;  // decode the result, and compare it with the input

  // A copy with the bits that plan() begins with, and with `given` set accordingly.
  EncodeOptions with_first_bits() const;
  bool chooses_position_bits() const { return position_bits_by_edges || max_position_error > 0; }
  // Whether patches may take any number of bytes. Otherwise kMostSplitPercent limits them.
  bool asks_for_patches() const { return patches.is_given() || patches.min_faces > 0; }
};

// Values beside the attributes, such as morph targets: `width` bytes for each point.
struct PointData {
  Span<const std::byte> values;
  size_t width = 0;
};

// How one attribute is stored, in place of the options for all attributes of its kind.
struct OwnCoding {
  int bits = 0;                           // 1 to 30; 0: exactly
  std::optional<AttributeCoding> grid{};  // includes the bits
};

// ---- A mesh before and after encoding ----

// A mesh on its way through the encoder.
struct MeshToEncode {
  Mesh mesh;
  size_t group = 0;  // meshes of a group share a grid for positions, and one for weights
  // Points that differ in these are not merged. The caller keeps the values until the mesh is encoded.
  std::vector<PointData> distinct{};
  std::map<size_t, OwnCoding> own_codings{};  // by attribute
  // The factor by which textures scale coordinates (KHR_texture_transform), by attribute.
  std::map<std::string, double> texture_scales{};
  // The grid that the input states for each attribute, 0 bits if it states none; empty if it states no grid at
  // all. Attributes whose values are on the stated grid keep it, so that re-encoding an encoder's output
  // changes no value.
  std::vector<AttributeCoding> stated{};

  bool is_condensed_later = false;  // the caller will condense it, together with other streams
  bool needs_container = false;     // Storage::kAsFits stores it as a container even if it is not split

  // plan() sets all of these.
  std::vector<AttributeCoding> codings{};  // of each attribute; until encode() the caller may change them
  std::vector<PrecisionNote> notes{};      // how its precision was kept, and what the grid loses
  std::vector<Attribute> unrounded{};      // weights and morph targets before rounding
  uint32_t patch_count = 1;
};

// The caller's arrays as a mesh. Errors: kUsage, kUnsupported for an attribute that is named twice, too few
// bytes, and types that glTF does not allow for attributes or indices.
PSPLIT_EXPORT Expected<Mesh> mesh_of(const MeshView& view);

// A mesh that keeps its encoding, and the grid of its positions. The other meshes of its group get this grid if
// it holds their values.
struct KeptMesh {
  size_t group = 0;
  AttributeCoding positions{};
};

class StoredBytes;  // bytes that need not fit into memory

struct EncodeStatistics {
  uint32_t patch_count = 0;    // without the residue
  uint64_t merged_points = 0;  // duplicates that were merged
  uint64_t dropped_faces = 0;
  uint64_t dropped_points = 0;
  uint64_t residue_faces = 0;   // faces that repeat an index, which Edgebreaker cannot encode
  uint64_t residue_points = 0;  // points that are in no other stream
  // The largest distance between a position of the input and its decoded position. Empty if the mesh was not
  // verified.
  std::optional<double> position_error;
  double partition_ms = 0;
  double encode_ms = 0;  // everything except decoding and verifying the result
  double verify_ms = 0;
};

// A container of patches, or a Draco stream without a container.
struct EncodedPiece {
  bool is_container = true;
  std::vector<uint8_t> bytes;
  std::shared_ptr<StoredBytes> stored;  // in place of `bytes` if the mesh was encoded in parts
  std::vector<StreamEntry> entries;     // the directory's rows; a single stream's row has no stitch map
  uint32_t head_bytes = 0;  // of the container's head, with the tables of condensed streams and the boxes
  uint32_t point_count = 0, face_count = 0;
  uint32_t used_point_count = 0;  // without the points that no face uses, which come last
  // The decoded mesh, and the input point of each decoded point, by which the caller reorders morph targets and
  // other arrays per point. A mesh that was encoded in parts has `bounds` instead: of each attribute's decoded
  // values.
  Mesh decoded;
  std::vector<uint32_t> source_point;
  std::vector<ValueBounds> bounds;

  PSPLIT_EXPORT uint64_t size() const;  // in bytes
};

struct EncodedMesh {
  // Usually one. There are several if a mesh in parts exceeds a container, or if patches are streams of their
  // own. Each piece has all points that its faces use.
  std::vector<EncodedPiece> pieces;
  // In the order of the input's attributes: how a decoder is asked for each, and how it is stored.
  std::vector<AttributeRequest> requests;
  std::vector<AttributeCoding> codings;
  std::vector<PrecisionNote> notes;  // how its precision was kept, and what the grid loses
  EncodeStatistics statistics;       // of all pieces together

  bool is_in_container() const { return !pieces.empty() && pieces.front().is_container; }
};

// ---- Encoding ----

// Chooses how the attributes of all meshes are stored, and into how many patches each is cut. Grids whose bits
// are not given become finer where distinct values of a mesh would become equal. Values of quantized attributes
// that exceed glTF's limits by rounding noise are clamped, and weights are rounded to their grid so that they
// keep their sum. After an error, `failed`, unless it is null, gets the index of the mesh. Errors: kUsage for
// options that are out of range or contradict each other; kInvalidInput, kUnsupported for meshes that cannot be
// encoded; kUsage if no bits suffice for max_position_error.
PSPLIT_EXPORT Status plan(Span<MeshToEncode* const> meshes, const EncodeOptions& options,
                          const ThreadPool& pool, Span<const KeptMesh> kept = {}, size_t* failed = nullptr);

// Encodes a mesh that was planned with the same options: merges equal points, drops unused points and
// degenerate faces, cuts the mesh into mesh.patch_count patches or fewer (kMostSplitPercent), encodes, stitches
// and condenses them, and decodes the result to compare it with the input. Progress counts faces, patch by
// patch, and is called from any thread. The result is byte-identical for any number of threads. Errors:
// kCancelled; kUnsupported (for example if all faces are degenerate and to be dropped); kRuntimeFailure
// (verification failed, which is a bug). An error in a patch names it as its place.
PSPLIT_EXPORT Expected<EncodedMesh> encode(const MeshToEncode& mesh, const EncodeOptions& options,
                                           const ThreadPool& pool, const Watch& watch = {});
// As above, but frees the faces and values of the mesh as early as possible.
PSPLIT_EXPORT Expected<EncodedMesh> encode(MeshToEncode&& mesh, const EncodeOptions& options,
                                           const ThreadPool& pool, const Watch& watch = {});

// Plans and encodes one mesh.
PSPLIT_EXPORT Expected<EncodedMesh> encode(Mesh mesh, const EncodeOptions& options, const ThreadPool& pool,
                                           const Watch& watch = {});

// ---- libdraco, for comparison ----

// Decodes each stream with libdraco into a draco::Mesh, one thread for each patch. Stock streams may be of any
// bitstream that libdraco knows. Errors: kInvalidInput. Checks before each task whether to stop, and reports
// progress in tasks. Thread-safe.
PSPLIT_EXPORT DecodeBackend draco_backend();

// The decoder of bitstreams before 2.2, for loaders (loader.h, tinygltf.h). Null in a build without libdraco.
PSPLIT_EXPORT const OlderStreams* older_streams();

// The version of the libdraco that psplit was built with; empty if it was built without.
PSPLIT_EXPORT std::string draco_version();
inline bool has_draco() { return !draco_version().empty(); }

}  // namespace psplit
