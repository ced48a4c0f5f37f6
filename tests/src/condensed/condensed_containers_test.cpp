// Containers of condensed streams that an encoder did not write: truncated, changed, and with heads that lie.
// Each is refused, or decodes within its bounds; sanitizers watch these. All readers agree on which, and decode
// to the same mesh.

#include <algorithm>
#include <random>

#include "encoder/draco/draco_backend.h"
#include "src/condensed/expand_container.h"
#include "src/container/bit_string.h"
#include "src/container/condensed_head.h"
#include "src/cpu/checked_decode.h"
#include "src/cpu/cpu_backend.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/patched_samples.h"
#include "tests/support/procedural_meshes.h"
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
  size_t stored = 0, skeletons = 0;
  for (const CondensedSample& sample : condensed_samples(pool)) {
    SCOPED_TRACE(sample.original.name);
    const PatchContainer container = must(open_container(sample.container));
    for (const StreamEntry& entry : container.entries) {
      stored += entry.is_condensed ? 0 : 1;
      skeletons += entry.skeleton > 0 ? 1 : 0;
    }
    const Bytes expanded = must(expand_container(container, pool));
    EXPECT_EQ(expanded, sample.original.encoded.container);
    const auto decoded =
        must(decode_container(cpu_backend(), sample.container, sample.original.requests, pool));
    const auto expected = must(
        decode_container(cpu_backend(), sample.original.encoded.container, sample.original.requests, pool));
    EXPECT_TRUE(same_bits(decoded, expected));
  }
  EXPECT_GT(stored, 0u);     // residues at least
  EXPECT_GT(skeletons, 0u);  // that are not the first
}

// Containers of some hundred bytes, in which most bytes mean something.
struct Seed {
  std::string name;
  Bytes container;
  std::vector<AttributeRequest> requests;
};
std::vector<Seed> small_seeds() {
  const ThreadPool pool(2);
  std::vector<Seed> seeds;
  for (CondensedSample& sample : condensed_samples(pool))
    if (sample.container.size() < 1500)
      seeds.push_back({sample.original.name, std::move(sample.container), sample.original.requests});
  return seeds;
}

TEST(CondensedContainers, EveryTruncationIsRefused) {
  const ThreadPool pool(1);
  for (const Seed& seed : small_seeds()) {
    for (size_t size = 0; size < seed.container.size(); ++size) {
      const Bytes cut(seed.container.begin(), seed.container.begin() + static_cast<std::ptrdiff_t>(size));
      ASSERT_FALSE(open_container(cut).ok()) << seed.name << " cut to " << size;
    }
  }
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

// One verdict for all who read a container: the decoder, the validator, libdraco behind expansion, and
// expansion itself.
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
  ASSERT_TRUE(same_bits(*decoded, *by_draco)) << name;
}

