// Divides the faces of a mesh among the streams of its container.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "encoder/encode_mesh.h"
#include "encoder/partition/partition.h"
#include "encoder/stream/patch_mesh.h"
#include "encoder/welding/weld.h"
#include "psplit/parallel.h"

namespace psplit {

// Faces of the mesh by patch. Faces that repeat an index are in the residue, because Edgebreaker cannot encode
// them.
struct Cut {
  std::vector<std::vector<uint32_t>> patches;
  std::vector<uint32_t> residue_faces;
  // For each face of the mesh and side, from corner c to the next, the place in its patch of the face across,
  // or PatchMesh::kNoFace if it is in another patch. Empty if they are not known, or some edge has more than
  // two faces.
  std::vector<std::array<uint32_t, 3>> neighbours;
};

// Partitions the mesh, or takes the given patch of each of its faces if `patch_of_face` is not empty.
Cut cut_faces(const WeldedMesh& welded, const PartitionOptions& options,
              std::span<const uint32_t> patch_of_face, const ThreadPool& pool);

// Brings the patches into an order.
void order_patches(const Mesh& mesh, const PatchOrder& order, Cut& cut);

// Takes patches out of a mesh, which must outlive it. It takes a little more than four bytes for each point of
// the mesh. Not thread-safe.
class PatchExtractor {
 public:
  explicit PatchExtractor(const Mesh& mesh)
      : mesh_(mesh),
        number_(mesh.point_count),
        used_(words(mesh.point_count), 0),
        used_words_(words(used_.size()), 0) {}

  // Faces of the mesh with the points that they use, which ascend. `neighbours` has the neighbours of all faces
  // of the mesh (Cut), or is empty.
  PatchMesh extract(std::span<const uint32_t> faces, std::span<const std::array<uint32_t, 3>> neighbours);

 private:
  static size_t words(size_t bits) { return (bits + 63) / 64; }
  void take_used(std::vector<uint32_t>& points);

  const Mesh& mesh_;
  Array<uint32_t> number_;  // of the points in the patch; others have any
  // A bit for each point that the patch uses, and one for each word of these that is not 0. Both are 0 outside
  // of extract().
  std::vector<uint64_t> used_, used_words_;
};

// The residue's faces, the points that no face uses, and faces of padding: a sequential decoder needs at least
// as many corners as points.
struct Residue {
  PatchMesh patch;
  uint32_t face_count = 0;   // without padding
  uint32_t owned_count = 0;  // points that no other stream has
};

// Other streams have the points with is_in_patch[point] = 1. With `standalone`, these have their true values
// here, too.
Residue extract_residue(const Mesh& mesh, std::span<const uint32_t> residue_faces,
                        std::span<const uint8_t> is_in_patch, bool standalone);

}  // namespace psplit
