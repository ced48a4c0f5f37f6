// Encodes one mesh whose codings are chosen: welds and partitions it, encodes every patch, builds the stitch
// map, and decodes the result to check it. The door (encode.h) calls it.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

#include "encoder/partition/partition.h"
#include "encoder/welding/reduce.h"
#include "psplit/base.h"
#include "psplit/encode.h"
#include "psplit/mesh.h"
#include "psplit/parallel.h"
#include "src/container/patch_container.h"

namespace psplit {

// Which meshes become Draco streams without a container around them, which are never condensed. kWhole: meshes
// of one stream. kAll: all. Without a stitch map, points at borders are in several streams, and a point that
// Edgebreaker splits stays several.
enum class Alone { kNone, kWhole, kAll };

// What the door's options say about one mesh whose codings are chosen.
struct StreamOptions {
  uint32_t patch_count = 1;
  // If not 0: where patches take more bytes than one stream, by more than this percentage, there are fewer of
  // them, or one. Has no effect with patch_of_face and encode_parts.
  uint32_t most_split_percent = 0;
  // The container is to be condensed: its patches will share their tables, so that these do not count.
  bool shares_tables = false;
  PatchOrder order{};
  bool boxes = false;
  int encode_speed = 5;
  bool by_libdraco = false;
  bool choose_by_bytes = false;
  // Only used with choose_by_bytes: POSITION and morph targets get predictions that condensed streams code in
  // order of creation.
  // Condensed, some meshes then take fewer bytes, although their Draco streams take more. encode_mesh tries
  // both ways with condense_smallest.
  bool in_creation_order = false;
  bool keep_duplicates = false;  // keep points apart that are equal in everything
  bool drop_degenerate = false;  // drop faces that repeat an index; they draw nothing
  bool drop_unused = false;      // drop points that no face uses
  // One sequential stream, which keeps all faces and points, and their order, in place of all else here.
  bool in_order = false;
  bool differ_in_positions = false;  // no two points have the same position
  bool is_cloud = false;             // one point cloud of a mesh without faces, in place of all else here
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
  const std::atomic<bool>* stop = nullptr;  // encoding ends when it becomes true; may be null

  bool stopped() const { return stop != nullptr && stop->load(std::memory_order_relaxed); }
  // May free the faces and the values of the input, and nothing else of it. encode_mesh calls it at most once,
  // when it has a copy of what it needs of them: not if nothing is merged or dropped, or if it fails before.
  // encode_parts does not call it.
  std::function<void()> free_input{};
};

// What the options say about the streams of a mesh.
StreamOptions stream_options(const EncodeOptions& options, uint32_t patch_count);

// `codings` has one entry per attribute of the mesh (choose_codings). `extra_point_data`, if not empty, holds
// point_count * extra_stride bytes. Points that differ in these are not duplicates (morph targets). The result
// is byte-identical for any number of threads. Errors: kUsage (a partition with another number of faces),
// kInvalidInput (indices out of range, no POSITION, values that a quantization grid cannot hold), kUnsupported
// (among others, only degenerate faces that are to be dropped), kRuntimeFailure (verification failed, which is
// a bug).
Expected<EncodedMesh> encode_mesh(const Mesh& mesh, Span<const AttributeCoding> codings,
                                  const StreamOptions& options, const ThreadPool& pool,
                                  Span<const std::byte> extra_point_data = {}, size_t extra_stride = 0);

// The part of a planned mesh that encode() stores.
ReducedMesh reduce(const MeshToEncode& mesh, const EncodeOptions& options, const ThreadPool& pool);

// The patches of a piece in memory, or its lone stream as the only one. The bytes must outlive the result.
// Errors: as for open_container; the refusal of a stream that has no fields to condense.
Expected<PatchContainer> open_piece(const EncodedPiece& piece);

}  // namespace psplit
