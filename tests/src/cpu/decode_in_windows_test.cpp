// Decoding in windows of streams gives the mesh, or the error, that decoding all at once gives.

#include "src/cpu/container_decoder.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/patched_samples.h"
#include "tests/support/same_bits.h"

namespace psplit {
namespace {

struct Decoded {
  Mesh mesh;
  Status status;
  std::vector<StreamFindings> findings;
  uint32_t end = 0;  // of the last window
};

// most_faces 0: all at once.
Decoded decode(const PatchContainer& container, std::span<const AttributeRequest> requests,
               const ThreadPool& pool, uint64_t most_faces) {
  Decoded result;
  const Expected<PrimitiveBuffers> out = allocate_mesh(container.point_count(), container.face_count(),
                                                       requests, container.bytes.size(), result.mesh);
  if (!out) {
    result.status = out.status();
    return result;
  }
  result.findings.resize(container.entries.size());
  const Watch watch;
  Steps steps(watch, container.entries.size());
  const DecodeTask task{&container, requests};
  ContainerDecoder decoder(task, *out, pool, steps, &result.findings);
  result.status =
      most_faces == 0 ? decoder.decode() : decoder.decode_in_windows(most_faces, [&](StreamRange window) {
        EXPECT_EQ(window.first, result.end);
        EXPECT_GT(window.end, window.first);
        result.end = window.end;
      });
  return result;
}

TEST(DecodeInWindows, GivesTheSameMeshAndFindings) {
  const ThreadPool one(1), seven(7);
  for (const PatchedSample& sample : all_samples(seven)) {
    SCOPED_TRACE(sample.name);
    const PatchContainer container = must(open_container(sample.encoded.pieces[0].bytes));
    const Decoded whole = decode(container, sample.requests, one, 0);
    ASSERT_TRUE(whole.status.ok());
    const uint64_t faces = container.face_count();
    for (const uint64_t most_faces : {uint64_t{1}, faces / 5 + 1, faces / 2 + 1, faces}) {
      const Decoded windows = decode(container, sample.requests, seven, most_faces);
      ASSERT_TRUE(windows.status.ok()) << windows.status.to_string();
      EXPECT_TRUE(same_bits(windows.mesh, whole.mesh));
      EXPECT_EQ(windows.end, container.entries.size());
      for (const StreamFindings& stream : windows.findings)
        EXPECT_TRUE(stream.types.ok() && stream.copies.ok());
    }
  }
}

TEST(DecodeInWindows, GivesTheSameErrorForMutants) {
  const ThreadPool pool(2);
  size_t errors = 0, findings = 0;
  for (const PatchedSample& sample : all_samples(pool)) {
    SCOPED_TRACE(sample.name);
    std::vector<uint8_t> bytes = sample.encoded.pieces[0].bytes;
    if (bytes.size() > 5000) continue;
    const size_t step = std::max<size_t>(1, bytes.size() / 60);
    for (size_t at = 0; at < bytes.size(); at += step) {
      bytes[at] ^= 0x5a;
      bytes[bytes.size() - 1 - at] ^= 0x11;
      if (const Expected<PatchContainer> container = open_container(bytes)) {
        const Decoded whole = decode(*container, sample.requests, pool, 0);
        for (const uint64_t most_faces : {uint64_t{1}, uint64_t{container->face_count()} / 3 + 1}) {
          const Decoded windows = decode(*container, sample.requests, pool, most_faces);
          ASSERT_EQ(windows.status.to_string(), whole.status.to_string());
          if (!whole.status.ok()) continue;
          EXPECT_TRUE(same_bits(windows.mesh, whole.mesh));
          for (size_t i = 0; i < whole.findings.size(); ++i) {
            EXPECT_EQ(windows.findings[i].types.to_string(), whole.findings[i].types.to_string());
            EXPECT_EQ(windows.findings[i].copies.to_string(), whole.findings[i].copies.to_string());
            findings += !whole.findings[i].copies.ok();
          }
        }
        errors += !whole.status.ok();
      }
      bytes[at] ^= 0x5a;
      bytes[bytes.size() - 1 - at] ^= 0x11;
    }
  }
  EXPECT_GT(errors, 100u);
  EXPECT_GT(findings, 0u);
}

}  // namespace
}  // namespace psplit
