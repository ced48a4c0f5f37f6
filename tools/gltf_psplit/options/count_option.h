// Counts as people write them: 1000000, 1_000_000, 1e6, 1M, 250k.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace psplit {

// Digits with _ or , between them for readers, or a decimal number with an exponent or one of k, M, G (1000,
// 1000000, ...). Nothing where the text is none of these, no whole number, or more than 64 bits hold.
std::optional<uint64_t> parse_count(const std::string& text);

// An option that takes such a count of at least 1 and at most 2^32 - 1; the argument outlives the parse, and
// is the default where it is not 0.
CLI::Option* add_count_option(CLI::App& command, const std::string& name, uint64_t& count,
                              const std::string& description);

}  // namespace psplit
