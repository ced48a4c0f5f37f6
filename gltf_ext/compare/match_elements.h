// Pairs the elements of two bags, each with one whose corners have the same values within their limits, in any
// order and from any corner on.
//
// That is a maximum matching in a bipartite graph, found exactly: where limits are wide, or elements stand
// twice, an element has several that it may be paired with, and whoever takes the first may leave none to
// another. Elements are looked up by the sums of their corners' values, which no turn changes, in a grid of
// cells that are wide beside the limits; whoever finds no partner that is free asks those that have one to take
// another.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "gltf_ext/compare/elements.h"
#include "src/status.h"

namespace psplit {

inline constexpr uint32_t kNoElement = 0xffffffffu;

// Quantization makes one position of one. Where the other bag is known to be what was quantized, or one of them
// is, whichever, two positions that were one are a crack.
enum class TearSearch { kNone, kInA, kInB, kInEither };

// Two triangles share a position in one bag, and not in the other, and neither has another partner.
struct Tear {
  bool in_b = true;                    // or else in `a`
  std::array<uint32_t, 2> elements{};  // of `a`
  std::array<int, 2> corners{};        // of each
};

struct ElementMatch {
  std::vector<uint32_t> partner;  // of each element of `a`, one of `b` or kNoElement
  std::vector<uint8_t> taken;     // of each element of `b`, whether it is a partner
  std::vector<double> largest;    // difference of each column over all pairs
  // Looked for where none but degenerate triangles are without a partner, in triangles.
  std::optional<Tear> tear;
};

// Time and memory grow with the number of elements, but for those of which very many lie within the limits of
// each other: some hundred comparisons for each element, and `spare_tests` more. Errors: kRuntimeFailure where
// these do not do.
Expected<ElementMatch> match_elements(const ElementPair& pair, TearSearch tears,
                                      uint64_t spare_tests = 20'000'000);

}  // namespace psplit
