// The threads of a call.
#pragma once

#include <pybind11/pybind11.h>

#include "psplit/parallel.h"

namespace psplit::python {

// All threads of the machine, started once. The pool is never destroyed: other static objects may go first.
inline const ThreadPool& shared_pool() {
  static const auto* const pool = new ThreadPool();
  return *pool;
}

// Calls use(pool) with a pool of that many threads; 0: all of the machine. ValueError for less.
template <typename Use>
auto with_pool(int thread_count, Use use) {
  if (thread_count < 0) throw pybind11::value_error("threads is negative");
  if (thread_count == 0) return use(shared_pool());
  return use(ThreadPool(thread_count));
}

}  // namespace psplit::python
