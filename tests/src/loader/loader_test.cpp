#include "psplit/loader.h"

#include <algorithm>
#include <atomic>
#include <random>
#include <stdexcept>
#include <utility>
#include <variant>

#include "encoder/fields/expand_container.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "src/container/claims.h"
#include "tests/src/loader/buffers.h"
#include "tests/src/loader/counted_memory.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/mutants.h"
#include "tests/support/patched_samples.h"
#include "tests/support/same_bits.h"

namespace psplit {
namespace {

const std::vector<PatchedSample>& samples() { return all_samples(ThreadPool(2)); }

const PatchedSample& sample_of_many_patches() {
  for (const PatchedSample& sample : samples())
    if (sample.encoded.statistics.patch_count > 4) return sample;
  ADD_FAILURE() << "no sample has many patches";
  return samples().front();
}

PrimitiveSource source_of(const PatchedSample& sample) {
  return {sample.encoded.pieces[0].bytes, sample.requests};
}

TEST(Loader, ReportsWhatTheCallersExecutorAndCallbackDo) {
  const PatchedSample& sample = sample_of_many_patches();
  const CompressedPrimitive primitive = must(CompressedPrimitive::open(source_of(sample)));
  Buffers buffers(sample.requests, primitive.point_count(), primitive.face_count(), 4, 0);
  const ThreadPool dropping(4, [](size_t count, const std::function<void(size_t)>& body) {
    for (size_t i = 0; i + 1 < count; ++i) body(i);
  });
  const Status dropped = primitive.decode(buffers.out, {.pool = &dropping});
  EXPECT_EQ(dropped.code(), StatusCode::kRuntimeFailure);
  EXPECT_NE(dropped.message().find("the executor ran"), std::string::npos) << dropped.message();
  const ThreadPool pool(3);
  const auto decode = [&](Progress progress) {
    LoadOptions options;
    options.pool = &pool;
    options.progress = std::move(progress);
    return primitive.decode(buffers.out, options);
  };
  const Status thrown = decode([](size_t, size_t) { throw std::runtime_error("a callback"); });
  EXPECT_EQ(thrown.code(), StatusCode::kRuntimeFailure);
  EXPECT_EQ(thrown.message(), "a callback");
  EXPECT_EQ(decode([](size_t, size_t) { throw std::bad_alloc(); }).code(), StatusCode::kOutOfMemory);
  EXPECT_TRUE(decode({}).ok());
}

// Not the points of an Edgebreaker stream: only its faces tell them.
TEST(Loader, ComparesTheCallersCountsBeforeItWrites) {
  const PatchedSample& sample = sample_of_many_patches();
  PrimitiveSource source = source_of(sample);
  source.point_count = sample.mesh.point_count + 1;
  EXPECT_EQ(CompressedPrimitive::open(source).status().code(), StatusCode::kInvalidInput);
  source.point_count = sample.mesh.point_count;
  source.index_count = 3 * sample.mesh.faces.size() + 3;
  EXPECT_EQ(CompressedPrimitive::open(source).status().code(), StatusCode::kInvalidInput);
  source.index_count -= 3;
  EXPECT_TRUE(CompressedPrimitive::open(source).ok());
}

TEST(Expected, GivesItsValueWithoutExceptions) {
  Expected<int> number = 7;
  ASSERT_NE(number.value_if(), nullptr);
  *number.value_if() = 8;
  EXPECT_EQ(*std::as_const(number).value_if(), 8);
  Expected<int> failed = invalid_input("broken");
  EXPECT_EQ(failed.value_if(), nullptr);
  EXPECT_EQ(std::as_const(failed).value_if(), nullptr);
  EXPECT_THROW(*failed, std::bad_variant_access);
}

TEST(Loader, DecodesIntoBuffersOfAnyLayoutWhatTheBackendDecodes) {
  const DecodeBackend draco = draco_backend();
  const auto expect_decoded = [&](const PatchedSample& sample) {
    SCOPED_TRACE(sample.name);
    const Mesh& expected = sample.mesh;
    const CompressedPrimitive primitive = must(CompressedPrimitive::open(source_of(sample)));
    EXPECT_EQ(primitive.least_index_bytes(), expected.point_count > 0xffff ? 4u : 2u);
    ASSERT_EQ(primitive.point_count(), expected.point_count);
    ASSERT_EQ(primitive.face_count(), expected.faces.size());
    for (size_t k = 0; k < sample.requests.size(); ++k)
      EXPECT_EQ(primitive.value_bytes(k), expected.attributes[k].values.size());
    for (const DecodeBackend* backend : {static_cast<const DecodeBackend*>(nullptr), &draco})
      for (const uint32_t index_bytes : {2u, 4u})
        for (const size_t gap : {0u, 3u}) {
          if (index_bytes < primitive.least_index_bytes()) continue;
          Buffers buffers(sample.requests, primitive.point_count(), primitive.face_count(), index_bytes, gap);
          LoadOptions options{.backend = backend};
          const ThreadPool threads(gap == 0 ? 1 : 3);
          options.pool = &threads;
          must(primitive.decode(buffers.out, options));
          EXPECT_TRUE(same_bits(buffers.mesh(sample.requests, expected.point_count), expected));
        }
  };
  std::ranges::for_each(samples(), expect_decoded);
  std::ranges::for_each(large_samples(ThreadPool(2)), expect_decoded);
}

TEST(Loader, TightBuffersNeedNoStride) {
  const PatchedSample& sample = samples().front();
  const CompressedPrimitive primitive = must(CompressedPrimitive::open(source_of(sample)));
  Buffers strided(sample.requests, primitive.point_count(), primitive.face_count());
  Buffers tight(sample.requests, primitive.point_count(), primitive.face_count());
  for (AttributeBuffer& buffer : tight.out.attributes) buffer.stride = 0;
  ASSERT_TRUE(primitive.decode(strided.out).ok());
  ASSERT_TRUE(primitive.decode(tight.out).ok());
  EXPECT_EQ(strided.values, tight.values);
}

TEST(Loader, DecodesEachPatchAloneAsItsStreamIs) {
  const DecodeBackend draco = draco_backend();
  size_t residues = 0;
  for (const PatchedSample& sample : samples()) {
    SCOPED_TRACE(sample.name);
    const CompressedPrimitive primitive = must(CompressedPrimitive::open(source_of(sample)));
    const PatchContainer container = must(open_container(sample.encoded.pieces[0].bytes));
    residues += primitive.has_residue();
    uint32_t faces = 0, owned = 0;
    for (uint32_t n = 0; n < primitive.patch_count(); ++n) {
      const PatchSizes sizes = primitive.patch(n);
      EXPECT_EQ(sizes.first_face, faces);
      EXPECT_EQ(sizes.first_owned_point, owned);
      faces += sizes.face_count;
      owned += sizes.owned_point_count;
      const std::vector<uint8_t> stream = must(expand_patch(container, n));
      Mesh expected = must(decode_stream(draco, stream, sample.requests));
      expected.faces.resize(sizes.face_count);  // the residue's stream may have more
      for (const DecodeBackend* backend : {static_cast<const DecodeBackend*>(nullptr), &draco}) {
        const LoadOptions options{.backend = backend};
        Buffers buffers(sample.requests, sizes.point_count, sizes.face_count, 2);
        must(primitive.decode_patch(n, buffers.out, options));
        EXPECT_TRUE(same_bits(buffers.mesh(sample.requests, sizes.point_count), expected));
      }
    }
    EXPECT_EQ(faces, primitive.face_count());
    EXPECT_EQ(owned, primitive.point_count());
  }
  EXPECT_GT(residues, 0u);
}

TEST(Loader, DecodesManyAtOnceWithSeparateErrors) {
  std::vector<CompressedPrimitive> primitives;
  std::vector<std::unique_ptr<Buffers>> buffers;
  std::vector<PrimitiveLoad> loads;
  for (const PatchedSample& sample : samples()) {
    const CompressedPrimitive primitive = must(CompressedPrimitive::open(source_of(sample)));
    buffers.push_back(
        std::make_unique<Buffers>(sample.requests, primitive.point_count(), primitive.face_count()));
    loads.push_back({primitive, buffers.back()->out});
  }
  loads[1].out.index_bytes = 3;
  const std::vector<Status> statuses = decode_primitives(loads);
  ASSERT_EQ(statuses.size(), loads.size());
  for (size_t i = 0; i < loads.size(); ++i) {
    EXPECT_EQ(statuses[i].code(), i == 1 ? StatusCode::kUsage : StatusCode::kOk) << statuses[i].to_string();
    if (i == 1) continue;
    const Mesh& expected = samples()[i].mesh;
    EXPECT_TRUE(same_bits(buffers[i]->mesh(samples()[i].requests, expected.point_count), expected));
  }
}

TEST(Loader, RefusesBuffersThatDoNotDo) {
  const PatchedSample& sample = sample_of_many_patches();
  const CompressedPrimitive primitive = must(CompressedPrimitive::open(source_of(sample)));
  const auto message = [&](auto change) {
    Buffers buffers(sample.requests, primitive.point_count(), primitive.face_count());
    change(buffers.out);
    const Status status = primitive.decode(buffers.out);
    EXPECT_EQ(status.code(), StatusCode::kUsage);
    return status.message();
  };
  using Out = PrimitiveBuffers;
  const auto shorten = [](auto& span) { span = span.first(span.size() - 1); };
  EXPECT_TRUE(contains(message([](Out& out) { out.index_bytes = 1; }), "indices of 1 bytes"));
  EXPECT_TRUE(contains(message([&](Out& out) { shorten(out.indices); }), "no room"));
  EXPECT_TRUE(contains(message([](Out& out) { out.attributes.pop_back(); }), "buffers for"));
  EXPECT_TRUE(contains(message([](Out& out) { out.attributes[0].stride = 1; }), "stride"));
  EXPECT_TRUE(contains(message([&](Out& out) { shorten(out.attributes[0].bytes); }), "no room"));
  EXPECT_TRUE(contains(message([](Out& out) { out.attributes[0].bytes = {}; }), "no room"));
  std::vector<std::byte> more(size_t{12} * primitive.face_count() + 1);
  EXPECT_TRUE(contains(message([&](Out& out) { out.indices = std::span(more).subspan(1); }), "aligned"));
  Buffers buffers(sample.requests, primitive.point_count(), primitive.face_count());
  EXPECT_EQ(primitive.decode_patch(primitive.patch_count(), buffers.out).code(), StatusCode::kUsage);
}

TEST(Loader, RefusesAccessorsThatContradictTheDirectory) {
  const PatchedSample& sample = samples().front();
  const CompressedPrimitive primitive = must(CompressedPrimitive::open(source_of(sample)));
  PrimitiveSource source = source_of(sample);
  source.point_count = primitive.point_count();
  source.index_count = 3 * primitive.face_count();
  EXPECT_TRUE(CompressedPrimitive::open(source));
  ++source.point_count;
  EXPECT_EQ(CompressedPrimitive::open(source).status().code(), StatusCode::kInvalidInput);
  source = source_of(sample);
  source.index_count = 3;
  EXPECT_EQ(CompressedPrimitive::open(source).status().code(), StatusCode::kInvalidInput);
  source = source_of(sample);
  source.attributes[0].component_type = static_cast<ComponentType>(5130);  // doubles
  EXPECT_EQ(CompressedPrimitive::open(source).status().code(), StatusCode::kUnsupported);
  source = source_of(sample);
  source.attributes[0].component_count = 0;
  EXPECT_EQ(CompressedPrimitive::open(source).status().code(), StatusCode::kInvalidInput);
}

// The bytes must justify the memory of all attributes together.
TEST(Loader, RefusesAttributesThatAreLargerThanTheBytesJustify) {
  const PatchedSample& sample = samples().front();
  PrimitiveSource source = source_of(sample);
  const CompressedPrimitive primitive = must(CompressedPrimitive::open(source));
  const AttributeRequest matrix{"_MATRIX", 0, ComponentType::kFloat32, 16, false};
  const uint64_t most = justified_result_bytes(source.bytes.size()) / primitive.point_count() / 64;
  ASSERT_LT(most, 1000000u);
  source.attributes.assign(static_cast<size_t>(most / 2), matrix);
  EXPECT_TRUE(CompressedPrimitive::open(source));
  source.attributes.assign(static_cast<size_t>(most + 1), matrix);
  EXPECT_EQ(CompressedPrimitive::open(source).status().code(), StatusCode::kInvalidInput);
}

TEST(Loader, UsesTheBackendThatItIsGiven) {
  const PatchedSample& sample = samples().front();
  const CompressedPrimitive primitive = must(CompressedPrimitive::open(source_of(sample)));
  const Buffers buffers(sample.requests, primitive.point_count(), primitive.face_count());
  DecodeBackend mine = cpu_backend();
  mine.decode_into = [](std::span<const DecodeTask> tasks, const BuffersFor&, const ThreadPool&, const Watch&) {
    return std::vector<Status>(tasks.size(), unsupported("mine"));
  };
  const LoadOptions options{.backend = &mine};
  EXPECT_EQ(primitive.decode(buffers.out, options).message(), "mine");
}

TEST(Loader, NamesThePatchThatIsBroken) {
  const PatchedSample& sample = sample_of_many_patches();
  const PatchContainer container = must(open_container(sample.encoded.pieces[0].bytes));
  // The end of the third patch's stream: opening does not read it.
  std::vector<uint8_t> bytes = sample.encoded.pieces[0].bytes;
  const auto begin = static_cast<size_t>(container.streams[2].data() - sample.encoded.pieces[0].bytes.data());
  const size_t size = container.streams[2].size();
  std::fill_n(bytes.begin() + static_cast<ptrdiff_t>(begin + size / 2), size - size / 2, uint8_t{0xff});
  const CompressedPrimitive primitive = must(CompressedPrimitive::open({bytes, sample.requests}));
  Buffers buffers(sample.requests, primitive.point_count(), primitive.face_count());
  const Status whole = primitive.decode(buffers.out);
  EXPECT_EQ(whole.code(), StatusCode::kInvalidInput);
  EXPECT_EQ(whole.place().patch, 2);
  EXPECT_FALSE(whole.message().empty());
  const Status alone = primitive.decode_patch(2, buffers.out);
  EXPECT_EQ(alone.code(), StatusCode::kInvalidInput);
  EXPECT_EQ(alone.place().patch, 2);
  EXPECT_TRUE(primitive.decode_patch(1, buffers.out).ok());
}

TEST(Loader, TellsHowFarItIsPatchByPatch) {
  const PatchedSample& sample = sample_of_many_patches();
  const CompressedPrimitive primitive = must(CompressedPrimitive::open(source_of(sample)));
  Buffers buffers(sample.requests, primitive.point_count(), primitive.face_count());
  std::atomic<size_t> most = 0, calls = 0;
  LoadOptions options;
  const ThreadPool pool(1);
  options.pool = &pool;
  options.progress = [&](size_t done, size_t total) {
    EXPECT_EQ(total, primitive.patch_count());
    EXPECT_GT(done, most);
    most = done;
    ++calls;
  };
  ASSERT_TRUE(primitive.decode(buffers.out, options).ok());
  EXPECT_EQ(most, primitive.patch_count());
  EXPECT_GT(calls, 1u);
}

TEST(Loader, StopsBetweenPatches) {
  const PatchedSample& sample = sample_of_many_patches();
  const CompressedPrimitive primitive = must(CompressedPrimitive::open(source_of(sample)));
  Buffers buffers(sample.requests, primitive.point_count(), primitive.face_count());
  std::atomic<bool> stop = false;
  size_t last = 0;
  LoadOptions options;
  const ThreadPool pool(1);
  options.pool = &pool;
  options.stop = &stop;
  options.progress = [&](size_t done, size_t) {
    last = done;
    stop = true;
  };
  EXPECT_EQ(primitive.decode(buffers.out, options).code(), StatusCode::kCancelled);
  EXPECT_GT(last, 0u);
  EXPECT_LT(last, primitive.patch_count());
  // Other backends, too, stop before the first task.
  const DecodeBackend draco = draco_backend();
  options.backend = &draco;
  options.progress = [](size_t, size_t) { ADD_FAILURE() << "it decodes"; };
  EXPECT_EQ(primitive.decode(buffers.out, options).code(), StatusCode::kCancelled);
  EXPECT_EQ(primitive.decode_patch(0, buffers.out, options).code(), StatusCode::kCancelled);
}

TEST(Loader, RefusesEveryTruncationWithAMessage) {
  size_t refused = 0;
  for (const PatchedSample& sample : samples()) {
    if (sample.encoded.pieces[0].bytes.size() > 5000) continue;
    for_each_truncation(sample.encoded.pieces[0].bytes, [&](const std::vector<uint8_t>& part) {
      const Status status = CompressedPrimitive::open({part, sample.requests}).status();
      ASSERT_EQ(status.code(), StatusCode::kInvalidInput) << sample.name << ", " << part.size();
      ASSERT_FALSE(status.message().empty());
      ++refused;
    });
  }
  EXPECT_GT(refused, 1000u);
}

// The memory for the tables of a container's head. A table has more than 3 bytes there.
uint64_t most_table_bytes(std::span<const uint8_t> container) {
  const uint64_t head_bytes = container[16] + 256u * container[17];
  return std::min<uint64_t>(head_bytes, container.size()) / 3 * (48 << 10);
}

// Broken bytes decode in the memory that loader.h states, and their counts stay within the limit.
TEST(Loader, TakesNoMoreMemoryForMutantsThanItSays) {
  std::mt19937 random(7);
  size_t opened = 0, decoded = 0;
  for (int i = 0; i < 3000; ++i) {
    const PatchedSample& sample = samples()[random() % samples().size()];
    if (sample.encoded.pieces[0].bytes.size() > 20'000) continue;
    std::vector<uint8_t> bytes = sample.encoded.pieces[0].bytes;
    for (int edits = 1 + static_cast<int>(random() % 3); edits > 0; --edits)
      bytes[random() % (random() % 2 == 0 ? bytes.size() : std::min<size_t>(bytes.size(), 200))] =
          static_cast<uint8_t>(random());
    PrimitiveSource source{bytes, sample.requests};
    const size_t requests_bytes = sample.requests.size() * 2 * (sizeof(AttributeRequest) + 64);
    CountedMemory at_open;
    const Expected<CompressedPrimitive> primitive = CompressedPrimitive::open(std::move(source));
    EXPECT_LE(at_open.most(), 128 * bytes.size() + most_table_bytes(bytes) + requests_bytes + 1024);
    if (!primitive) continue;
    ++opened;
    const uint64_t fixed = uint64_t{1} << 26, limit = fixed + 4096 * bytes.size();
    const uint64_t elements = uint64_t{primitive->face_count()} + primitive->point_count();
    ASSERT_LE(16 * elements, limit);
    if (elements > 1'000'000) continue;
    Buffers buffers(sample.requests, primitive->point_count(), primitive->face_count());
    LoadOptions options;
    const ThreadPool pool(1);
    options.pool = &pool;
    CountedMemory at_decode;
    decoded += primitive->decode(buffers.out, options).ok();
    EXPECT_LE(at_decode.most(), 2 * fixed + limit + 12 * elements + 128 * bytes.size());
  }
  EXPECT_GT(opened, 300u);
  EXPECT_GT(decoded, 50u);
}

TEST(Loader, KeepsScratchUntilItIsReleased) {
  const PatchedSample& sample = sample_of_many_patches();
  const CompressedPrimitive primitive = must(CompressedPrimitive::open(source_of(sample)));
  Buffers buffers(sample.requests, primitive.point_count(), primitive.face_count());
  const ThreadPool pool(1);
  const LoadOptions options{.pool = &pool};
  const auto memory_of_decode = [&] {
    const CountedMemory memory;
    EXPECT_TRUE(primitive.decode(buffers.out, options).ok());
    return memory.most();
  };
  release_scratch();
  const size_t first = memory_of_decode(), again = memory_of_decode();
  EXPECT_LT(again, first / 2);
  release_scratch();
  EXPECT_EQ(memory_of_decode(), first);
}

// The directory that takes most memory for its bytes: equal streams of one byte each, in rows of few bits.
TEST(Loader, DirectoriesTakeTheStatedMultiple) {
  constexpr uint32_t kCount = 100'000;
  std::vector<StreamEntry> entries(kCount, {1, 1, 3, 0, 0});
  const std::vector<std::vector<uint8_t>> stitch(kCount), streams(kCount, std::vector<uint8_t>(1));
  const std::vector<uint8_t> bytes = write_container(entries, false, stitch, streams);
  ASSERT_LT(bytes.size(), 2 * kCount);
  CountedMemory memory;
  const Status status = CompressedPrimitive::open({bytes, {}}).status();
  EXPECT_EQ(status.to_string(), "patch 0: Draco stream: not a Draco mesh");
  EXPECT_GT(memory.most(), 25 * bytes.size());
  EXPECT_LE(memory.most(), 144 * bytes.size());
}

}  // namespace
}  // namespace psplit
