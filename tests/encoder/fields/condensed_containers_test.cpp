// Containers of condensed streams that an encoder did not write: each is refused, or decodes within its bounds;
// sanitizers watch these. All readers agree on which, and decode to the same mesh.

#include <algorithm>
#include <random>

#include "encoder/fields/expand_container.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "src/cpu/checked_decode.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/patched_samples.h"
#include "tests/support/same_bits.h"
#include "tests/support/sanitizers.h"

namespace psplit {
namespace {

using Bytes = std::vector<uint8_t>;

// The mesh of a container whose streams are expanded first. Not ok if a stream has no Draco stream.
Expected<Mesh> decode_expanded(const Bytes& bytes, std::span<const AttributeRequest> requests,
                               const ThreadPool& pool) {
  const Expected<PatchContainer> container = open_container(bytes);
  if (!container) return container.status();
  const Expected<Bytes> expanded = expand_container(*container, pool);
  if (!expanded) return expanded.status();
  return decode_container(cpu_backend(), *expanded, requests, pool);
}

TEST(CondensedContainers, ExpandToTheContainersTheyWereMadeFrom) {
  const ThreadPool pool(2);
  size_t stored = 0, skeletons = 0, with_deltas = 0, with_references = 0;
  for (const CondensedSample& sample : condensed_samples(pool)) {
    SCOPED_TRACE(sample.original.name);
    const PatchContainer container = must(open_container(sample.container));
    for (const StreamEntry& entry : container.entries) {
      stored += entry.is_condensed ? 0 : 1;
      skeletons += entry.skeleton > 0 ? 1 : 0;
    }
    const std::vector<core::DeltaModel>& deltas = container.head->deltas;
    with_deltas += deltas.empty() ? 0 : 1;
    with_references += std::ranges::any_of(deltas,
                                           [](const core::DeltaModel& model) {
                                             return model.reference != core::DeltaModel::kNoReference;
                                           })
                           ? 1
                           : 0;
    const Bytes expanded = must(expand_container(container, pool));
    EXPECT_EQ(expanded, sample.original.encoded.pieces[0].bytes);
    const auto decoded =
        must(decode_container(cpu_backend(), sample.container, sample.original.requests, pool));
    EXPECT_TRUE(same_bits(decoded, sample.original.mesh));
  }
  EXPECT_GT(stored, 0u);     // residues at least
  EXPECT_GT(skeletons, 0u);  // that are not the first
  EXPECT_GT(with_deltas, 3u);
  EXPECT_GT(with_references, 1u);
}

Bytes mutant_of(const Bytes& container, std::mt19937& random) {
  const auto below = [&](size_t bound) { return static_cast<size_t>(random() % bound); };
  Bytes bytes = container;
  for (size_t edits = 1 + below(2); edits > 0; --edits) {
    // Sums of lengths refuse most other changes. The last stream may have any length.
    const size_t at =
        below(2) == 0 ? below(bytes.size()) : 20 + below(std::min<size_t>(bytes.size() - 20, 400));
    if (below(2) == 0)
      bytes[at] ^= static_cast<uint8_t>(1u << below(8));
    else
      bytes[at] = static_cast<uint8_t>(random());
  }
  return bytes;
}

// All readers of a container have one verdict: the decoder, the validator, expansion, and libdraco after
// expansion.
void expect_one_verdict(const Bytes& bytes, std::span<const AttributeRequest> requests, const ThreadPool& pool,
                        const Expected<Mesh>& decoded, const std::string& name) {
  const Expected<PatchContainer> container = open_container(bytes);
  const Expected<Mesh> expanded = decode_expanded(bytes, requests, pool);
  ASSERT_EQ(decoded.ok(), expanded.ok())
      << name << decoded.status().to_string() << expanded.status().to_string();
  if (!container) return;
  const Expected<CheckedMesh> checked = decode_checked(*container, requests, pool);
  const Expected<Mesh> by_draco = draco_backend().decode(*container, requests, pool);
  ASSERT_EQ(decoded.ok(), checked.ok()) << name << decoded.status().to_string() << checked.status().to_string();
  ASSERT_EQ(decoded.ok(), by_draco.ok())
      << name << decoded.status().to_string() << by_draco.status().to_string();
  if (!decoded) return;
  ASSERT_TRUE(same_bits(*decoded, *expanded)) << name;
  ASSERT_TRUE(same_bits(*decoded, checked->mesh)) << name;
  // Where copies of a point differ, which no encoder writes, libdraco's backend may keep another one.
  const bool has_one_mesh = std::ranges::all_of(
      checked->streams, [](const StreamFindings& findings) { return findings.copies.ok(); });
  if (has_one_mesh) {
    ASSERT_TRUE(same_bits(*decoded, *by_draco)) << name;
  }
}

TEST(CondensedContainers, MutantsAreRefusedOrDecodeAsExpanded) {
  const ThreadPool pool(1);
  // Containers of some hundred bytes, in which most bytes mean something.
  std::vector<CondensedSample> seeds = condensed_samples(pool);
  std::erase_if(seeds, [](const CondensedSample& sample) { return sample.container.size() >= 1500; });
  ASSERT_GT(seeds.size(), 10u);
  constexpr size_t kMutants = fewer_with_sanitizers(200'000);
  std::mt19937 random(1);
  size_t accepted = 0, compared = 0;
  for (size_t i = 0; i < kMutants; ++i) {
    const auto& [original, container] = seeds[random() % seeds.size()];
    const Bytes bytes = mutant_of(container, random);
    const Expected<Mesh> decoded = decode_container(cpu_backend(), bytes, original.requests, pool);
    accepted += decoded ? 1 : 0;
    if (i % (decoded ? 8 : 32) != 0) continue;
    ASSERT_NO_FATAL_FAILURE(expect_one_verdict(bytes, original.requests, pool, decoded,
                                               original.name + ", mutant " + std::to_string(i)));
    compared += decoded ? 1 : 0;
  }
  // A test that sees nothing but refusals would show little.
  EXPECT_GT(accepted, kMutants / 20);
  EXPECT_GT(compared, kMutants / 200);
}

// On large grids a wrong prediction soon reaches numbers whose range no transform of Draco has.
TEST(CondensedContainers, MutantsOfTheHeadHaveOneVerdict) {
  const ThreadPool pool(1);
  size_t refused = 0, accepted = 0;
  for (const CondensedSample& sample : condensed_samples(pool)) {
    if (sample.original.name != "long edges, 21 bits") continue;
    Bytes bytes = sample.container;
    const size_t end = 8 * size_t{open_container(bytes)->header_bytes};
    constexpr size_t kFirst = 8 * 12, kStep = !kHasSanitizers ? 3 : 30;
    for (size_t bit = kFirst; bit < end; bit += kStep) {
      const auto flip = [&] { bytes[bit / 8] = static_cast<uint8_t>(bytes[bit / 8] ^ 1u << bit % 8); };
      flip();
      const Expected<Mesh> decoded = decode_container(cpu_backend(), bytes, sample.original.requests, pool);
      ++(decoded ? accepted : refused);
      ASSERT_NO_FATAL_FAILURE(
          expect_one_verdict(bytes, sample.original.requests, pool, decoded, "bit " + std::to_string(bit)));
      flip();
    }
  }
  EXPECT_GT(accepted, 20u);
  EXPECT_GT(refused, 20u);
}

}  // namespace
}  // namespace psplit
