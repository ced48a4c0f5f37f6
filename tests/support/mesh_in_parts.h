// A mesh in memory, cut into parts, for tests of what works part by part.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "encoder/mesh_parts.h"
#include "encoder/spill.h"
#include "psplit/mesh.h"

namespace psplit {

// Cuts a mesh without duplicate points, degenerate faces and unused points (`reduce`). `part_of_face` has a
// number for each face; numbers without faces make no part.
class MeshInParts : public MeshParts {
 public:
  MeshInParts(const Mesh& mesh, std::span<const uint32_t> part_of_face);

  uint32_t part_count() const override { return static_cast<uint32_t>(parts_.size()); }
  uint32_t shared_count() const override { return shared_count_; }
  Expected<MeshPart> read(uint32_t part) override { return parts_[part]; }

  // Tests change parts through this.
  std::vector<MeshPart>& parts() { return parts_; }
  // The faces of each part, as numbers of the mesh's faces.
  const std::vector<std::vector<uint32_t>>& faces() const { return faces_; }

 private:
  std::vector<MeshPart> parts_;
  std::vector<std::vector<uint32_t>> faces_;
  uint32_t shared_count_ = 0;
};

// All bytes.
std::vector<uint8_t> read_all(StoredBytes& bytes);

}  // namespace psplit
