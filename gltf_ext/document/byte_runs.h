// The bytes of a buffer that stay, and their new offsets when the bytes between them are removed.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace psplit {

class ByteRuns {
 public:
  // Bytes move in blocks, so that every element keeps its alignment.
  static constexpr uint64_t kBlock = 8;

  struct Run {
    uint64_t begin, end;  // whole blocks, except at the end of the buffer
    uint64_t packed;      // the new offset of `begin`
  };

  explicit ByteRuns(uint64_t buffer_bytes) : buffer_bytes_(buffer_bytes) {}

  // Ranges may overlap and come in any order.
  void keep(uint64_t begin, uint64_t end) {
    if (begin >= end) return;
    end = std::min((end + kBlock - 1) / kBlock * kBlock, buffer_bytes_);
    runs_.push_back({begin / kBlock * kBlock, end, 0});
  }

  // Call when all ranges are known: sorts, joins and places them.
  void close() {
    std::sort(runs_.begin(), runs_.end(), [](const Run& a, const Run& b) { return a.begin < b.begin; });
    std::vector<Run> joined;
    for (const Run& run : runs_) {
      if (!joined.empty() && run.begin <= joined.back().end)
        joined.back().end = std::max(joined.back().end, run.end);
      else
        joined.push_back(run);
    }
    runs_ = std::move(joined);
    packed_bytes_ = 0;
    for (Run& run : runs_) {
      run.packed = packed_bytes_;
      packed_bytes_ += run.end - run.begin;  // only the last block of the buffer may be shorter
    }
  }

  // The new offset of a byte that stays; 0 for a byte that is removed.
  uint64_t packed(uint64_t offset) const {
    const auto after = std::upper_bound(runs_.begin(), runs_.end(), offset,
                                        [](uint64_t at, const Run& run) { return at < run.begin; });
    if (after == runs_.begin() || offset >= std::prev(after)->end) return 0;
    return std::prev(after)->packed + offset - std::prev(after)->begin;
  }

  const std::vector<Run>& runs() const { return runs_; }
  uint64_t packed_bytes() const { return packed_bytes_; }

 private:
  uint64_t buffer_bytes_, packed_bytes_ = 0;
  std::vector<Run> runs_;
};

}  // namespace psplit
