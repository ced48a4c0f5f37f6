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
#include <optional>
#include <string>
#include <vector>

#include "encoder/coding/attribute_coding.h"
#include "encoder/coding/coding_options.h"
#include "encoder/encoded_mesh.h"
#include "encoder/partition/partition.h"
#include "encoder/patch_counts.h"
#include "src/container/decode_backend.h"
#include "src/export.h"
#include "src/mesh/mesh.h"
#include "src/mesh/mesh_view.h"
#include "src/parallel.h"
#include "src/span.h"
#include "src/status.h"

namespace psplit {

// What becomes of a mesh.
enum class Storage : uint8_t {
  kAsFits,     // a container of patches; one Draco stream if the mesh is not split
  kContainer,  // a container, of one patch if the mesh is not split; see also PatchTarget::always
  kStreams,    // each patch as a Draco stream of its own. Points at borders are in several
  kOneStream,  // one Draco stream, which drops unused points and degenerate faces
  kInOrder,    // one sequential Draco stream, which keeps all faces and points, and their order
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
  // One of these replaces position_bits. Meshes that share a grid share the
  // bits that suffice for all of them.
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
  bool refine = true;            // see PartitionOptions for this and the next two
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

  // plan() sets all of these.
  std::vector<AttributeCoding> codings{};  // of each attribute; until encode() the caller may change them
  std::vector<PrecisionNote> notes{};      // what was done for its precision, and what it loses
  std::vector<Attribute> unrounded{};      // the weights as they were
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

// Chooses how the attributes of all meshes are stored, and into how many patches each is cut. Grids whose bits
// are not given are finer where they would lose what a mesh tells apart. Values of
// quantized attributes that exceed glTF's limits by rounding noise are set to the limits, and weights are
// rounded to their grid so that they keep their sum. `failed`, if it is not null, gets the number of the mesh
// of an error. Errors: kUsage for options that are out of their range, or contradict each other; kInvalidInput,
// kUnsupported for meshes that cannot be encoded; kUsage if no bits suffice for max_position_error.
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

// For each point of a planned mesh 1 if encode() stores its values, otherwise 0.
std::vector<uint8_t> stored_points(const MeshToEncode& mesh, const EncodeOptions& options);

}  // namespace psplit
