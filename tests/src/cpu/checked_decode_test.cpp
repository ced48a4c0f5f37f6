// A checked decode returns the mesh of an ordinary one, and a finding for each stream that breaks a rule.
#include "src/cpu/checked_decode.h"

#include "src/cpu/cpu_backend.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/patched_samples.h"

namespace psplit {
namespace {

TEST(CheckedDecode, GivesTheSameMeshAndNoFindingsForValidContainers) {
  const ThreadPool one(1), seven(7);
  for (const PatchedSample& sample : all_samples(seven)) {
    SCOPED_TRACE(sample.name);
    const PatchContainer container = must(open_container(sample.encoded.container));
    const Mesh expected = must(cpu_backend().decode(container, sample.requests, one));
    for (const ThreadPool* pool : {&one, &seven}) {
      const CheckedMesh checked = must(decode_checked(container, sample.requests, *pool));
      EXPECT_TRUE(same_bits(checked.mesh, expected));
      ASSERT_EQ(checked.streams.size(), container.entries.size());
      for (const StreamFindings& stream : checked.streams) {
        EXPECT_TRUE(stream.types.ok()) << stream.types.to_string();
        EXPECT_TRUE(stream.copies.ok()) << stream.copies.to_string();
      }
    }
  }
}

TEST(CheckedDecode, FindsAttributesOfAnotherTypeInEachStream) {
  const ThreadPool pool(3);
  for (PatchedSample& sample : all_samples(pool)) {
    SCOPED_TRACE(sample.name);
    AttributeRequest& position = sample.requests.front();
    if (position.component_type != ComponentType::kFloat32) continue;
    position.component_type = ComponentType::kInt16;
    const PatchContainer container = must(open_container(sample.encoded.container));
    const Expected<CheckedMesh> checked = decode_checked(container, sample.requests, pool);
    if (!checked) continue;  // a value does not fit
    for (size_t i = 0; i < checked->streams.size(); ++i) {
      EXPECT_EQ(checked->streams[i].types.place().patch, static_cast<int64_t>(i));
      EXPECT_TRUE(checked->streams[i].types.message().starts_with(position.semantic));
    }
  }
}

}  // namespace
}  // namespace psplit
