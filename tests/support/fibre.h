// Stackful coroutines: a call can stop in the middle, let another one continue, and be resumed later on the
// same thread. The sanitizers are told of every switch. The thread sanitizer treats fibres as unordered
// threads: a switch orders nothing.
#pragma once

#include <cstddef>

namespace psplit {

class Fibre {
 public:
  // A fibre for the current thread, with the thread's own stack.
  Fibre();
  // The first switch to the fibre calls body(argument), on a stack of its own with a guard page below. The body
  // must not return and must not throw. A fibre may be destroyed while it is stopped; then the objects on its
  // stack leak. `offset_bytes`, a multiple of 64, stays unused at the top of the stack: if all stacks began at
  // the same place of a page, they would compete for the same cache lines.
  Fibre(void (*body)(void*), void* argument, size_t stack_bytes, size_t offset_bytes);
  ~Fibre();
  Fibre(const Fibre&) = delete;
  Fibre& operator=(const Fibre&) = delete;

  // Stops `from`, the running fibre, and continues with this one. Returns when a fibre switches back to `from`.
  void switch_from(Fibre& from);

 private:
  struct State;
  static void enter();
  static void arrive(Fibre& fibre);
  State* state_;
};

}  // namespace psplit
