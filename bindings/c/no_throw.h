// For functions that other programs look up by name, and that have no error to give.
#pragma once

namespace psplit::c {

// The result of body(). No exception leaves it: then it is `failed`.
template <typename Value, typename Body>
Value without_exceptions(Value failed, Body body) noexcept {
  try {
    return body();
  } catch (...) {
    return failed;
  }
}

}  // namespace psplit::c
