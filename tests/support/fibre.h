// Stackful coroutines: calls that stop in the middle, while another goes on, and are resumed later on the same
// thread. The sanitizers know of every switch; to the thread sanitizer fibres are threads that run as they
// like, and a switch orders nothing.
#pragma once

#include <cstddef>

namespace psplit {

class Fibre {
 public:
  // Stands for whoever switches away from it: a thread with its own stack.
  Fibre();
  // Calls body(argument) at the first switch to it, on a stack of its own with a guard page below. The body
  // must not return, nor let exceptions out. Fibres may be destroyed while they are stopped; what their frames
  // own leaks then. `offset_bytes`, a multiple of 64, is left unused at the top of the stack: stacks that all
  // begin at the same place of a page fight for the same lines of the cache.
  Fibre(void (*body)(void*), void* argument, size_t stack_bytes, size_t offset_bytes);
  ~Fibre();
  Fibre(const Fibre&) = delete;
  Fibre& operator=(const Fibre&) = delete;

  // Stops `from`, which is the caller's, and goes on with this one. Returns when somebody switches back.
  void switch_from(Fibre& from);

 private:
  struct State;
  static void enter();
  static void arrive(Fibre& fibre);
  State* state_;
};

}  // namespace psplit
