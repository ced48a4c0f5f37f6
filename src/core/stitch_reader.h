// The reader of one stream's part of a stitch map. Specification: "stitch map"
// (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include "src/core/byte_reader.h"
#include "src/core/stitch_codes.h"
#include "src/core/view.h"

namespace psplit::core {

// What the directory of a container says about one stream.
struct StitchRow {
  View<const uint8_t> bytes;  // its part of the stitch map
  uint32_t stream = 0;        // its place in the container
  uint32_t point_count = 0, reference_count = 0;
  uint32_t owned_base = 0;       // the mesh's number of the first point that the stream owns
  uint32_t first_reference = 0;  // the temporary number of its first reference
};

// Reads a part from front to back: all runs, then all pairs, repeats first. A part that contradicts itself or
// the row's number of references is broken. The caller checks whether points, places and ranks exist.
class StitchReader {
 public:
  // The `length` points from place `begin` of this stream's walk are the points from place `start` of stream
  // `owner`'s walk, where places count up (forward) or down.
  struct Run {
    uint64_t begin = 0;
    uint32_t length = 0, owner = 0, start = 0;
    bool forward = false;

    PSPLIT_HD uint32_t place(uint32_t k) const { return forward ? start + k : start - k; }
  };
  // Decoded point `point` is the target-th point that stream `owner` owns. A repeat is the same as decoded
  // point `target` of its own stream, which comes earlier.
  struct Pair {
    uint64_t point = 0;
    uint32_t owner = 0, target = 0;
    bool is_repeat = false;
  };

  PSPLIT_HD explicit StitchReader(const StitchRow& row)
      : stream_(row.stream),
        bits_(row.bytes.data(), row.bytes.size()),
        byte_count_(row.bytes.size()),
        kinds_(row.point_count, row.reference_count),
        left_(row.reference_count) {
    if (row.bytes.empty()) {
      left_ = 0;
      return;
    }
    runs_left_ = number(kinds_.count);
    broken_ |= runs_left_ > left_;  // each has at least one reference
    if (runs_left_ == 0) begin_pairs();
  }

  // Returns false after the last run, and if the part is broken.
  PSPLIT_HD bool next_run(Run& run) {
    if (broken_ || runs_left_ == 0) return false;
    --runs_left_;
    run = take_run();
    next_ = run.begin + run.length;
    broken_ |= run.owner > stream_ || (run.forward ? uint64_t{run.start} + run.length > 0xffffffffu
                                                   : uint64_t{run.start} + 1 < run.length);
    if (runs_left_ == 0) begin_pairs();
    return !broken_;
  }
  // As above, for pairs. To be called after the last run.
  PSPLIT_HD bool next_pair(Pair& pair) {
    if (broken_ || left_ == 0) return false;
    pair = take_pair();
    broken_ |= pair.owner > stream_;
    return !broken_;
  }
  PSPLIT_HD bool broken() const { return broken_; }

 private:
  // If `back` leads before the first stream, returns a number after this stream's, which the callers refuse.
  PSPLIT_HD uint32_t owner(uint64_t back) const {
    return back > stream_ ? 0xffffffffu : stream_ - static_cast<uint32_t>(back);
  }
  PSPLIT_HD void begin_pairs() {
    next_ = 0;
    if (broken_) return;
    // The first stream can refer to no other stream, so all its pairs are repeats.
    const uint32_t pair_count = left_ == 0 || stream_ == 0 ? 0 : number(kinds_.count);
    broken_ |= pair_count > left_;
    if (broken_) return;
    repeats_left_ = left_ - pair_count;
    distances_differ_ = repeats_left_ > 0 && bit();
    if (left_ == 0) end_bits();
  }

  PSPLIT_HD bool bit() { return bits_.read(1) != 0; }
  PSPLIT_HD uint32_t number(NumberKind& kind) {
    uint32_t value;
    broken_ |= !read_number(bits_, kind, value) || bits_.bytes_taken() > byte_count_;
    return value;
  }
  PSPLIT_HD uint32_t checked(int64_t value) {
    broken_ |= value < 0 || value > 0xffffffff;
    return static_cast<uint32_t>(value);
  }
  // The unused bits of the last byte are 0.
  PSPLIT_HD void end_bits() {
    const int rest = static_cast<int>(bits_.bytes_taken() * 8 - bits_.bits_taken());
    broken_ |= bits_.bytes_taken() != byte_count_ || bits_.read(rest) != 0;
  }
  PSPLIT_HD Run take_run() {
    Run run;
    const uint32_t skip = number(kinds_.walk_skip), more = number(kinds_.length);
    broken_ |= more >= left_;
    if (broken_) return run;
    run.begin = next_ + skip;
    run.length = more + 1;
    left_ -= run.length;
    run.forward = more > 0 && bit();
    if (last_owner_ == kNoStream || bit()) {
      run.owner = owner(number(kinds_.back));
      run.start = number(kinds_.place);
    } else {
      run.owner = last_owner_;
      run.start = checked(expected_start_.start(skip, unfold(number(kinds_.start_step))));
    }
    last_owner_ = runs_left_ == 0 ? kNoStream : run.owner;
    expected_start_ = ExpectedStart(run.start, run.length, run.forward);
    return run;
  }
  PSPLIT_HD Pair take_pair() {
    Pair pair;
    pair.point = next_ + number(kinds_.point_skip);
    next_ = pair.point + 1;
    if (repeats_left_ > 0) {
      take_repeat(pair);
      if (--repeats_left_ == 0) next_ = 0;
    } else if (last_owner_ == kNoStream || bit()) {
      pair.owner = last_owner_ = owner(uint64_t{number(kinds_.back)} + 1);
      pair.target = number(kinds_.place);
      expected_rank_.begin(pair.target);
    } else {
      pair.owner = last_owner_;
      pair.target = checked(expected_rank_.rank(unfold(number(kinds_.rank_step))));
      expected_rank_.follow(pair.target);
    }
    if (--left_ == 0) end_bits();
    return pair;
  }
  PSPLIT_HD void take_repeat(Pair& pair) {
    const uint32_t coded = number(kinds_.distance);
    distance_ = distances_differ_ ? checked(distance_ + unfold(coded)) : coded;
    broken_ |= distance_ >= pair.point;
    pair.owner = stream_;
    pair.target = static_cast<uint32_t>(pair.point - 1 - distance_);
    pair.is_repeat = true;
  }

  static constexpr uint32_t kNoStream = 0xffffffffu;

  bool broken_ = false;
  uint32_t stream_ = 0, runs_left_ = 0;
  uint64_t next_ = 0;  // the lowest possible place or point

  BitReader bits_;
  uint64_t byte_count_ = 0;
  StitchKinds kinds_;
  uint32_t left_ = 0, repeats_left_ = 0;  // counts of references
  uint32_t last_owner_ = kNoStream;
  ExpectedStart expected_start_;
  ExpectedRank expected_rank_;
  bool distances_differ_ = false;  // each distance is coded as a difference
  uint32_t distance_ = 0;
};

}  // namespace psplit::core
