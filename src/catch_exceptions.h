// For the borders that no exception may cross.
#pragma once

#include <exception>
#include <new>
#include <stdexcept>

#include "psplit/base.h"

namespace psplit {

// What `body` returns, a Status or an Expected; or the error that it threw. Takes no memory for kOutOfMemory.
template <typename Body>
auto catch_exceptions(Body&& body) -> decltype(body()) {
#ifdef __cpp_exceptions
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return out_of_memory("out of memory");
  } catch (const std::length_error&) {
    return runtime_failure("more than memory can hold");
  } catch (const std::exception& error) {
    return runtime_failure(error.what());
  } catch (...) {
    return runtime_failure("an unknown exception");
  }
#else
  return body();
#endif
}

}  // namespace psplit
