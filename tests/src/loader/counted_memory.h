// How much memory a test has at most while it looks.
#pragma once

#include <cstddef>

namespace psplit {

// From its construction on, of all threads; one at a time.
class CountedMemory {
 public:
  CountedMemory();
  // More than there was at the start.
  size_t most() const;

 private:
  size_t start_ = 0;
};

}  // namespace psplit
