// Many results at once from a device to memory of the host that is not pinned.
#pragma once

#include <algorithm>
#include <cstring>
#include <span>
#include <vector>

#include "src/status.h"

namespace psplit {

struct DownloadedRange {
  const uint8_t* from = nullptr;
  size_t bytes = 0;
  void* to = nullptr;
};

// By way of two pieces of pinned memory, which it keeps: the device fills one while the host empties the other.
template <typename Device>
class Downloader {
 public:
  // Ranges of one array, in its order; done when it returns. What lies between two of them may be copied too.
  Status download(Device& device, std::span<const DownloadedRange> ranges) {
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
      if (status.ok()) hand_out(chunks[n], buffers_[n % 2].data(), ranges);
    }
    if (!status.ok()) (void)device.wait();
    return status;
  }

 private:
  // What is copied at once.
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
      const uint8_t* const to = std::min(chunk.end, range->from + range->bytes);
      if (from < to)
        std::memcpy(static_cast<uint8_t*>(range->to) + (from - range->from), bytes + (from - chunk.begin),
                    static_cast<size_t>(to - from));
    }
  }

  typename Device::template HostArray<uint8_t> buffers_[2];
};

}  // namespace psplit
