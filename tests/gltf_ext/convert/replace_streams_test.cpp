// Streams whose bytes are replaced in their buffers.
#include "gltf_ext/convert/replace_streams.h"

#include "src/stopwatch.h"
#include "tests/gltf_ext/asset.h"

namespace psplit {
namespace {

// The time must not grow with the product of buffers and views: then these would take minutes.
TEST(ReplaceStreams, InManyBuffers) {
  constexpr size_t kBuffers = 4000;
  Document document = new_document();
  const std::vector<uint8_t> before(8, 1), after(12, 2);
  for (size_t i = 0; i < kBuffers; ++i) {
    append_buffer(document, std::vector<uint8_t>(before));
    document.json()["bufferViews"].push_back({{"buffer", i}, {"byteLength", before.size()}});
  }
  StreamReplacements replacements;
  for (size_t i = 0; i < kBuffers; i += 2) replacements[static_cast<int64_t>(i)] = after;
  const Stopwatch watch;
  replace_streams(document, replacements);
  EXPECT_LT(watch.ms(), 5000);
  for (size_t i = 0; i < kBuffers; ++i) {
    const std::vector<uint8_t>& expected = i % 2 == 0 ? after : before;
    const auto bytes = must(buffer_view_bytes(document, static_cast<int64_t>(i)));
    ASSERT_TRUE(std::ranges::equal(bytes, expected)) << i;
    ASSERT_EQ(document.buffers[i].size(), expected.size());
  }
}

}  // namespace
}  // namespace psplit