TEST(CondensedContainers, MutantsAreRefusedOrDecodeAsExpanded) {
  const ThreadPool pool(1);
  const std::vector<Seed> seeds = small_seeds();
  ASSERT_GT(seeds.size(), 10u);
  constexpr size_t kMutants = mutants_to_try(200'000);
  std::mt19937 random(1);
  size_t accepted = 0, compared = 0;
  for (size_t i = 0; i < kMutants; ++i) {
    const Seed& seed = seeds[random() % seeds.size()];
    const Bytes bytes = mutant_of(seed.container, random);
    const Expected<Mesh> decoded = decode_container(cpu_backend(), bytes, seed.requests, pool);
    accepted += decoded ? 1 : 0;
    if (i % (decoded ? 8 : 32) != 0) continue;
    ASSERT_NO_FATAL_FAILURE(
        expect_one_verdict(bytes, seed.requests, pool, decoded, seed.name + ", mutant " + std::to_string(i)));
    compared += decoded ? 1 : 0;
  }
  // A test that sees nothing but refusals would show little.
  EXPECT_GT(accepted, kMutants / 20);
  EXPECT_GT(compared, kMutants / 200);
}

// On large grids a wrong prediction soon reaches numbers whose range no transform of Draco has.
TEST(CondensedContainers, FlippedBitsOfTheHeadHaveOneVerdict) {
  const ThreadPool pool(1);
  size_t refused = 0, accepted = 0;
  for (const CondensedSample& sample : condensed_samples(pool)) {
    if (sample.original.name != "long edges, 21 bits") continue;
    Bytes bytes = sample.container;
    const size_t end = 8 * size_t{open_container(bytes)->header_bytes};
    constexpr size_t kFirst = 8 * 12, kStep = mutants_to_try(10) == 10 ? 3 : 30;
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

// A head for one stream of positions, and what a test changes in it.
struct HeadParts {
  uint32_t skeleton_count = 1, skeleton_length = 1, level = 5;
  uint32_t symbol_contexts = 0;
  std::vector<uint32_t> symbols{1000, 1000, 1000, 1000, 96};
  uint32_t attribute_count = 1, set_count = 1;
  uint32_t used = 3;
  std::vector<uint32_t> tokens{4000, 0, 96};
  bool has_flags = false;
  uint32_t probability = 2048;
  uint32_t seam_count = 0;
};
Bytes write(const HeadParts& parts) {
  BitStringWriter out;
  core::NumberKind count(0), length(5), used(5), symbol_frequency(4);
  out.number(count, parts.skeleton_count - 1);
  for (uint32_t i = 0; i < parts.skeleton_count; ++i) {
    out.bits(parts.level, 4);
    out.number(length, parts.skeleton_length);
    for (uint32_t byte = 0; byte < parts.skeleton_length; ++byte) out.bits(0, 8);
  }
  out.bits(parts.symbol_contexts, 4);
  for (const uint32_t frequency : parts.symbols) out.number(symbol_frequency, frequency);
  out.number(count, parts.attribute_count - 1);
  for (uint32_t i = 0; i < parts.attribute_count; ++i) {
    out.bits(0, 1);
    out.number(count, parts.set_count - 1);
    for (uint32_t table = 0; table < 2 * parts.set_count; ++table) {
      core::NumberKind frequency(4);
      out.number(used, parts.used);
      for (const uint32_t number : parts.tokens) out.number(frequency, number);
    }
    out.bits(parts.has_flags, 1);
    for (int flag = 0; flag < 6 && parts.has_flags; ++flag) out.bits(parts.probability, 12);
  }
  out.number(count, parts.seam_count);
  for (uint32_t i = 0; i < 2 * parts.seam_count; ++i) out.bits(parts.probability, 12);
  Bytes head;
  append_head_section(HeadSection::kTables, out.take(), head);
  return head;
}

TEST(CondensedContainers, HeadsThatLieAreRefusedAsTheHead) {
  const auto refusal = [](auto change) {
    HeadParts parts;
    change(parts);
    return read_condensed_head(write(parts)).status().to_string();
  };
  EXPECT_TRUE(read_condensed_head(write({})).ok()) << read_condensed_head(write({})).status().to_string();
  const std::vector<std::string> refusals{
      refusal([](HeadParts& head) { head.symbols[4] = 95; }),
      refusal([](HeadParts& head) { head.symbols[0] = 0xffffffffu; }),
      refusal([](HeadParts& head) { head.tokens[0] = 4001; }),
      refusal([](HeadParts& head) {
        head.tokens = {0, 0, 0};
      }),
      refusal([](HeadParts& head) {
        head.tokens = {0x80000000u, 0x80000000u, 4096};
      }),
      refusal([](HeadParts& head) { head.used = 117, head.tokens.resize(117); }),
      refusal([](HeadParts& head) { head.symbol_contexts = 6; }),
      refusal([](HeadParts& head) { head.symbol_contexts = 9; }),
      refusal([](HeadParts& head) { head.symbol_contexts = 5; }),  // more contexts than there are bits
      refusal([](HeadParts& head) { head.has_flags = true, head.probability = 0; }),
      refusal([](HeadParts& head) { head.seam_count = 1, head.probability = 0; }),
      refusal([](HeadParts& head) { head.seam_count = 129; }),
      refusal([](HeadParts& head) { head.skeleton_count = 256; }),
      refusal([](HeadParts& head) { head.skeleton_length = 4097; }),
      refusal([](HeadParts& head) { head.level = 12; }),
      refusal([](HeadParts& head) { head.attribute_count = 257; }),
      refusal([](HeadParts& head) { head.set_count = 9; }),
      refusal([](HeadParts& head) { head.attribute_count = 33, head.set_count = 8; }),  // more than 256 in all
  };
  for (size_t i = 0; i < refusals.size(); ++i)
    EXPECT_NE(refusals[i].find("head: "), std::string::npos) << "refusal " << i << ": " << refusals[i];
  Bytes longer = write({});
  longer.push_back(0);
  EXPECT_FALSE(read_condensed_head(longer).ok());
}

}  // namespace
}  // namespace psplit
