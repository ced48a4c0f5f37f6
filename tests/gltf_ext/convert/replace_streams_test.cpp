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

// Appends a view of bytes that the buffer has.
int64_t add_view(Document& document, uint64_t offset, uint64_t bytes) {
  Json& views = document.json()["bufferViews"];
  views.push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes}});
  return static_cast<int64_t>(views.size()) - 1;
}

TEST(ReplaceStreams, OnlyBytesOfOneViewCanBeReplaced) {
  Document document = new_document();
  append_buffer(document, std::vector<uint8_t>(100, 1));
  append_buffer(document, std::vector<uint8_t>(100, 1));
  const int64_t alone = add_view(document, 0, 20), first = add_view(document, 20, 20),
                second = add_view(document, 36, 20), outer = add_view(document, 56, 40),
                inner = add_view(document, 60, 4), elsewhere = add_view(document, 16, 8);
  document.json()["bufferViews"][static_cast<size_t>(elsewhere)]["buffer"] = 1;
  const std::set<int64_t> replaceable = replaceable_views(document);
  EXPECT_EQ(replaceable, (std::set<int64_t>{alone, elsewhere}));
  for (const int64_t view : {first, second, outer, inner}) EXPECT_FALSE(replaceable.contains(view));
}

// Whatever is between streams, the file loses no less than bytes_saved says, and no buffer grows.
TEST(ReplaceStreams, SmallerStreamsSaveWhatIsSaid) {
  const auto rounded = [](size_t bytes) { return (bytes + 7) / 8 * 8; };
  for (uint32_t seed = 1; seed <= 500; ++seed) {
    uint32_t state = seed;
    const auto random = [&](uint32_t below) { return (state = state * 1664525 + 1013904223) / 65536 % below; };
    Document document = new_document();
    append_buffer(document, std::vector<uint8_t>(4000, 1));
    StreamReplacements replacements;
    const std::vector<uint8_t> bytes(200, 2);
    uint64_t at = 0;
    for (int i = 0; i < 12; ++i) {
      const bool is_stream = random(2) == 0;
      const uint64_t alignment = is_stream ? 4 : uint64_t{1} << random(4), size = 1 + random(200);
      at = (at + (random(4) == 0 ? random(40) : 0) + alignment - 1) / alignment * alignment;
      const int64_t view = add_view(document, at, size);
      if (is_stream) document.json()["bufferViews"].back()["target"] = 34962;
      if (is_stream) replacements[view] = std::span(bytes).first(1 + random(static_cast<uint32_t>(size)));
      at += size;
    }
    Document without = document;
    for (auto& [view, replacement] : replacements) {
      const auto old = must(buffer_view_bytes(document, view));
      replace_streams(without, {{view, old}});  // drops the bytes after the last view
    }
    const uint64_t saved = bytes_saved(document, replacements);
    replace_streams(document, replacements);
    EXPECT_LE(document.buffers[0].size(), without.buffers[0].size()) << seed;
    EXPECT_GE(rounded(without.buffers[0].size()) - rounded(document.buffers[0].size()), saved) << seed;
  }
}

}  // namespace
}  // namespace psplit
