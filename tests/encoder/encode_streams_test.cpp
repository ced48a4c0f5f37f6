#include "encoder/encode_streams.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <vector>

#include "encoder/stitching/build_stitching.h"
#include "psplit/encode.h"
#include "tests/support/default_codings.h"
#include "tests/support/expect.h"
#include "tools/gltf_psplit/shapes/shapes.h"

namespace psplit {
namespace {

// The mesh is encoded a second time, as one stream, only where its patches may cost more than the limit. Here
// the bound that looks at the number of points on borders exceeds it, and the stitch maps show that they are
// smaller.
TEST(EncodeStreams, PatchesOfALargeMeshAreNotComparedWithOneStreamTakesLong) {
  const ThreadPool pool(2);
  const Mesh mesh = must(generate_shape({.shape = Shape::kGyroid, .faces = 4'000'000}, pool))[0];
  const Coded coded = default_codings(mesh, false);
  std::atomic<uint64_t> encoded = 0;
  std::atomic<bool> stop = false;
  const uint64_t faces = mesh.faces.size();
  const auto patches = static_cast<uint32_t>(default_patch_count(faces));
  StreamOptions options{.most_split_percent = kMostSplitPercent, .stop = &stop};
  // What would be encoded after the patches fails.
  options.patch_encoded = [&](uint64_t count) {
    if (encoded.fetch_add(count) + count == faces) stop = true;
  };
  const Expected<Streams> streams = encode_streams(mesh, coded.codings, options, patches, pool);
  ASSERT_TRUE(streams) << streams.status().to_string();
  EXPECT_TRUE(stop);
  EXPECT_GE(streams->patch_count(), patches);  // more if some are in pieces
  const auto bytes_of = [](const std::vector<std::vector<uint8_t>>& lists) {
    uint64_t bytes = 0;
    for (const std::vector<uint8_t>& list : lists) bytes += list.size();
    return bytes;
  };
  std::vector<PointOwner> owners(mesh.point_count);
  const Stitching stitching = build_stitching(streams->owned, 0, owners, pool);
  constexpr uint64_t kEntryBytes = 8;
  const uint64_t stored =
      bytes_of(streams->bytes) + bytes_of(stitching.maps) + kEntryBytes * streams->bytes.size();
  const Streams one = must(encode_streams(mesh, coded.codings, {}, 1, pool));
  EXPECT_LE(100 * stored, (100 + kMostSplitPercent) * bytes_of(one.bytes));
}

}  // namespace
}  // namespace psplit
