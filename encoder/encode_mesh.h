// Encodes one mesh as one patch container: welds and partitions it, encodes every patch, builds the stitch map,
// and decodes the result to check it.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "encoder/coding/attribute_coding.h"
#include "encoder/partition/partition.h"
#include "src/container/decode_backend.h"
#include "src/container/stream_entry.h"
#include "src/export.h"
#include "src/mesh/mesh.h"
#include "src/parallel.h"
#include "src/span.h"
#include "src/status.h"

namespace psplit {

// Which meshes become Draco streams without a container around them, which are never condensed. kWhole: those
// of one stream. kAll: all. Without a stitch map, points at borders are in several streams, and a point that
// Edgebreaker splits stays several.
enum class Alone { kNone, kWhole, kAll };

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

struct EncodeOptions {
  uint32_t patch_count = 1;
  // If not 0, patches that take more bytes than one stream, by more than so many percent, become fewer, or one.
  // Not with patch_of_face, nor with encode_parts.
  uint32_t most_split_percent = 0;
  // The container is to be condensed: its patches will share their tables, so that these do not count.
  bool shares_tables = false;
  PatchOrder order{};
  // Store the box of each patch: 6 bytes each, and 28 of a mesh. A viewer chooses by them what it shows first.
  bool boxes = false;
  int encode_speed = 5;  // 0 (fewest bytes for most meshes) to 10 (fastest), libdraco's scale for its speeds
  bool by_libdraco = false;  // libdraco encodes the patches, for reference: to the same bytes, in more time
  // Each stream gets the fewest bytes that one of Draco's predictions gives it, in place of what encode_speed
  // chooses: they are tried for each attribute of each patch. Encoding takes longer. Decoding should, too,
  // where predictions are those of speed 0. Any Draco decoder reads the streams. libdraco cannot choose so: no
  // effect with by_libdraco.
  bool choose_by_bytes = false;
  // With choose_by_bytes: POSITION has a prediction that condensed streams code in order of creation.
  // Condensed, some meshes then take fewer bytes, although their Draco streams take more. encode_mesh tries
  // both with condense_smallest.
  bool in_creation_order = false;
  bool keep_duplicates = false;  // keep points apart that are equal in everything
  bool drop_degenerate = false;  // drop faces that repeat an index; they draw nothing
  bool drop_unused = false;      // drop points that no face uses
  // Condense the streams of a container if that saves bytes: code them with tables that all patches share. Each
  // condensed stream is expanded again and compared with what it was.
  bool condense = false;
  // Condensed streams, now or by condense_container later, may decode more slowly if they are smaller.
  bool condense_smallest = false;
  Alone alone = Alone::kNone;
  bool verify = true;  // compare what was decoded with the input before returning
  bool refine = true;  // see PartitionOptions for this and the next two
  PartitionMethod method = PartitionMethod::kMultilevel;
  PathDistance distance = PathDistance::kDijkstra;
  // The patch of each face that is not dropped. If empty, encode_mesh partitions the mesh itself.
  Span<const uint32_t> patch_of_face{};
  // Called with the number of faces of each encoded patch, from any thread. Does not change the result.
  std::function<void(size_t)> patch_encoded{};
  // May free the faces and the values of the input, and nothing else of it. encode_mesh calls it at most once,
  // when it has a copy of what it needs of them: not if nothing is merged or dropped, or if it fails before.
  // encode_parts does not call it.
  std::function<void()> free_input{};
};

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
  double encode_ms = 0;  // all of encode_mesh except decoding and verifying the whole
  double verify_ms = 0;
};

// A stream without a container around it.
struct LoneStream {
  std::vector<uint8_t> bytes;
  Mesh decoded;
  std::vector<uint32_t> source_point;  // as in EncodedMesh
};

struct EncodedMesh {
  std::vector<uint8_t> container;  // empty if the streams are alone
  // How to request each attribute of the input from a decoder, in the input's order.
  std::vector<AttributeRequest> requests;
  // For each point of the decoded mesh, the input point that it came from. Morph targets and other arrays per
  // point are reordered accordingly.
  std::vector<uint32_t> source_point;
  Mesh decoded;                          // the decoded container
  std::vector<LoneStream> lone_streams;  // instead of the container: see EncodeOptions::alone
  std::vector<StreamEntry> entries;      // the directory's rows; those of lone streams have no stitch map
  uint32_t head_bytes = 0;               // of the container's head: what condensed streams share
  EncodeStatistics statistics;
};

// `codings` has one entry per attribute of the mesh (choose_codings). `extra_point_data`, if not empty, holds
// point_count * extra_stride bytes. Points that differ in these are not duplicates (morph targets). The result
// is byte-identical for any number of threads. Errors: kUsage (a partition with another number of faces),
// kInvalidInput (indices out of range, no POSITION, values that a quantization grid cannot hold), kUnsupported
// (among others, only degenerate faces that are to be dropped), kRuntimeFailure (verification failed, which is
// a bug).
PSPLIT_EXPORT Expected<EncodedMesh> encode_mesh(const Mesh& mesh, Span<const AttributeCoding> codings,
                                                const EncodeOptions& options, const ThreadPool& pool,
                                                Span<const std::byte> extra_point_data = {},
                                                size_t extra_stride = 0);

}  // namespace psplit
