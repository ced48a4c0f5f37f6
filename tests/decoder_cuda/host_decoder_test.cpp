// A whole decoder of a device except for the device: results in the host's memory, on the emulated warp,
// against libdraco.
#include "decoder_cuda/host_decoder.h"

#include <cstring>
#include <numeric>

#include "psplit/decode.h"
#include "psplit/encode.h"
#include "psplit/loader.h"
#include "tests/decoder_cuda/device_samples.h"
#include "tests/decoder_cuda/mutants.h"
#include "tests/src/loader/buffers.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/patched_samples.h"
#include "tests/support/same_bits.h"

namespace psplit {
namespace {

DecodeBackend backend_of(HostDecoder<EmulatedDevice>& decoder) {
  return {"emulated",
          [&](std::span<const DecodeTask> tasks, const BuffersFor& buffers_for, const ThreadPool& pool,
              const Watch& watch) { return decoder.decode_into(tasks, buffers_for, pool, watch); }};
}

Expected<Mesh> decode(HostDecoder<EmulatedDevice>& decoder, std::span<const uint8_t> container,
                      std::span<const AttributeRequest> requests) {
  return decode_container(backend_of(decoder), container, requests, ThreadPool(1));
}

std::vector<Expected<Mesh>> decode(HostDecoder<EmulatedDevice>& decoder, std::span<const DecodeTask> tasks,
                                   const Progress& progress = {}) {
  return backend_of(decoder).decode(tasks, ThreadPool(1), progress);
}

TEST(HostDecoder, EqualsLibdracoInEveryOrderOfThreadsAndLanes) {
  const ThreadPool pool(2);
  std::vector<HostDecoder<EmulatedDevice>> decoders;
  for (const LaneOrder& order : kLaneOrders) decoders.emplace_back(EmulatedDevice(order));
  size_t count = 0;
  for (const std::vector<PatchedSample>* samples : {&all_samples(pool), &large_samples(pool)})
    for (const PatchedSample& sample : *samples) {
      SCOPED_TRACE(sample.name);
      const Mesh decoded =
          must(decode(decoders[count++ % decoders.size()], sample.encoded.pieces[0].bytes, sample.requests));
      EXPECT_TRUE(same_bits(decoded, sample.mesh));
    }
}

// Each knows the values at its border, if patches share them.
TEST(HostDecoder, DecodesCondensedPatchesAlone) {
  const ThreadPool pool(2);
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  size_t with_borders = 0;
  for (const CondensedSample& sample : condensed_samples(pool)) {
    SCOPED_TRACE(sample.original.name);
    const PatchContainer container = opened(sample.container);
    const std::vector<AttributeRequest>& requests = sample.original.requests;
    for (uint32_t i = 0; i < std::min<size_t>(container.entries.size(), 3); ++i) {
      const PatchContainer alone = container.alone(i);
      with_borders += alone.borders != nullptr;
      const Mesh expected = must(
          draco_backend().decode(opened(sample.original.encoded.pieces[0].bytes).alone(i), requests, pool));
      const Mesh decoded = must(backend_of(decoder).decode(alone, requests, pool));
      EXPECT_TRUE(same_bits(decoded, expected));
    }
  }
  EXPECT_GT(with_borders, 10u);
}

// Limits for results and for all other memory, down to one patch at a time. Without a limit all is one batch.
TEST(HostDecoder, DecodesInPartsWhereMemoryIsShort) {
  const ThreadPool pool(2);
  const std::vector<PatchedSample>& samples = all_samples(pool);
  std::vector<PatchContainer> containers;
  for (const PatchedSample& sample : samples) containers.push_back(opened(sample.encoded.pieces[0].bytes));
  std::vector<DecodeTask> tasks;
  for (size_t i = 0; i < samples.size(); ++i) tasks.push_back({&containers[i], samples[i].requests});
  for (const uint64_t limit : {uint64_t{0}, uint64_t{1}, uint64_t{400'000}, uint64_t{4'000'000}}) {
    HostDecoder<EmulatedDevice> decoder{EmulatedDevice({LaneOrder::kDescending}), limit};
    size_t last = 0;
    const std::vector<Expected<Mesh>> decoded = decode(decoder, tasks, [&](size_t done, size_t total) {
      EXPECT_EQ(total, tasks.size());
      EXPECT_GT(done, last);
      last = done;
    });
    EXPECT_EQ(last, tasks.size());
    for (size_t i = 0; i < samples.size(); ++i) {
      ASSERT_TRUE(decoded[i]) << samples[i].name << ": " << decoded[i].status().to_string();
      EXPECT_TRUE(same_bits(*decoded[i], samples[i].mesh)) << samples[i].name;
    }
  }
}

// A mesh decodes in a quarter of the memory that it takes at once.
TEST(HostDecoder, TakesNoMoreMemoryThanItMay) {
  const ThreadPool pool(2);
  const PatchedSample sample = grid_sample(100, 40, 0, pool);
  const std::vector<uint8_t>& container = sample.encoded.pieces[0].bytes;
  const size_t before = EmulatedDevice::bytes_in_use();
  size_t whole = 0;
  {
    HostDecoder<EmulatedDevice> decoder{EmulatedDevice()};
    const Expected<Mesh> decoded = decode(decoder, container, sample.requests);
    ASSERT_TRUE(decoded && same_bits(*decoded, sample.mesh));
    whole = EmulatedDevice::bytes_in_use() - before;
  }
  // It takes no more than the limit, and no more than is free.
  const size_t limit = whole / 4;
  const ShortMemory memory(before + limit);
  for (const size_t told : {limit, whole}) {
    HostDecoder<EmulatedDevice> decoder{EmulatedDevice(), told};
    const Expected<Mesh> decoded = decode(decoder, container, sample.requests);
    EXPECT_TRUE(decoded && same_bits(*decoded, sample.mesh)) << decoded.status().to_string();
  }
}

// The limit holds whatever was decoded before: many small meshes use their memory in other ways than a window
// of a large mesh.
TEST(HostDecoder, StaysWithinItsMemoryFromBatchToBatch) {
  const ThreadPool pool(2);
  const PatchedSample small = grid_sample(1, 1, 0, pool), large = grid_sample(200, 100, 3, pool);
  constexpr size_t kCount = 1500, kLimit = 2'000'000;
  const PatchContainer small_container = opened(small.encoded.pieces[0].bytes),
                       large_container = opened(large.encoded.pieces[0].bytes);
  std::vector<DecodeTask> tasks(2 * kCount + 1, {&small_container, small.requests});
  tasks[kCount] = {&large_container, large.requests};
  const size_t before = EmulatedDevice::bytes_in_use();
  EmulatedDevice::most_bytes_in_use() = before;
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice(), kLimit};
  const std::vector<Expected<Mesh>> decoded = decode(decoder, tasks);
  for (const Expected<Mesh>& mesh : decoded) ASSERT_TRUE(mesh) << mesh.status().to_string();
  EXPECT_TRUE(same_bits(*decoded[kCount], large.mesh));
  EXPECT_LE(EmulatedDevice::most_bytes_in_use(), before + kLimit);
}

TEST(HostDecoder, UploadsLargeMeshesOnce) {
  const ThreadPool pool(2);
  const PatchedSample sample = grid_sample(100, 40, 0, pool);
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice(), 200'000};
  EmulatedDevice::work() = {};
  ASSERT_TRUE(decode(decoder, sample.encoded.pieces[0].bytes, sample.requests));
  // The tables of each window, and the patches that it refers to, are uploaded beside the container.
  EXPECT_LT(EmulatedDevice::work().uploaded_bytes, 3 * sample.encoded.pieces[0].bytes.size());
}

TEST(HostDecoder, DownloadsManyResultsAtOnce) {
  const ThreadPool pool(2);
  const PatchedSample sample = grid_sample(4, 1, 2, pool);
  const PatchContainer container = opened(sample.encoded.pieces[0].bytes);
  const std::vector<DecodeTask> tasks(100, {&container, sample.requests});
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  EmulatedDevice::work() = {};
  for (const Expected<Mesh>& mesh : decode(decoder, tasks)) EXPECT_TRUE(mesh && same_bits(*mesh, sample.mesh));
  EXPECT_LE(EmulatedDevice::work().downloads, 4u);
}

// Other programs took memory meanwhile. Tasks that still fit are decoded.
TEST(HostDecoder, AShortageEndsOneTask) {
  const ThreadPool pool(2);
  const PatchedSample small = grid_sample(10, 1, 0, pool), large = grid_sample(100, 1, 0, pool);
  const PatchContainer small_container = opened(small.encoded.pieces[0].bytes),
                       large_container = opened(large.encoded.pieces[0].bytes);
  const std::vector<DecodeTask> tasks{{&small_container, small.requests},
                                      {&large_container, large.requests},
                                      {&small_container, small.requests}};
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  const ShortMemory memory(EmulatedDevice::bytes_in_use() + 150'000);
  const std::vector<Expected<Mesh>> decoded = decode(decoder, tasks);
  EXPECT_TRUE(decoded[0]) << decoded[0].status().to_string();
  EXPECT_EQ(decoded[1].status().code(), StatusCode::kRuntimeFailure);
  EXPECT_TRUE(decoded[2]) << decoded[2].status().to_string();
}

// The number of launches does not grow with the attributes of one stream. Its last launch does the rest.
TEST(HostDecoder, LaunchesNoMoreThanMostStreamsNeed) {
  const ThreadPool pool(2);
  const PatchedSample sample = grid_sample(10, 2, 50, pool);
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  EmulatedDevice::work() = {};
  const Mesh decoded = must(decode(decoder, sample.encoded.pieces[0].bytes, sample.requests));
  EXPECT_TRUE(same_bits(decoded, sample.mesh));
  EXPECT_LE(EmulatedDevice::work().most_items, 2 * LaunchPlan::kMostRuns);
  EXPECT_LE(EmulatedDevice::work().launches, 6 + 2 * LaunchPlan::kMostRounds);
}

// All streams of all meshes in one call, as stock streams: their numbers of points are not known.
TEST(HostDecoder, TakesStockStreams) {
  const ThreadPool pool(2);
  const std::vector<PatchedSample>& samples = patched_samples(pool);
  std::vector<PatchContainer> streams;
  std::vector<std::span<const AttributeRequest>> requests;
  for (const PatchedSample& sample : samples)
    for (const std::span<const uint8_t> stream : opened(sample.encoded.pieces[0].bytes).streams) {
      streams.push_back(open_stream(stream));
      requests.push_back(sample.requests);
    }
  std::vector<DecodeTask> tasks;
  for (size_t i = 0; i < streams.size(); ++i) tasks.push_back({&streams[i], requests[i]});
  for (const uint64_t limit : {uint64_t{0}, uint64_t{1'000'000}}) {
    HostDecoder<EmulatedDevice> decoder{EmulatedDevice(), limit};
    const std::vector<Expected<Mesh>> decoded = decode(decoder, tasks);
    for (size_t i = 0; i < tasks.size(); ++i) {
      const Expected<Mesh> expected = decode_stream(draco_backend(), streams[i].bytes, requests[i]);
      ASSERT_TRUE(expected && decoded[i]) << decoded[i].status().to_string();
      EXPECT_TRUE(same_bits(*decoded[i], *expected));
    }
  }
}

// Attributes that are not requested take memory as well.
TEST(HostDecoder, DecodesSomeAttributesOnly) {
  const ThreadPool pool(2);
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  size_t count = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    if (sample.requests.size() < 2) continue;
    SCOPED_TRACE(sample.name);
    ++count;
    const std::vector<AttributeRequest> first{sample.requests.front()};
    Mesh expected = sample.mesh;
    expected.attributes.resize(1);
    EXPECT_TRUE(same_bits(must(decode(decoder, sample.encoded.pieces[0].bytes, first)), expected));
  }
  EXPECT_GT(count, 10u);
}

TEST(HostDecoder, TakesAndRefusesMutantsAsTheCpuDoes) {
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice({LaneOrder::kShuffled, 4})};
  expect_mutants_as_on_cpu([&](std::span<const uint8_t> bytes, std::span<const AttributeRequest> requests) {
    return decode(decoder, bytes, requests);
  });
}

// Indices of two bytes and values with gaps between them, also in windows.
TEST(HostDecoder, WritesToBuffersOfTheCaller) {
  const ThreadPool pool(2);
  size_t count = 0;
  for (const uint64_t limit : {uint64_t{0}, uint64_t{400'000}}) {
    HostDecoder<EmulatedDevice> decoder{EmulatedDevice(), limit};
    const DecodeBackend backend = backend_of(decoder);
    for (const PatchedSample& sample : patched_samples(pool)) {
      SCOPED_TRACE(sample.name);
      const auto primitive = must(CompressedPrimitive::open({sample.encoded.pieces[0].bytes, sample.requests}));
      ++count;
      Buffers buffers(sample.requests, sample.mesh.point_count, primitive.face_count(), 2, 3);
      const LoadOptions options{.backend = &backend};
      must(primitive.decode(buffers.out, options));
      EXPECT_TRUE(same_bits(buffers.mesh(sample.requests, sample.mesh.point_count), sample.mesh));
    }
  }
  EXPECT_GT(count, 50u);
}

// Several threads empty a buffer. Their parts begin and end within values.
TEST(Downloader, CopiesValuesOfAllSizesOnManyThreads) {
  const ThreadPool pool(3);
  EmulatedDevice device;
  EmulatedDevice::Array<uint8_t> values;
  constexpr size_t kCount = 60'001;
  struct Case {
    size_t value_bytes, kept_bytes, stride;
  };
  constexpr Case kCases[]{{4, 2, 2}, {12, 12, 12}, {12, 12, 20}, {3, 3, 7}, {8, 8, 9}};
  size_t bytes = 0;
  for (const Case& each : kCases) bytes += each.value_bytes * kCount;
  ASSERT_TRUE(values.reserve(bytes).ok());
  for (size_t i = 0; i < bytes; ++i) values.data()[i] = static_cast<uint8_t>(i * 2654435761u >> 16);
  std::vector<std::vector<std::byte>> results;
  std::vector<DownloadedRange> ranges;
  const uint8_t* from = values.data();
  for (const Case& each : kCases) {
    results.emplace_back(each.stride * kCount, std::byte{0x5a});
    ranges.push_back({from, each.value_bytes * kCount, results.back().data(), each.value_bytes, each.kept_bytes,
                      each.stride});
    from += each.value_bytes * kCount;
  }
  Downloader<EmulatedDevice> downloader;
  ASSERT_TRUE(downloader.download(device, ranges, pool).ok());
  for (size_t n = 0; n < ranges.size(); ++n) {
    const DownloadedRange& range = ranges[n];
    std::vector<std::byte> expected(results[n].size(), std::byte{0x5a});
    for (size_t i = 0; i < kCount; ++i)
      std::memcpy(&expected[i * range.stride], range.from + i * range.value_bytes, range.kept_bytes);
    EXPECT_EQ(results[n], expected) << n;
  }
}

// A device that copies as late as it may.
class LateDevice {
 public:
  template <typename T>
  using HostArray = EmulatedDevice::HostArray<T>;

  Status upload(uint8_t* to, const uint8_t* from, size_t count) {
    copies_.push_back({to, from, count});
    return {};
  }
  Status wait() {
    for (const Copy& copy : std::exchange(copies_, {})) std::memcpy(copy.to, copy.from, copy.count);
    return {};
  }

 private:
  struct Copy {
    uint8_t* to;
    const uint8_t* from;
    size_t count;
  };
  std::vector<Copy> copies_;
};

// A buffer may be filled again only when its bytes have arrived, whatever came before.
TEST(Uploader, CopiesArraysOfAllSizesOneAfterTheOther) {
  const ThreadPool pool(3);
  constexpr size_t kBuffer = Uploader<LateDevice>::kBytesOfBuffer;
  LateDevice device;
  Uploader<LateDevice> uploader;
  std::vector<std::vector<uint8_t>> sources, results;
  for (const size_t bytes : {kBuffer + 1, size_t{0}, size_t{1}, kBuffer, 3 * kBuffer - 1, size_t{7}}) {
    sources.emplace_back(bytes);
    results.emplace_back(bytes);
    for (size_t i = 0; i < bytes; ++i)
      sources.back()[i] = static_cast<uint8_t>((i + sources.size()) * 2654435761u >> 16);
  }
  for (size_t n = 0; n < sources.size(); ++n) {
    std::vector<uint8_t> callers = sources[n];  // they may go when the call returns
    ASSERT_TRUE(uploader.upload(device, results[n].data(), callers, n % 2 == 0 ? &pool : nullptr).ok());
  }
  ASSERT_TRUE(device.wait().ok());
  for (size_t n = 0; n < sources.size(); ++n) EXPECT_TRUE(results[n] == sources[n]) << n;
}

TEST(HostDecoder, StopsBeforeTheNextBatch) {
  const ThreadPool pool(1);
  const PatchedSample sample = grid_sample(20, 4, 0, pool);
  const PatchContainer container = opened(sample.encoded.pieces[0].bytes);
  const std::vector<DecodeTask> tasks(3, {&container, sample.requests});
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice(), 1};  // a batch for each patch
  std::atomic<bool> stop = false;
  std::vector<Mesh> meshes(tasks.size());
  const auto buffers_for = [&](size_t i, uint32_t points, uint32_t faces) {
    stop = i == 1;  // when the first patch of the second task has arrived
    return allocate_mesh(points, faces, sample.requests, container.bytes.size(), meshes[i]);
  };
  const std::vector<Status> statuses = decoder.decode_into(tasks, buffers_for, pool, {{}, &stop});
  EXPECT_TRUE(statuses[0].ok());
  EXPECT_EQ(statuses[1].code(), StatusCode::kCancelled);
  EXPECT_EQ(statuses[2].code(), StatusCode::kCancelled);
}

// A refused stream ends one task, and so does an error of the caller.
TEST(HostDecoder, ErrorsEndOneTask) {
  const ThreadPool pool(1);
  const PatchedSample sample = grid_sample(20, 1, 0, pool);
  const PatchContainer container = opened(sample.encoded.pieces[0].bytes);
  std::vector<uint8_t> old_bytes(container.streams[0].begin(), container.streams[0].end());
  old_bytes[6] = 1;
  const PatchContainer old = open_stream(old_bytes);
  const std::vector<DecodeTask> tasks{
      {&container, sample.requests}, {&old, sample.requests}, {&container, sample.requests}};
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  std::vector<Mesh> meshes(tasks.size());
  const auto buffers_for = [&](size_t i, uint32_t points, uint32_t faces) -> Expected<PrimitiveBuffers> {
    if (i == 0) return invalid_input("no room");
    return allocate_mesh(points, faces, sample.requests, container.bytes.size(), meshes[i]);
  };
  const std::vector<Status> statuses = decoder.decode_into(tasks, buffers_for, pool, {});
  EXPECT_EQ(statuses[0].message(), "no room");
  EXPECT_EQ(statuses[1].code(), StatusCode::kUnsupported);
  EXPECT_TRUE(statuses[2].ok()) << statuses[2].to_string();
}

// One thread takes the steps of a stream, so a large one would take too long.
TEST(HostDecoder, RefusesStreamsOfTooManyFaces) {
  const ThreadPool pool(1);
  const PatchedSample small = grid_sample(10, 2, 0, pool), large = grid_sample(40, 2, 0, pool);
  const PatchContainer small_container = opened(small.encoded.pieces[0].bytes),
                       large_container = opened(large.encoded.pieces[0].bytes);
  uint32_t most = 0;
  for (const core::StreamHeader& header : small_container.headers)
    most = std::max(most, header.counts.face_count);
  ASSERT_LT(most, large_container.headers[0].counts.face_count);
  const std::vector<DecodeTask> tasks{{&large_container, large.requests}, {&small_container, small.requests}};
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice(), 0, most};
  const std::vector<Expected<Mesh>> decoded = decode(decoder, tasks);
  EXPECT_EQ(decoded[0].status().code(), StatusCode::kUnsupported);
  EXPECT_EQ(decoded[0].status().place().patch, 0);
  EXPECT_TRUE(decoded[1]) << decoded[1].status().to_string();
}

// Chunks may end within a value.
TEST(DownloadedRange, HandsOutValuesInAnyParts) {
  std::vector<uint8_t> values(60);
  std::iota(values.begin(), values.end(), uint8_t{1});
  struct Form {
    size_t value_bytes, kept_bytes, stride;
  };
  for (const auto [value_bytes, kept_bytes, stride] : {Form{12, 12, 12}, {12, 12, 15}, {4, 2, 2}, {4, 4, 4}})
    for (size_t first = 0; first <= values.size(); ++first)
      for (size_t second = first; second <= values.size(); second += 7) {
        std::vector<std::byte> to(values.size() / value_bytes * stride, std::byte{0xa5});
        const DownloadedRange range{values.data(), values.size(), to.data(), value_bytes, kept_bytes, stride};
        range.hand_out(0, first, values.data());
        range.hand_out(first, second, values.data() + first);
        range.hand_out(second, values.size(), values.data() + second);
        for (size_t at = 0; at < to.size(); ++at) {
          const size_t within = at % stride, from = at / stride * value_bytes + within;
          ASSERT_EQ(to[at], within < kept_bytes ? std::byte{values[from]} : std::byte{0xa5});
        }
      }
}

}  // namespace
}  // namespace psplit
