// What a stream stores about the prediction of an attribute, besides the corrections.
#pragma once

#include "src/core/in_step.h"
#include "src/core/octahedral.h"
#include "src/core/rans.h"
#include "src/core/wrap.h"

namespace psplit::core {

// How a value is predicted. The numbers are Draco's.
enum class Scheme : int8_t {
  kNone = -2,
  kDifference = 0,
  kParallelogram = 1,
  kMultiParallelogram = 2,
  kConstrainedMultiParallelogram = 4,
  kTexCoords = 5,
  kGeometricNormal = 6,
};

// How a correction changes the predicted value. The numbers are Draco's.
enum class Transform : int8_t {
  kWrap = 1,
  kOctahedron = 2,
  kOctahedronCanonicalized = 3,
};

// The constrained multi-parallelogram scheme uses at most this number for a value.
inline constexpr uint32_t kMaxParallelograms = 4;

class PredictionData {
 public:
  Scheme scheme = Scheme::kNone;
  Transform transform = Transform::kWrap;
  WrapRange wrap;       // of kWrap
  OctahedralGrid grid;  // of the octahedral transforms
  // For kConstrainedMultiParallelogram. creases[n - 1] has the flags of the values that n parallelograms
  // predict, n for each value, in the order of values. A flag says that the parallelogram is not used.
  View<uint8_t> creases[kMaxParallelograms];
  // The orientations of triangles for kTexCoords, in the order of storage. They are used from the last to the
  // first.
  View<uint8_t> orientations;
  // Whether the predicted normal points the other way, for kGeometricNormal.
  RansBits flips;
  View<const uint8_t> flips_by_value;  // of a condensed stream, in place of `flips`

  PSPLIT_HD bool flip(uint32_t value) {
    return flips_by_value.empty() ? flips.next() : flips_by_value[value] != 0;
  }

  // Reads everything that follows the corrections of `scheme` and `transform`, except flags of creases:
  // take_crease_steps decodes those. No scheme has more flags than there are corners: `corner_limit`.
  PSPLIT_HD Fault read(ByteReader& reader, uint32_t corner_limit, Arena& arena) {
    Fault fault = Fault::kNone;
    if (scheme == Scheme::kNone) return fault;
    if (scheme == Scheme::kConstrainedMultiParallelogram) fault = read_creases(reader, corner_limit, arena);
    if (scheme == Scheme::kTexCoords) fault = read_orientations(reader, corner_limit, arena);
    if (fault != Fault::kNone) return fault;
    fault = transform == Transform::kWrap ? wrap.read(reader) : read_grid(reader);
    return fault == Fault::kNone && scheme == Scheme::kGeometricNormal ? flips.start(reader) : fault;
  }
  // Collective.
  template <Lanes L>
  PSPLIT_HD void take_crease_steps(L lanes) {
    if (scheme != Scheme::kConstrainedMultiParallelogram) return;
    if constexpr (L::size() > 1) {
      for_each_lane_item(lanes, kMaxParallelograms, [&](uint32_t i) {
        BitSteps* const one = &crease_steps_[i];
        step_all<1, BitSteps>(&one, 1);
      });
      lanes.sync();
    } else {
      BitSteps* runs[kMaxParallelograms];
      for (uint32_t i = 0; i < kMaxParallelograms; ++i) runs[i] = &crease_steps_[i];
      step_all<kInStep, BitSteps>(runs, kMaxParallelograms);
    }
  }
  // The grid of the octahedral transforms, which `read` reads as well.
  PSPLIT_HD Fault read_grid(ByteReader& reader) {
    const uint32_t max_quantized = reader.u32();
    if (transform == Transform::kOctahedronCanonicalized) reader.u32();  // the center, which follows from it
    if (reader.truncated()) return Fault::kTruncated;
    int bits = 0;
    while (bits < 31 && (1u << bits) - 1 < max_quantized) ++bits;
    if (bits < 2 || bits > 30 || (max_quantized & 1) == 0) return Fault::kPrediction;
    grid = OctahedralGrid(bits);
    return Fault::kNone;
  }
  // Sets the orientations. same(i) says whether orientation i is the same as the one before.
  template <typename Same>
  PSPLIT_HD void find_orientations(Same same) {
    uint8_t orientation = 1;
    for (uint32_t i = 0; i < orientations.size(); ++i) {
      if (!same(i)) orientation ^= 1;
      orientations[i] = orientation;
    }
  }
  // The memory that `read` takes, if the stream stores no more flags than `value_count` values can use.
  PSPLIT_HD static constexpr size_t bytes(uint64_t value_count) {
    return Arena::bytes<uint8_t>(kMaxParallelograms * value_count) +
           (kMaxParallelograms - 1) * Arena::bytes<uint8_t>(0);
  }

 private:
  PSPLIT_HD Fault read_creases(ByteReader& reader, uint32_t corner_limit, Arena& arena) {
    for (uint32_t i = 0; i < kMaxParallelograms; ++i) {
      const uint32_t count = reader.varint();
      if (count > corner_limit) return Fault::kPrediction;
      if (!arena.take(creases[i], count)) return Fault::kWorkspace;
      if (count == 0) continue;
      RansBits bits;
      if (const Fault fault = bits.start(reader); fault != Fault::kNone) return fault;
      crease_steps_[i] = BitSteps(bits, creases[i]);
    }
    return Fault::kNone;
  }

  PSPLIT_HD Fault read_orientations(ByteReader& reader, uint32_t corner_limit, Arena& arena) {
    const uint32_t count = reader.u32();
    if (count > corner_limit) return Fault::kPrediction;
    if (!arena.take(orientations, count)) return Fault::kWorkspace;
    // Each bit says whether an orientation is the same as the one before.
    RansBits same;
    if (const Fault fault = same.start(reader); fault != Fault::kNone) return fault;
    find_orientations([&](uint32_t) { return same.next(); });
    return Fault::kNone;
  }

  BitSteps crease_steps_[kMaxParallelograms];
};

}  // namespace psplit::core
