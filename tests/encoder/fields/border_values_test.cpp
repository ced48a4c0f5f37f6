// Values that patches share at their borders: known before any patch is decoded, for all patches or for one.
#include "src/container/border_values.h"

#include <algorithm>

#include "encoder/coding/quantization.h"
#include "encoder/fields/expand_container.h"
#include "psplit/decode.h"
#include "src/container/bit_string.h"
#include "src/container/condensed_head.h"
#include "src/cpu/checked_decode.h"
#include "tests/src/core/decode_mesh.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/patched_samples.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

// A container whose values at borders are stored once, and the one of Draco streams that it was made from.
struct Shared {
  CondensedSample sample;
  PatchContainer container;
  PatchContainer original() const { return *open_container(sample.original.encoded.pieces[0].bytes); }
};

CondensedSample blob_with_residue() {
  Mesh mesh = std::ranges::find(procedural_meshes(), "bare blob", &NamedMesh::name)->mesh;
  for (uint32_t i = 0; i < 5; ++i) mesh.faces.push_back({i, i, 3 * i + 1});
  std::vector<AttributeCoding> codings;
  for (const Attribute& attribute : mesh.attributes) codings.push_back(*fit_grid(attribute, 12));
  const StreamOptions options{.patch_count = 5};
  const ThreadPool pool(1);
  CondensedSample sample{encode_sample("bare blob with residue", mesh, codings, options, pool), {}};
  sample.container = condensed_container(*open_container(sample.original.encoded.pieces[0].bytes), true, pool);
  return sample;
}

const std::vector<Shared>& shared_samples() {
  static const std::vector<Shared> samples = [] {
    std::vector<Shared> found;
    std::vector<CondensedSample> all = condensed_samples(ThreadPool(2));
    all.push_back(blob_with_residue());
    for (CondensedSample& sample : all) {
      Expected<PatchContainer> container = open_container(sample.container);
      if (container && container->head && container->head->has_borders)
        found.push_back({std::move(sample), std::move(*container)});
    }
    return found;
  }();
  return samples;
}

core::StreamHeader completed(const PatchContainer& container, const BorderValues& borders, uint32_t patch) {
  core::StreamHeader header = container.headers[patch];
  borders.complete(patch, header);
  return header;
}

std::vector<int32_t> known_values(const core::StreamHeader& header) {
  const auto known = header.condensed.known;
  return {known.data(), known.data() + known.size()};
}

// Those before patch `end` have arrived: patches from `first` on are decoded before the others have headers.
TEST(BorderValues, AreKnownBeforeLaterPatchesArrive) {
  for (const Shared& shared : shared_samples()) {
    SCOPED_TRACE(shared.sample.original.name);
    const BorderValues all = must(BorderValues::decode(shared.container, ThreadPool(1)));
    PatchContainer arriving = shared.container;
    arriving.headers.clear();
    for (uint32_t first = 0, step = 1; first < arriving.entries.size(); first += step, ++step) {
      const auto end = std::min<uint32_t>(first + step, static_cast<uint32_t>(arriving.entries.size()));
      arriving.headers.assign(shared.container.headers.begin(), shared.container.headers.begin() + end);
      const BorderValues some = must(BorderValues::decode(arriving, first, end, ThreadPool(1)));
      for (uint32_t i = first; i < end; ++i)
        EXPECT_EQ(known_values(completed(arriving, some, i)),
                  known_values(completed(shared.container, all, i)));
    }
  }
}

// Only the headers of some patches, in any order, and of the patches that own their values are present.
TEST(BorderValues, OfSomePatchesNeedOnlyTheirOwners) {
  size_t left_out = 0;
  for (const Shared& shared : shared_samples()) {
    SCOPED_TRACE(shared.sample.original.name);
    const PatchContainer& container = shared.container;
    const BorderValues all = must(BorderValues::decode(container, ThreadPool(1)));
    for (uint32_t step = 1; step <= 3; ++step) {
      std::vector<uint32_t> some;
      for (uint32_t i = container.patch_count(); i-- > 0;)
        if (i % step == 0) some.push_back(i);
      PatchContainer with_gaps = container;
      with_gaps.headers.assign(container.headers.size(), {});
      std::vector<uint32_t> needed = some;
      for (const uint32_t patch : some) BorderValues::append_owners(container, patch, needed);
      for (const uint32_t i : needed) with_gaps.headers[i] = container.headers[i];
      std::sort(needed.begin(), needed.end());
      needed.erase(std::unique(needed.begin(), needed.end()), needed.end());
      left_out += container.patch_count() - needed.size();
      const BorderValues found = must(BorderValues::decode(with_gaps, some));
      for (const uint32_t i : some)
        EXPECT_EQ(known_values(completed(with_gaps, found, i)), known_values(completed(container, all, i)));
    }
  }
  EXPECT_GT(left_out, 10u);
}

