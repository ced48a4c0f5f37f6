// Copies between a device and memory of the host that is not pinned, through buffers that are: the device works
// on one of two buffers while threads of the host work on the other.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "psplit/base.h"
#include "psplit/parallel.h"

namespace psplit {

// Values that are packed on the device, and where they go on the host: the first `kept_bytes` of each value,
// `stride` bytes from one to the next. Fewer kept bytes make 16-bit indices of 32-bit ones: both sides are
// little-endian.
struct DownloadedRange {
  const uint8_t* from = nullptr;
  size_t bytes = 0;
  std::byte* to = nullptr;
  size_t value_bytes = 0, kept_bytes = 0, stride = 0;

  // Hands out bytes [first, end) of the range, which are at `bytes`.
  void hand_out(size_t first, size_t end, const uint8_t* source) const {
    if (kept_bytes == value_bytes && stride == value_bytes) {
      std::memcpy(to + first, source, end - first);
      return;
    }
    // A chunk may begin and end within a value.
    const size_t whole_first = std::min((first + value_bytes - 1) / value_bytes * value_bytes, end);
    const size_t whole_end = std::max(end / value_bytes * value_bytes, whole_first);
    hand_out_part(first, whole_first, source);
    const uint8_t* const values = source + (whole_first - first);
    const size_t value = whole_first / value_bytes, count = (whole_end - whole_first) / value_bytes;
    switch (kept_bytes) {
      case 2: copy_values<2>(value, count, values); break;
      case 4: copy_values<4>(value, count, values); break;
      case 8: copy_values<8>(value, count, values); break;
      case 12: copy_values<12>(value, count, values); break;
      default: copy_values<0>(value, count, values); break;
    }
    hand_out_part(whole_end, end, source + (whole_end - first));
  }

 private:
  // Bytes [first, end), all of one value.
  void hand_out_part(size_t first, size_t end, const uint8_t* source) const {
    const size_t value = first / value_bytes, within = first % value_bytes;
    if (first < end && within < kept_bytes)
      std::memcpy(to + value * stride + within, source, std::min(end - first, kept_bytes - within));
  }

  // `count` whole values. kKept is kept_bytes, for copies that need no call, or 0 for any number.
  template <size_t kKept>
  void copy_values(size_t value, size_t count, const uint8_t* source) const {
    std::byte* out = to + value * stride;
    for (; count > 0; --count, out += stride, source += value_bytes)
      std::memcpy(out, source, kKept > 0 ? kKept : kept_bytes);
  }
};

// Copies by the threads of `pool`, unless it is null.
inline void copy_bytes(std::span<const uint8_t> from, uint8_t* to, const ThreadPool* pool) {
  constexpr size_t kBytesOfTask = size_t{1} << 18;
  const auto copy_range = [&](size_t begin, size_t end) {
    if (begin < end) std::memcpy(to + begin, from.data() + begin, end - begin);
  };
  if (pool != nullptr)
    pool->for_ranges(from.size(), kBytesOfTask, copy_range);
  else
    copy_range(0, from.size());
}

// Uploads large arrays. Keeps its buffers.
template <typename Device>
class Uploader {
 public:
  static constexpr size_t kBytesOfBuffer = size_t{4} << 20;

  // The threads of `pool` fill the buffers, unless it is null. When this returns, the last bytes may be on
  // their way still, but `bytes` may change.
  Status upload(Device& device, uint8_t* to, std::span<const uint8_t> bytes, const ThreadPool* pool) {
    Status status;
    for (auto& buffer : buffers_)
      if (status.ok()) status = buffer.reserve(kBytesOfBuffer);
    for (size_t at = 0; at < bytes.size() && status.ok(); at += kBytesOfBuffer) {
      const std::span<const uint8_t> part = bytes.subspan(at, std::min(kBytesOfBuffer, bytes.size() - at));
      // At most the other buffer is on its way.
      uint8_t* const buffer = buffers_[next_].data();
      next_ = 1 - next_;
      copy_bytes(part, buffer, pool);
      status = device.wait();
      if (status.ok()) status = device.upload(to + at, buffer, part.size());
    }
    return status;
  }

 private:
  typename Device::template HostArray<uint8_t> buffers_[2];
  size_t next_ = 0;  // the buffer to fill
};

// Downloads many results at once. Keeps its buffers.
template <typename Device>
class Downloader {
 public:
  // The ranges belong to one array and are in its order. The data has arrived when this returns. Bytes between
  // two ranges may be copied to the buffers as well. The threads of `pool` empty the buffers.
  Status download(Device& device, std::span<const DownloadedRange> ranges, const ThreadPool& pool) {
    const std::vector<Chunk> chunks = chunks_of(ranges);
    size_t largest = 0;
    for (const Chunk& chunk : chunks) largest = std::max(largest, chunk.size());
    for (size_t n = 0; n < std::min<size_t>(2, chunks.size()); ++n)
      if (Status status = buffers_[n].reserve(largest); !status.ok()) return status;
    const auto ask = [&](size_t n) {
      return n < chunks.size() ? device.download(buffers_[n % 2].data(), chunks[n].begin, chunks[n].size())
                               : Status();
    };
    Status status = ask(0);
    for (size_t n = 0; n < chunks.size() && status.ok(); ++n) {
      status = device.wait();
      if (status.ok()) status = ask(n + 1);
      if (!status.ok()) break;
      const uint8_t* const bytes = buffers_[n % 2].data();
      pool.for_ranges(chunks[n].size(), kBytesOfTask, [&](size_t begin, size_t end) {
        hand_out({chunks[n].begin + begin, chunks[n].begin + end}, bytes + begin, ranges);
      });
    }
    if (!status.ok()) (void)device.wait();
    return status;
  }

 private:
  static constexpr size_t kBytesOfTask = size_t{1} << 18;

  // Bytes of the device that are copied at once.
  struct Chunk {
    const uint8_t *begin = nullptr, *end = nullptr;
    size_t size() const { return static_cast<size_t>(end - begin); }
  };

  static std::vector<Chunk> chunks_of(std::span<const DownloadedRange> ranges) {
    constexpr ptrdiff_t kLargest = 16 << 20, kWidestGap = 64 << 10;
    std::vector<Chunk> chunks;
    for (const DownloadedRange& range : ranges) {
      const uint8_t* const end = range.from + range.bytes;
      for (const uint8_t* at = range.from; at < end; at = chunks.back().end) {
        if (chunks.empty() || at - chunks.back().end > kWidestGap || at - chunks.back().begin >= kLargest)
          chunks.push_back({at, at});
        chunks.back().end = std::min(end, chunks.back().begin + kLargest);
      }
    }
    return chunks;
  }

  static void hand_out(const Chunk& chunk, const uint8_t* bytes, std::span<const DownloadedRange> ranges) {
    auto range = std::partition_point(ranges.begin(), ranges.end(), [&](const DownloadedRange& each) {
      return each.from + each.bytes <= chunk.begin;
    });
    for (; range != ranges.end() && range->from < chunk.end; ++range) {
      const uint8_t* const from = std::max(chunk.begin, range->from);
      const uint8_t* const end = std::min(chunk.end, range->from + range->bytes);
      if (from < end)
        range->hand_out(static_cast<size_t>(from - range->from), static_cast<size_t>(end - range->from),
                        bytes + (from - chunk.begin));
    }
  }

  typename Device::template HostArray<uint8_t> buffers_[2];
};

}  // namespace psplit
