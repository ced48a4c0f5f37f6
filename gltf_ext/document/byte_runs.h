// Which bytes of a buffer stay, and where they stand once those between them are gone.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace psplit {

class ByteRuns {
 public:
  // Bytes move in blocks, so that every element stays as aligned as it was.
  static constexpr uint64_t kBlock = 8;

  struct Run {
    uint64_t begin, end;  // whole blocks, but for the end of the buffer
    uint64_t packed;      // where `begin` comes to stand
  };

  explicit ByteRuns(uint64_t buffer_bytes) : buffer_bytes_(buffer_bytes) {}

  // In any order; ranges may overlap.
  void keep(uint64_t begin, uint64_t end) {
    if (begin >= end) return;
    end = std::min((end + kBlock - 1) / kBlock * kBlock, buffer_bytes_);
    runs_.push_back({begin / kBlock * kBlock, end, 0});
  }

  // Once all ranges are known: sorted, joined, and placed.
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
      packed_bytes_ += run.end - run.begin;  // only the very last block is shorter
    }
  }

  // Where a byte that stays comes to stand; 0 for one that goes.
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