TEST(BorderValues, AreTheSameForAllPatchesAndForEachAlone) {
  size_t values = 0, own_values = 0, with_residue = 0;
  for (const Shared& shared : shared_samples()) {
    SCOPED_TRACE(shared.sample.original.name);
    const PatchContainer& container = shared.container;
    with_residue += container.has_residue;
    const BorderValues all = must(BorderValues::decode(container, ThreadPool(3)));
    for (uint32_t i = 0; i < container.entries.size(); ++i) {
      const BorderValues one = must(BorderValues::decode(container, i));
      const core::StreamHeader header = completed(container, all, i);
      EXPECT_EQ(known_values(header), known_values(completed(container, one, i)));
      EXPECT_EQ(known_values(header), known_values(container.alone(i).headers[0]));
      values += header.condensed.known.size();
      own_values += size_t{header.condensed.border_count} * header.condensed.border_components;
    }
  }
  EXPECT_GT(shared_samples().size(), 10u);
  EXPECT_GT(with_residue, 0u);
  EXPECT_GT(values, own_values + 1000);
}

// Any lanes, both widths of indices, and exactly the memory that the counts ask for.
TEST(BorderValues, PatchesWithThemDecodeAsTheirDracoStreams) {
  constexpr LaneOrder kOrder = kLaneOrders[0];
  for (const Shared& shared : shared_samples()) {
    SCOPED_TRACE(shared.sample.original.name);
    const BorderValues borders = must(BorderValues::decode(shared.container, ThreadPool(1)));
    for (uint32_t i = 0; i < shared.container.patch_count(); ++i) {
      const std::span<const uint8_t> draco = shared.original().streams[i];
      const auto expected = must(decode_with_libdraco({draco.begin(), draco.end()}));
      const core::StreamHeader header = completed(shared.container, borders, i);
      const size_t bytes = shared.container.streams[i].size();
      RawMesh decoded;
      ASSERT_EQ(core::decode_in_workspace<uint32_t>(header, bytes, expected, decoded), core::Fault::kNone);
      EXPECT_TRUE(decoded == expected);
      ASSERT_EQ(core::decode_by_warp<uint32_t>(header, kOrder, decoded), core::Fault::kNone);
      EXPECT_TRUE(decoded == expected);
      if (!header.fits_16_bits()) continue;
      ASSERT_EQ(core::decode_in_workspace<uint16_t>(header, bytes, expected, decoded), core::Fault::kNone);
      EXPECT_TRUE(decoded == expected);
      ASSERT_EQ(core::decode_by_warp<uint16_t>(header, kOrder, decoded), core::Fault::kNone);
      EXPECT_TRUE(decoded == expected);
      // Values for another number of places are refused, and so are none.
      core::StreamHeader wrong = header;
      if (header.condensed.known.empty()) continue;
      wrong.condensed.known = header.condensed.known.first(header.condensed.known.size() - 1);
      EXPECT_EQ(core::decode<uint16_t>(wrong, decoded), core::Fault::kCounts);
      EXPECT_EQ(core::decode<uint16_t>(shared.container.headers[i], decoded), core::Fault::kCounts);
    }
  }
}

// Lanes share the copies of a run.
TEST(BorderValues, AnyLanesCopyTheSameValues) {
  for (const Shared& shared : shared_samples()) {
    const PatchContainer& container = shared.container;
    const BorderValues borders = must(BorderValues::decode(container, ThreadPool(1)));
    for (uint32_t i = 0; i < container.patch_count(); ++i) {
      const core::StitchRow row = container.stitch_row(i);
      const core::StreamHeader header = completed(container, borders, i);
      std::vector<int32_t> values = known_values(header);
      const size_t components = header.condensed.border_components;
      core::StitchReader reader(row);
      for (core::StitchReader::Run run; reader.next_run(run);)
        std::fill_n(values.begin() + static_cast<std::ptrdiff_t>(run.begin * components),
                    run.length * components, -1);
      // All places of owners have values here.
      std::vector<std::vector<int32_t>> of_owner;
      std::vector<uint8_t> is_own(1 << 12, 1);
      for (uint32_t owner = 0; owner <= i; ++owner)
        of_owner.push_back(known_values(completed(container, borders, owner)));
      const auto walk_of = [&](uint32_t owner) {
        std::vector<int32_t>& walk = of_owner[owner];
        return core::WalkValues{{walk.data(), walk.size()},
                                {is_own.data(), is_own.size()},
                                static_cast<uint32_t>(walk.size() / components)};
      };
      const core::WalkValues out{{values.data(), values.size()}, {}, 0};
      run_warp(
          [&](EmulatedLanes lanes) {
            EXPECT_EQ(core::copy_shared_values(lanes, row, header.condensed, walk_of, out), core::Fault::kNone);
          },
          kLaneOrders[i % kLaneOrders.size()]);
      EXPECT_EQ(values, known_values(header));
    }
  }
}

TEST(BorderValues, AreNotSharedWithStoredPatches) {
  const Shared& shared = shared_samples().front();
  ASSERT_GT(shared.container.patch_count(), 1u);
  ContainerParts parts(shared.container);
  parts.streams[1] = ContainerParts(shared.original()).streams[1];
  parts.entries[1].is_condensed = false;
  const auto bytes = parts.write();
  const Status status = open_container(bytes).status();
  EXPECT_EQ(status.to_string(), "patch 1: it is stored, but values at borders are shared");
}

