// The streams of a mesh, or of a part of one: cut, encoded and verified. Encoding a mesh in memory and encoding
// it part by part take these steps.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "encoder/cut_faces.h"
#include "encoder/encode_mesh.h"
#include "encoder/stitching/build_stitching.h"
#include "psplit/base.h"
#include "psplit/decode.h"
#include "psplit/parallel.h"

namespace psplit {

// Whether the streams of a mesh are stored without a container.
constexpr bool are_alone(Alone alone, size_t patch_count, bool has_residue) {
  return alone == Alone::kAll || (alone == Alone::kWhole && patch_count == 1 && !has_residue);
}

// Everything that goes into a container.
struct Streams {
  std::vector<OwnedStream> owned;
  std::vector<Mesh> decoded;  // of each stream; the attributes are left out unless the streams are alone
  std::vector<std::vector<uint8_t>> bytes;
  std::vector<size_t> table_bytes;   // of each stream but the residue: tables of probabilities among its bytes
  bool has_residue = false;          // the last stream
  uint32_t residue_face_count = 0;   // without padding
  uint32_t residue_point_count = 0;  // points that no other stream has
  double partition_ms = 0;           // what it took to cut the mesh

  uint32_t patch_count() const { return static_cast<uint32_t>(bytes.size()) - (has_residue ? 1 : 0); }
  bool are_alone(Alone alone) const { return psplit::are_alone(alone, patch_count(), has_residue); }
};

// Whether encode_mesh can encode the mesh with these codings. A mesh without faces passes. Errors:
// kInvalidInput, kUnsupported.
Status check_mesh(const Mesh& mesh, std::span<const AttributeCoding> codings);

// Welds the mesh, cuts it into `patch_count` patches or as options.patch_of_face says, and encodes these and
// the residue. Patches that exceed options.most_split_percent become fewer. Nothing is merged or dropped.
// Errors have the number of the patch as their place.
Expected<Streams> encode_streams(const Mesh& mesh, std::span<const AttributeCoding> codings,
                                 const StreamOptions& options, uint32_t patch_count, const ThreadPool& pool);

// Appends the residue of `mesh`: its faces `residue_faces`, and the points that no face uses. Other streams
// have the points with is_in_patch[point] = 1. With `standalone`, the stream holds their true values, and the
// decoded one its attributes. Nothing is appended if there are no such faces and points.
Status append_residue(const WeldedMesh& welded, std::span<const uint32_t> residue_faces,
                      std::span<const uint8_t> is_in_patch, std::span<const AttributeCoding> codings,
                      const StreamOptions& options, bool standalone, Streams& streams);

// A sequential stream. Its only prediction is the difference, so bytes have no choice.
Expected<std::vector<uint8_t>> encode_sequentially(const WeldedMesh& welded, const PatchMesh& patch,
                                                   std::span<const AttributeCoding> codings,
                                                   const StreamOptions& options);

// The rows of the directory. Errors: kUnsupported.
Expected<std::vector<StreamEntry>> make_entries(const Streams& streams, const Stitching& stitching);
// Makes the entries of streams without a container: a stream counts the points that were not known before it as
// its own, as in a container. `is_known` has 1 for such points of the mesh.
Expected<std::vector<StreamEntry>> make_lone_entries(const Streams& streams, std::vector<uint8_t> is_known);

// Compares decoded streams that are stored without a container with `mesh` (verify_mesh), and raises
// `position_error` to the largest distance of their positions.
Status verify_alone(const Mesh& mesh, std::span<const AttributeCoding> codings, const Streams& streams,
                    const ThreadPool& pool, std::optional<double>& position_error);

}  // namespace psplit
