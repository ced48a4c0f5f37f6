// The codings of one mesh whose grids are its own, by the stages of the encoder alone.
#pragma once

#include <utility>
#include <vector>

#include "encoder/coding/choose_codings.h"
#include "encoder/coding/precision_guard.h"
#include "psplit/mesh.h"

namespace psplit {

// Guards the codings of a mesh in memory; all of its points count.
inline std::vector<PrecisionNote> guard_codings(const Mesh& mesh, const CodingOptions& options,
                                                std::vector<AttributeCoding>& codings) {
  std::vector<int> wanted;
  for (const Attribute& attribute : mesh.attributes) wanted.push_back(wanted_bits(attribute, options));
  const GuardedMesh whole{[&](const GuardedMesh::VisitPart& visit) {
    visit(mesh, {});
    return Status();
  }};
  auto notes = guard_codings(whole, mesh.attributes, options, wanted, ThreadPool(1), codings);
  return notes ? std::move(*notes) : std::vector<PrecisionNote>();
}

// A grid for each attribute, fitted to all points of the mesh, also to points that encoding drops. Values that
// exceed glTF's limits by rounding noise are set to the limits first.
inline std::vector<AttributeCoding> choose_codings(Mesh& mesh, const CodingOptions& options) {
  std::vector<AttributeCoding> codings;
  for (Attribute& attribute : mesh.attributes) codings.push_back(choose_coding(attribute, options));
  guard_codings(mesh, options, codings);
  return codings;
}

}  // namespace psplit
