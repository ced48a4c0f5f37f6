// Pairs the elements of two bags. Partners have the same values at their corners, within the limits, in any
// order and beginning at any corner.
//
// This is an exact maximum matching in a bipartite graph. If limits are wide, or elements occur twice, an
// element fits several others, and a greedy choice could leave another element without a partner. Elements are
// looked up by the sums of their corners' values, which no turn changes, in a grid whose cells are wide
// compared with the limits. An element that finds no free partner makes matched elements take another one
// (augmenting paths).
//
// Bags that are larger than memory are matched window by window, along the axis on which they are widest. The
// elements near the end of a window stay for the next one, with their partners, so that the result is that of
// one window.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "psplit/base.h"
#include "tools/gltf_psplit/diff/elements.h"

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
  std::vector<bool> has_partner[2];  // for each element of `a` and of `b`
  std::vector<double> largest;       // difference in each column over all pairs
  // Searched among triangles, if all of them except degenerate ones have a partner.
  std::optional<Tear> tear;
};

struct MatchLimits {
  uint64_t spare_tests = 20'000'000;
  uint64_t window = UINT64_MAX;  // elements of both bags together, each of about kMatchedElement bytes
};

// Time is proportional to the number of elements, unless very many elements are within the limits of each
// other. The search takes at most some hundred comparisons for each element plus `spare_tests`. Errors:
// kRuntimeFailure if that is not enough; kUnsupported if more than a window of elements is near one place.
Expected<ElementMatch> match_elements(const ElementPair& pair, TearSearch tears,
                                      const MatchLimits& limits = {});

}  // namespace psplit
