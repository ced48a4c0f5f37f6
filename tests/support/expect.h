// What tests expect of results and of texts.
#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <stdexcept>
#include <string>

#include "psplit/base.h"

namespace psplit {

// What must succeed for a test to go on. If it does not, the test ends there, and says why.
inline void must(const Status& status, const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  if (status.ok()) return;
  // The exception alone would not have the test's SCOPED_TRACE.
  ADD_FAILURE_AT(file, line) << status.to_string();
  throw std::runtime_error("the test cannot go on");
}

template <typename T>
T must(Expected<T> result, const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  must(result.status(), file, line);
  return std::move(*result);
}

template <typename T>
T must(std::optional<T> result, const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  must(result ? Status() : runtime_failure("nothing was returned"), file, line);
  return std::move(*result);
}

// EXPECT_TRUE(contains(...)) and EXPECT_FALSE(contains(...)) show the text if they fail.
inline testing::AssertionResult contains(const std::string& text, const std::string& part) {
  return testing::AssertionResult(text.find(part) != std::string::npos)
         << '"' << part << "\" and the text: " << text;
}

}  // namespace psplit