// Without its stitch map, a patch has fewer values than places.
TEST(BorderValues, OfAnotherNumberThanPlacesAreRefused) {
  const ThreadPool pool(1);
  size_t refused = 0;
  for (const Shared& shared : shared_samples()) {
    ContainerParts parts(shared.container);
    const core::CondensedStream& last = shared.container.headers[shared.container.patch_count() - 1].condensed;
    const uint32_t patch = shared.container.patch_count() - 1;
    const Expected<BorderValues> borders = BorderValues::decode(shared.container, patch);
    const size_t places = completed(shared.container, *borders, patch).condensed.known.size();
    if (places == size_t{last.border_count} * last.border_components) continue;
    parts.stitch[patch] = {};
    parts.entries[patch].reference_count = 0;
    const auto bytes = parts.write();
    const auto& requests = shared.sample.original.requests;
    const Expected<Mesh> decoded = decode_container(cpu_backend(), bytes, requests, pool);
    EXPECT_EQ(decoded.status().to_string(),
              "patch " + std::to_string(patch) + ": Draco stream: " + core::fault_text(core::Fault::kCounts));
    const PatchContainer container = must(open_container(bytes));
    EXPECT_FALSE(expand_container(container, pool));
    EXPECT_FALSE(expand_patch(container, patch));
    EXPECT_FALSE(decode_checked(container, requests, pool));
    EXPECT_TRUE(expand_patch(container, 0));
    ++refused;
  }
  EXPECT_GT(refused, 5u);
}

// A stitch map that breaks off is the error of the patches that need its stream's values, and of no other
// patch.
TEST(BorderValues, PatchesAloneNeedOnlyTheirOwners) {
  size_t refused = 0, decoded = 0;
  const DecodeBackend backend = cpu_backend();
  const ThreadPool pool(1);
  for (const Shared& shared : shared_samples()) {
    constexpr uint32_t kBroken = 1;
    if (shared.container.patch_count() < 3 || shared.container.entries[kBroken].reference_count == 0) continue;
    ContainerParts parts(shared.container);
    parts.stitch[kBroken].assign(8, 0);
    const auto bytes = parts.write();
    const PatchContainer container = must(open_container(bytes));
    const std::string refusal = std::string("patch 1: ") + core::fault_text(core::Fault::kStitchMap);
    EXPECT_EQ(BorderValues::decode(container, pool).status().to_string(), refusal);
    for (uint32_t i = 0; i < container.patch_count(); ++i) {
      bool needs_broken = i == kBroken;
      core::StitchReader reader(container.stitch_row(i));
      for (core::StitchReader::Run run; reader.next_run(run);) needs_broken |= run.owner == kBroken;
      const PatchContainer alone = container.alone(i);
      const DecodeTask task{&alone, shared.sample.original.requests};
      const Expected<Mesh> mesh = std::move(backend.decode({&task, 1}, pool).front());
      if (needs_broken)
        EXPECT_EQ(mesh.status().to_string(), refusal);
      else
        EXPECT_TRUE(mesh) << mesh.status().to_string();
      EXPECT_EQ(expand_patch(container, i).ok(), !needs_broken);
      ++(needs_broken ? refused : decoded);
    }
  }
  EXPECT_GT(decoded, 0u);
  EXPECT_GT(refused, 0u);
}

// The owner's place must be one that it owns.
TEST(BorderValues, AreNotThoseOfOtherReferences) {
  constexpr uint32_t kComponents = 1;
  std::vector<int32_t> owner_values{5, 6}, values{0};
  std::vector<uint8_t> is_own{1, 0};
  core::CondensedStream stream;
  stream.border_components = kComponents;
  const core::WalkValues out{{values.data(), values.size()}, {}, 0};
  for (const uint32_t place : {0u, 1u, 2u}) {
    // One run of one point: counts and skips of 0, no last owner, back 1, the place.
    BitStringWriter bits;
    core::StitchKinds kinds(2, 1);
    bits.number(kinds.count, 1);
    bits.number(kinds.walk_skip, 0);
    bits.number(kinds.length, 0);
    bits.number(kinds.back, 1);
    bits.number(kinds.place, place);
    const std::vector<uint8_t> bytes = bits.take();
    core::StitchRow row;
    row.bytes = {bytes.data(), bytes.size()};
    row.stream = 1;
    row.point_count = 2;
    row.reference_count = 1;
    const core::Fault fault = core::copy_shared_values(
        core::SerialLanes(), row, stream,
        [&](uint32_t) {
          return core::WalkValues{
              {owner_values.data(), owner_values.size()}, {is_own.data(), is_own.size()}, 2};
        },
        out);
    EXPECT_EQ(fault, place == 0 ? core::Fault::kNone : core::Fault::kStitchOwner);
    EXPECT_EQ(values[0], 5);
  }
}

}  // namespace
}  // namespace psplit
