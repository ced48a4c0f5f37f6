// Measures the peak of a test's memory.
#pragma once

#include <cstddef>

namespace psplit {

// Counts the memory of all threads since its construction. Only one may exist at a time.
class CountedMemory {
 public:
  CountedMemory();
  // The peak, above the memory at construction.
  size_t most() const;

 private:
  size_t start_ = 0;
};

}  // namespace psplit
