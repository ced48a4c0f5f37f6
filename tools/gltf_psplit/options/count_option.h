// Counts and sizes as people write them: 1000000, 1_000_000, 1e6, 1M, 250k; 512MB, 1.5GB.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace psplit {

// Reads digits, which may be separated by _ or ,; or a decimal number with an exponent or with one of k, M, G
// (1000, 1000000, ...). Nothing if the text is neither, is not a whole number, or exceeds 64 bits.
std::optional<uint64_t> parse_count(const std::string& text);

// Adds an option for such a count from 1 to 2^32 - 1. `count` must outlive the parse. If it is not 0, it is the
// default.
CLI::Option* add_count_option(CLI::App& command, const std::string& name, uint64_t& count,
                              const std::string& description);

// Reads a number of bytes: a decimal number without a sign, which k, M, G or T may follow, and then B or iB, in
// any case. Each of these letters stands for a power of 1024. Fractions of a byte are cut off. Nothing for
// other text, and for 2^63 bytes and more.
std::optional<uint64_t> parse_size(const std::string& text);

// Adds an option for a number of bytes, which parse_size reads. `bytes` must outlive the parse.
CLI::Option* add_size_option(CLI::App& command, const std::string& name, uint64_t& bytes,
                             const std::string& description);

}  // namespace psplit
