// "did you mean ...?" for misspelt words.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace psplit {

// The number of letters to insert, delete, replace or swap with their neighbour to turn one word into the
// other.
size_t edit_distance(std::string_view a, std::string_view b);

// The candidate nearest to `word`, or the first of several that are equally near. A candidate is near if
// `word`, of three letters at least, is its beginning, or if at most a third of the letters of `word` would
// change. Empty if no candidate is near.
std::string nearest_word(std::string_view word, std::span<const std::string> candidates);

// "; did you mean encode?"; empty if no candidate is near.
std::string suggestion(std::string_view word, std::span<const std::string> candidates);

}  // namespace psplit
