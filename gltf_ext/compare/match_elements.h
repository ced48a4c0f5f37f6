// Pairs the elements of two bags. Partners have the same values at their corners, within the limits, in any
// order and beginning at any corner.
//
// This is an exact maximum matching in a bipartite graph. If limits are wide, or elements occur twice, an
// element fits several others, and a greedy choice could leave another element without a partner. Elements are
// looked up by the sums of their corners' values, which no turn changes, in a grid whose cells are wide
// compared with the limits. An element that finds no free partner makes matched elements take another one
// (augmenting paths).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "gltf_ext/compare/elements.h"
#include "src/status.h"

namespace psplit {

inline constexpr uint32_t kNoElement = 0xffffffffu;

// Quantization never makes two positions of one. So if one bag is known to be a quantized form of the other,
// two positions in it that are one in the other are a crack. kInEither: one of them is quantized, but which is
// unknown.
enum class TearSearch { kNone, kInA, kInB, kInEither };

// Two triangles share a position in one bag but not in the other, and neither fits another partner.
struct Tear {
  bool in_b = true;                    // the crack is in `b`, otherwise in `a`
  std::array<uint32_t, 2> elements{};  // of `a`
  std::array<int, 2> corners{};        // of each
};

struct ElementMatch {
  std::vector<uint32_t> partner;  // for each element of `a`, an element of `b` or kNoElement
  std::vector<uint8_t> taken;     // for each element of `b`, whether it is a partner
  std::vector<double> largest;    // difference in each column over all pairs
  // Searched among triangles, if all of them except degenerate ones have a partner.
  std::optional<Tear> tear;
};

// Time and memory are proportional to the number of elements, unless very many elements are within the limits
// of each other. The search takes at most some hundred comparisons for each element plus `spare_tests`. Errors:
// kRuntimeFailure if that is not enough.
Expected<ElementMatch> match_elements(const ElementPair& pair, TearSearch tears,
                                      uint64_t spare_tests = 20'000'000);

}  // namespace psplit
