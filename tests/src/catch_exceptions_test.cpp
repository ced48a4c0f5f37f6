// What a function returns in the place of an exception.
#include "src/catch_exceptions.h"

#include <gtest/gtest.h>

#include <string>

namespace psplit {
namespace {

template <typename Thrown>
Status thrown(const Thrown& exception) {
  return catch_exceptions([&]() -> Status { throw exception; });
}

TEST(CatchExceptions, LackOfMemoryHasACodeOfItsOwn) {
  EXPECT_EQ(thrown(std::bad_alloc()).code(), StatusCode::kOutOfMemory);
  EXPECT_EQ(thrown(std::bad_array_new_length()).code(), StatusCode::kOutOfMemory);
  EXPECT_EQ(thrown(std::length_error("vector")).code(), StatusCode::kRuntimeFailure);
  EXPECT_EQ(thrown(std::runtime_error("broken")).to_string(), "broken");
  EXPECT_EQ(thrown(std::runtime_error("broken")).code(), StatusCode::kRuntimeFailure);
  EXPECT_EQ(thrown(7).code(), StatusCode::kRuntimeFailure);
}

TEST(CatchExceptions, WhatIsReturnedStaysAsItIs) {
  EXPECT_TRUE(catch_exceptions([] { return Status(); }).ok());
  EXPECT_EQ(*catch_exceptions([]() -> Expected<std::string> { return std::string("text"); }), "text");
  EXPECT_EQ(catch_exceptions([]() -> Expected<int> { return unsupported("no"); }).status().code(),
            StatusCode::kUnsupported);
}

}  // namespace
}  // namespace psplit
