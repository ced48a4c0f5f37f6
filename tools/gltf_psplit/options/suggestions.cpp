#include "tools/gltf_psplit/options/suggestions.h"

#include <algorithm>
#include <vector>

namespace psplit {

// Optimal string alignment, row by row: https://en.wikipedia.org/wiki/Damerau-Levenshtein_distance
size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<size_t> two_above, above(b.size() + 1), row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) above[j] = j;
  for (size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t replaced = above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, replaced});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], two_above[j - 2] + 1);
    }
    two_above = above;
    std::swap(above, row);
  }
  return above[b.size()];
}

std::string nearest_word(std::string_view word, std::span<const std::string> candidates) {
  // The beginning of a word means that word, no matter how much is missing.
  constexpr size_t kLeastStart = 3;
  std::string nearest;
  size_t least = word.size() / 3 + 1;
  for (const std::string& candidate : candidates) {
    const bool is_start = word.size() >= kLeastStart && candidate.starts_with(word);
    const size_t distance = is_start ? 1 : edit_distance(word, candidate);
    if (distance >= least) continue;
    least = distance;
    nearest = candidate;
  }
  return nearest;
}

std::string suggestion(std::string_view word, std::span<const std::string> candidates) {
  const std::string nearest = nearest_word(word, candidates);
  return nearest.empty() ? "" : "; did you mean " + nearest + "?";
}

}  // namespace psplit
