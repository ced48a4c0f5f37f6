// A 128-bit hash (XXH3) that names content and shows whether it changed. It does not resist an attacker who
// wants two contents with one hash.
#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

struct XXH3_state_s;

namespace psplit {

// The content hash as a number, for tables. The bytes of the text are hashed unchanged.
struct Hash128 {
  uint64_t high = 0, low = 0;
  auto operator<=>(const Hash128&) const = default;
};
Hash128 hash_of(std::string_view text);

class ContentHash {
 public:
  ContentHash();
  void add(std::span<const uint8_t> bytes);
  // Adds the length before the bytes, so that two different sequences of parts cannot add the same bytes.
  void add_framed(std::span<const uint8_t> bytes);
  void add_framed(std::string_view text);
  // 32 hexadecimal digits of everything added so far.
  std::string hex() const;

 private:
  struct Free {
    void operator()(XXH3_state_s* state) const;
  };
  std::unique_ptr<XXH3_state_s, Free> state_;
};

}  // namespace psplit
