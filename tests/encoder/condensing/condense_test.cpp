// Streams that libdraco's encoder wrote are condensed, and come back bit for bit.
#include "encoder/condensing/condense.h"

#include <gtest/gtest.h>

#include <map>

#include "encoder/draco/draco_backend.h"
#include "src/condensed/expand.h"
#include "tests/support/draco_streams.h"

namespace psplit {
namespace {

struct Tally {
  size_t streams = 0, condensed = 0, before = 0, after = 0;
};

// Condenses streams as those of one primitive, and expands them again.
void expect_round_trip(std::span<const std::vector<uint8_t>> streams, Tally& tally) {
  std::vector<DecodedCounts> counts;
  for (const std::vector<uint8_t>& stream : streams) {
    const Expected<StreamCounts> of_stream = stream_counts(stream);
    ASSERT_TRUE(of_stream.ok());
    counts.push_back({of_stream->face_count, of_stream->point_count});
  }
  const ThreadPool pool(1);
  const CondensedStreams condensed = condense(streams, counts, false, pool);
  ASSERT_EQ(condensed.bytes.size(), streams.size());
  Expected<CondensedHead> head = CondensedHead();
  if (!condensed.head.empty()) head = read_condensed_head(condensed.head);
  ASSERT_TRUE(head.ok()) << head.status().message();
  tally.streams += streams.size();
  tally.after += condensed.head.size();
  for (size_t i = 0; i < streams.size(); ++i) {
    tally.before += streams[i].size();
    tally.after += condensed.bytes[i].size();
    if (condensed.is_condensed[i] == 0) {
      EXPECT_EQ(condensed.bytes[i], streams[i]);
      continue;
    }
    ++tally.condensed;
    const Expected<std::vector<uint8_t>> expanded = expand_stream(
        *head, {condensed.bytes[i], condensed.skeleton[i], counts[i].face_count, counts[i].point_count});
    ASSERT_TRUE(expanded.ok()) << expanded.status().message();
    EXPECT_EQ(*expanded, streams[i]);
  }
}

TEST(Condense, EveryStreamComesBack) {
  constexpr size_t kTogether = 100;
  std::vector<std::vector<uint8_t>> streams;
  Tally tally;
  for_each_draco_stream(
      [&](const DracoStream& stream) {
        streams.push_back(stream.bytes);
        if (streams.size() < kTogether) return;
        expect_round_trip(streams, tally);
        streams.clear();
      },
      StreamSet::kAll);
  printf("%zu streams, %zu condensed, %zu bytes, %zu\n", tally.streams, tally.condensed, tally.before,
         tally.after);
}

}  // namespace
}  // namespace psplit
