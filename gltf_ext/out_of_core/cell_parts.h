// A large mesh as parts that fit into memory, which are in temporary files.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "encoder/mesh_parts.h"
#include "gltf_ext/out_of_core/cell_assignment.h"
#include "gltf_ext/out_of_core/file_blocks.h"
#include "gltf_ext/out_of_core/large_mesh.h"

namespace psplit {

// How many points and faces were merged or dropped, as reduce() (encoder/welding/reduce.h) counts them for the
// whole mesh.
struct CellStatistics {
  uint64_t points = 0;      // of the input
  uint64_t faces = 0;       // of the input
  uint64_t kept_faces = 0;  // of all parts
  uint64_t merged_points = 0, dropped_faces = 0, dropped_points = 0;
};

// Each cell with faces, or with points that are kept without, is a part. Equal points are merged by the cell
// that they belong to, before the faces of other cells get them.
class CellParts : public MeshParts {
 public:
  struct Options {
    std::filesystem::path folder;  // of the temporary files
    PartCost cost;
    uint64_t buffer_bytes = 0;  // memory for buffers
    // See EncodeDocumentOptions. Without them, equal points are merged, and parts get neither faces that repeat
    // a point then nor points that no face uses.
    bool keep_duplicates = false, keep_degenerate = false, keep_unused = false;
  };
  // Forgets `mesh` once its values are in temporary files. Errors: as for the files, kUnsupported if the mesh
  // cannot be divided so, or if all faces are degenerate.
  static Expected<std::unique_ptr<CellParts>> make(const LargeMesh& mesh, const Options& options,
                                                   const ThreadPool& pool);

  uint32_t part_count() const override { return static_cast<uint32_t>(places_.size()); }
  uint32_t shared_count() const override { return shared_count_; }
  Expected<MeshPart> read(uint32_t part) override;

  const CellStatistics& statistics() const { return statistics_; }
  // What choose_codings gives for the whole mesh of the points in parts.
  const std::vector<AttributeCoding>& codings() const { return codings_; }
  // What these codings lose although it is to be kept: sentences.
  const std::vector<std::string>& losses() const { return losses_; }

 private:
  class Builder;
  struct Place {
    uint64_t offset = 0;
    uint32_t face_count = 0, point_count = 0, shared_count = 0;
  };
  CellParts() = default;

  std::vector<Attribute> attributes_;
  std::vector<AttributeCoding> codings_;
  std::vector<std::string> losses_;
  AppendFile file_;
  std::vector<Place> places_;
  // For each point that cells asked each other for, its number among the points that several parts use.
  std::vector<uint32_t> shared_number_;
  uint32_t shared_count_ = 0;
  CellStatistics statistics_;
};

}  // namespace psplit
