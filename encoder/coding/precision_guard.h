// Finds grids that make equal what a mesh tells apart, and grids that do not.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "encoder/coding/choose_codings.h"
#include "psplit/base.h"
#include "psplit/encode.h"
#include "psplit/mesh.h"
#include "psplit/parallel.h"

namespace psplit {

// A grid is too coarse if more than these shares are lost: faces that lose their area; positions that coincide
// with another; edges whose ends get equal texture coordinates; texture coordinates that move by more than
// kTextureError. Real meshes have some of each (docs/decisions.md).
inline constexpr double kMostFlatFaces = 0.03, kMostCoinciding = 0.125, kMostEqualEnds = 0.05,
                        kMostMoved = 0.01;
// A share of a texture.
inline constexpr double kTextureError = 1.0 / 512;

// A mesh whose precision is guarded, as one or several parts.
struct GuardedMesh {
  using VisitPart = std::function<void(const Mesh& part, Span<const uint8_t> stored)>;
  // Calls the function with each part, and with a flag for each of its points: 1 if its values are stored.
  // Without flags all points count. Called a few times more if an attribute needs a finer grid.
  std::function<Status(const VisitPart&)> for_each_part;
  // For each attribute, by how much textures enlarge its values (KHR_texture_transform). 1 if it is missing.
  std::vector<double> texture_scales{};
};

// What the guard found about one attribute.
struct PrecisionFinding {
  bool is_loss = false;    // the coding makes distinct values equal, or the attribute has no grid
  AttributeCoding better;  // one that does not, with few bits; 0 bits: only exact values do
  std::string subject;     // the loss ("3 of 9 faces")
  std::string predicate;   // and how ("have no area"); empty if the attribute has no grid
  uint64_t values = 0;     // the number of floats
};

// For each attribute of the mesh: positions may not collapse to fewer points, nor faces lose their area;
// texture coordinates of a face may not become equal, nor move by more than kTextureError; in all other
// attributes, outliers and large components must leave bits to small ones. `wanted` has the requested bits of
// each attribute (wanted_bits). Errors: as for_each_part.
Expected<std::vector<PrecisionFinding>> find_losses(const GuardedMesh& mesh,
                                                    Span<const AttributeCoding> codings, Span<const int> wanted,
                                                    const ThreadPool& pool);

// The sentence about a finding: what a grid of `bits` would lose, how the attribute is stored, and what that
// costs. With `is_given`, the attribute stays on the grid of `bits`. `values` counts the floats of all meshes
// that share the grid.
PrecisionNote note_of(const std::string& semantic, const PrecisionFinding& finding, int bits,
                      const AttributeCoding& used, bool is_given, uint64_t values);

// Replaces the codings of the mesh, which has these attributes, by better ones, unless their bits are given.
// Returns notes about the changes, and about the losses of the other codings. Errors: as find_losses.
Expected<std::vector<PrecisionNote>> guard_codings(const GuardedMesh& mesh, Span<const Attribute> attributes,
                                                   const CodingOptions& options, Span<const int> wanted,
                                                   const ThreadPool& pool,
                                                   std::vector<AttributeCoding>& codings);

}  // namespace psplit
