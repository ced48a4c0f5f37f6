#include "decoder_cuda/psplit_cuda.h"

#include <gtest/gtest.h>

namespace psplit {
namespace {

TEST(Cuda, SaysWhyItIsNotAvailable) {
  std::string why = "untouched";
  const bool available = cuda_available(&why);
  EXPECT_EQ(why.empty(), available) << why;
  EXPECT_NE(why, "untouched");
  EXPECT_EQ(cuda_available(nullptr), available);
}

}  // namespace
}  // namespace psplit
