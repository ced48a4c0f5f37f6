// XXH3 of 128 bits: names for content, and whether it is still the same. Not for those who want two contents of
// one hash.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

struct XXH3_state_s;

namespace psplit {

class ContentHash {
 public:
  ContentHash();
  void add(std::span<const uint8_t> bytes);
  // The length before the bytes: what is added this way cannot run into what follows.
  void add_framed(std::span<const uint8_t> bytes);
  void add_framed(std::string_view text);
  // 32 hexadecimal digits, of all that was added so far.
  std::string hex() const;

 private:
  struct Free {
    void operator()(XXH3_state_s* state) const;
  };
  std::unique_ptr<XXH3_state_s, Free> state_;
};

}  // namespace psplit
