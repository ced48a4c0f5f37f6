// "did you mean": the word that a user had in mind.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace psplit {

// Letters to insert, delete, replace or swap with their neighbour to make one word of the other.
size_t edit_distance(std::string_view a, std::string_view b);

// The candidate nearest to `word`, the first of several; empty where none is near: more than a third of the
// word, and more than its missing end, would have to change.
std::string nearest_word(std::string_view word, std::span<const std::string> candidates);

// "; did you mean encode?", or nothing.
std::string suggestion(std::string_view word, std::span<const std::string> candidates);

}  // namespace psplit
