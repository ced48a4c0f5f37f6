#include "gltf_ext/document/meshopt_vertices.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>

namespace psplit {
namespace {

// A stream, for rows of three channels:
//
//   0xa1 | block | block | ... | zeros | first row | modes of the channels
//
//   block: controls of the planes, 2 bits each | plane of byte 0 | plane of byte 1 | ... | plane of byte 11
//   plane: bits of the groups, 2 bits each | group of 16 deltas | group | ...
//
// A plane has the deltas of one byte of the rows. The 4 bytes of a channel have a common mode.
constexpr size_t kGroupRows = 16, kMostBlockRows = 256, kMostBlockBytes = 8192;
constexpr size_t kChannelBytes = 4, kLeastTailBytes = 24;

enum Control : uint8_t { kFewBits, kManyBits, kZeros, kLiteral };
constexpr unsigned kBitsOfGroups[2][4] = {{0, 1, 2, 4}, {1, 2, 4, 8}};  // of planes of kFewBits and kManyBits

constexpr size_t block_rows(size_t stride) {
  return std::min(kMostBlockBytes / stride / kGroupRows * kGroupRows, kMostBlockRows);
}
constexpr size_t group_count(size_t rows) { return (rows + kGroupRows - 1) / kGroupRows; }
// Four numbers of 2 bits are in a byte, the first in its lowest bits.
constexpr size_t packed_bytes(size_t count) { return (count + 3) / 4; }
constexpr unsigned packed_shift(size_t i) { return i % 4 * 2; }
constexpr size_t tail_bytes(size_t stride) {
  return std::max(stride + stride / kChannelBytes, kLeastTailBytes);
}

uint32_t load_channel(const uint8_t* at) {
  return static_cast<uint32_t>(at[0] | at[1] << 8 | at[2] << 16) | uint32_t{at[3]} << 24;
}
void store_channel(uint32_t value, uint8_t* at) {
  for (size_t k = 0; k < kChannelBytes; ++k) at[k] = static_cast<uint8_t>(value >> 8 * k);
}

// Differences of all numbers of kBits in a channel, and their signs in the lowest bit.
template <unsigned kBits>
struct NumberDeltas {
  static constexpr uint32_t kOnes = kBits == 8 ? 0x01010101 : 0x00010001, kSigns = kOnes << (kBits - 1);
  static constexpr uint32_t kNumber = (uint32_t{1} << kBits) - 1;

  uint32_t delta(uint32_t value, uint32_t before) const {
    const uint32_t difference = ((value | kSigns) - (before & ~kSigns)) ^ ((value ^ ~before) & kSigns);
    return ((difference << 1) & ~kOnes) ^ ((difference & kSigns) >> (kBits - 1)) * kNumber;
  }
  uint32_t value(uint32_t delta, uint32_t before) const {
    const uint32_t difference = ((delta >> 1) & ~kSigns) ^ (delta & kOnes) * kNumber;
    return ((difference & ~kSigns) + (before & ~kSigns)) ^ ((difference ^ before) & kSigns);
  }
};

struct XorDeltas {
  int rotation;

  uint32_t delta(uint32_t value, uint32_t before) const { return std::rotl(value ^ before, rotation); }
  uint32_t value(uint32_t delta, uint32_t before) const { return std::rotr(delta, rotation) ^ before; }
};

// The mode of a channel as the stream has it: the deltas in the lower half, the rotation in the upper.
using ChannelMode = uint8_t;
constexpr ChannelMode kByteDeltas = 0, kShortDeltas = 1, kXor = 2;
constexpr ChannelMode xor_mode(int rotation) { return static_cast<ChannelMode>(kXor | rotation << 4); }
constexpr bool is_mode(ChannelMode mode) { return mode <= kShortDeltas || (mode & 15) == kXor; }

template <typename Use>
void with_deltas(ChannelMode mode, Use&& use) {
  if (mode == kByteDeltas)
    use(NumberDeltas<8>());
  else if (mode == kShortDeltas)
    use(NumberDeltas<16>());
  else
    use(XorDeltas{mode >> 4});
}

// The deltas of one channel in one block, by byte. Rows that fill the last group are zeros.
using Plane = std::array<uint8_t, kMostBlockRows>;
using Planes = std::array<Plane, kChannelBytes>;

class Decoder {
 public:
  // `bytes` end before the tail of the stream.
  explicit Decoder(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  bool is_at_end() const { return bytes_.empty(); }

  // The next `count` bytes; null if fewer are left.
  const uint8_t* take(size_t count) {
    if (count > bytes_.size()) return nullptr;
    const uint8_t* const at = bytes_.data();
    bytes_ = bytes_.subspan(count);
    return at;
  }

  bool read_plane(unsigned control, size_t rows, Plane& plane) {
    if (control == kZeros) {
      plane.fill(0);
      return true;
    }
    if (control == kLiteral) {
      const uint8_t* const literal = take(rows);
      if (literal != nullptr) std::copy_n(literal, rows, plane.begin());
      return literal != nullptr;
    }
    const uint8_t* const header = take(packed_bytes(group_count(rows)));
    if (header == nullptr) return false;
    for (size_t i = 0; i < group_count(rows); ++i) {
      const unsigned bits = kBitsOfGroups[control][header[i / 4] >> packed_shift(i) & 3];
      if (!read_group(bits, &plane[i * kGroupRows])) return false;
    }
    return true;
  }

 private:
  bool read_group(unsigned bits, uint8_t* deltas) {
    const uint8_t* const packed = take(2 * bits);
    if (packed == nullptr) return false;
    if (bits == 0) std::fill_n(deltas, kGroupRows, uint8_t{0});
    if (bits == 8) std::copy_n(packed, kGroupRows, deltas);
    if (bits == 0 || bits == 8) return true;
    const unsigned sentinel = (1u << bits) - 1;
    for (size_t i = 0; i < kGroupRows; ++i) {
      const size_t at = i * bits % 8, shift = bits == 1 ? at : 8 - bits - at;
      const unsigned code = packed[i * bits / 8] >> shift & sentinel;
      deltas[i] = static_cast<uint8_t>(code);
      if (code < sentinel) continue;
      const uint8_t* const whole = take(1);
      if (whole == nullptr) return false;
      deltas[i] = *whole;
    }
    return true;
  }

  std::span<const uint8_t> bytes_;
};

// How many of 8 bytes are at least `least`, from 1 to 128.
constexpr size_t count_at_least(uint64_t bytes, unsigned least) {
  constexpr uint64_t kOnes = 0x0101010101010101, kTops = 0x80 * kOnes;
  const uint64_t reached = ((bytes & ~kTops) + (0x80 - least) * kOnes) | bytes;
  return static_cast<size_t>(((reached & kTops) >> 7) * kOnes >> 56);
}

// How many deltas of a group do not fit below the sentinels of 1, 2 and 4 bits.
struct GroupCounts {
  size_t of_1 = 0, of_2 = 0, of_4 = 0;

  explicit GroupCounts(const uint8_t* deltas) {
    for (size_t at = 0; at < kGroupRows; at += sizeof(uint64_t)) {
      uint64_t bytes = 0;
      std::memcpy(&bytes, deltas + at, sizeof bytes);
      of_1 += count_at_least(bytes, 1);
      of_2 += count_at_least(bytes, 3);
      of_4 += count_at_least(bytes, 15);
    }
  }
};

// The bytes that a group takes with `bits` bits a delta; kNever with 0 bits, if a delta is not 0.
constexpr size_t kNever = std::numeric_limits<size_t>::max() / kMostBlockRows;
size_t group_bytes(const GroupCounts& counts, unsigned bits) {
  switch (bits) {
    case 0: return counts.of_1 == 0 ? 0 : kNever;
    case 1: return 2 + counts.of_1;
    case 2: return 4 + counts.of_2;
    case 4: return 8 + counts.of_4;
    default: return kGroupRows;
  }
}

// The number of the bits that are best for a group in planes of a control.
struct GroupChoice {
  unsigned index;
  size_t bytes;
};
GroupChoice choose_bits(const GroupCounts& counts, Control control) {
  GroupChoice best{0, kNever};
  for (unsigned i = 0; i < 4; ++i)
    if (const size_t bytes = group_bytes(counts, kBitsOfGroups[control][i]); bytes < best.bytes)
      best = {i, bytes};
  return best;
}

struct PlaneChoice {
  Control control;
  size_t bytes;
};
PlaneChoice choose_control(const Plane& plane, size_t rows) {
  const size_t groups = group_count(rows), header = packed_bytes(groups);
  PlaneChoice few{kFewBits, header}, many{kManyBits, header};
  bool is_zero = true;
  for (size_t i = 0; i < groups; ++i) {
    const GroupCounts counts(&plane[i * kGroupRows]);
    is_zero &= counts.of_1 == 0;
    few.bytes += choose_bits(counts, kFewBits).bytes;
    many.bytes += choose_bits(counts, kManyBits).bytes;
  }
  if (is_zero) return {kZeros, 0};
  const PlaneChoice& best = few.bytes <= many.bytes ? few : many;
  return best.bytes < rows ? best : PlaneChoice{kLiteral, rows};
}

void write_group(const uint8_t* deltas, unsigned bits, std::vector<uint8_t>& to) {
  if (bits == 8) to.insert(to.end(), deltas, deltas + kGroupRows);
  if (bits == 0 || bits == 8) return;
  const unsigned sentinel = (1u << bits) - 1;
  const size_t begin = to.size();
  to.resize(begin + 2 * bits);
  for (size_t i = 0; i < kGroupRows; ++i) {
    const size_t at = i * bits % 8, shift = bits == 1 ? at : 8 - bits - at;
    const unsigned code = std::min<unsigned>(deltas[i], sentinel);
    to[begin + i * bits / 8] = static_cast<uint8_t>(to[begin + i * bits / 8] | code << shift);
    if (code == sentinel) to.push_back(deltas[i]);
  }
}

void write_plane(const Plane& plane, size_t rows, Control control, std::vector<uint8_t>& to) {
  if (control == kLiteral) to.insert(to.end(), plane.begin(), plane.begin() + rows);
  if (control == kLiteral || control == kZeros) return;
  const size_t header = to.size(), groups = group_count(rows);
  to.resize(header + packed_bytes(groups));
  for (size_t i = 0; i < groups; ++i) {
    const unsigned index = choose_bits(GroupCounts(&plane[i * kGroupRows]), control).index;
    to[header + i / 4] = static_cast<uint8_t>(to[header + i / 4] | index << packed_shift(i));
    write_group(&plane[i * kGroupRows], kBitsOfGroups[control][index], to);
  }
}

class Encoder {
 public:
  Encoder(std::span<const uint8_t> rows, size_t stride) : rows_(rows), stride_(stride) {}

  std::vector<uint8_t> run() const {
    const size_t count = rows_.size() / stride_, channels = stride_ / kChannelBytes;
    std::vector<ChannelMode> modes(channels);
    for (size_t c = 0; c < channels; ++c) modes[c] = choose_mode(c);
    std::vector<uint8_t> bytes{kVerticesOfVersion1};
    for (size_t first = 0; first < count; first += block_rows(stride_)) write_block(first, modes, bytes);
    bytes.resize(bytes.size() + tail_bytes(stride_) - stride_ - channels);
    if (count > 0)
      bytes.insert(bytes.end(), rows_.begin(), rows_.begin() + static_cast<std::ptrdiff_t>(stride_));
    else
      bytes.resize(bytes.size() + stride_);
    bytes.insert(bytes.end(), modes.begin(), modes.end());
    return bytes;
  }

 private:
  size_t rows_of_block(size_t first) const {
    return std::min(rows_.size() / stride_ - first, block_rows(stride_));
  }

  // The first row of the stream follows itself.
  void find_deltas(size_t first, size_t channel, ChannelMode mode, Planes& planes) const {
    const size_t rows = rows_of_block(first);
    const uint8_t* at = &rows_[first * stride_ + channel * kChannelBytes];
    uint32_t before = load_channel(first == 0 ? at : at - stride_);
    with_deltas(mode, [&](const auto& deltas) {
      for (size_t i = 0; i < rows; ++i, at += stride_) {
        const uint32_t value = load_channel(at), delta = deltas.delta(value, before);
        for (size_t k = 0; k < kChannelBytes; ++k) planes[k][i] = static_cast<uint8_t>(delta >> 8 * k);
        before = value;
      }
    });
    for (Plane& plane : planes)
      std::fill(plane.begin() + rows, plane.begin() + group_count(rows) * kGroupRows, uint8_t{0});
  }

  // Tries all modes with a part of the blocks of a long stream.
  ChannelMode choose_mode(size_t channel) const {
    constexpr size_t kMostTrials = 64;
    const size_t count = rows_.size() / stride_,
                 blocks = (count + block_rows(stride_) - 1) / block_rows(stride_);
    const size_t step = (blocks + kMostTrials - 1) / kMostTrials * block_rows(stride_);
    ChannelMode best = kByteDeltas;
    size_t least = std::numeric_limits<size_t>::max();
    const auto attempt = [&](ChannelMode mode) {
      Planes planes;
      size_t bytes = 0;
      for (size_t first = 0; first < count && bytes < least; first += step) {
        find_deltas(first, channel, mode, planes);
        for (const Plane& plane : planes) bytes += choose_control(plane, rows_of_block(first)).bytes;
      }
      if (bytes >= least) return;
      least = bytes;
      best = mode;
    };
    attempt(kByteDeltas);
    attempt(kShortDeltas);
    for (int rotation = 0; rotation < 16; ++rotation) attempt(xor_mode(rotation));
    return best;
  }

  void write_block(size_t first, std::span<const ChannelMode> modes, std::vector<uint8_t>& to) const {
    const size_t rows = rows_of_block(first), controls = to.size();
    to.resize(controls + packed_bytes(stride_));
    Planes planes;
    for (size_t c = 0; c < modes.size(); ++c) {
      find_deltas(first, c, modes[c], planes);
      for (size_t k = 0; k < kChannelBytes; ++k) {
        const Control control = choose_control(planes[k], rows).control;
        to[controls + c] = static_cast<uint8_t>(to[controls + c] | control << packed_shift(k));
        write_plane(planes[k], rows, control, to);
      }
    }
  }

  std::span<const uint8_t> rows_;
  size_t stride_;
};

}  // namespace

bool decode_vertices(std::span<const uint8_t> bytes, size_t stride, std::span<uint8_t> rows) {
  const size_t tail = tail_bytes(stride), channels = stride / kChannelBytes, count = rows.size() / stride;
  if (bytes.size() < 1 + tail || bytes[0] != kVerticesOfVersion1) return false;
  const std::span<const uint8_t> modes = bytes.last(channels);
  if (!std::ranges::all_of(modes, is_mode)) return false;
  const uint8_t* before = bytes.data() + bytes.size() - channels - stride;
  Decoder decoder(bytes.subspan(1, bytes.size() - 1 - tail));
  Planes planes;
  for (size_t first = 0; first < count; first += block_rows(stride)) {
    const size_t block = std::min(count - first, block_rows(stride));
    const uint8_t* const controls = decoder.take(packed_bytes(stride));
    if (controls == nullptr) return false;
    uint8_t* const to = &rows[first * stride];
    for (size_t c = 0; c < channels; ++c) {
      for (size_t k = 0; k < kChannelBytes; ++k)
        if (!decoder.read_plane(controls[c] >> packed_shift(k) & 3, block, planes[k])) return false;
      uint32_t value = load_channel(before + c * kChannelBytes);
      with_deltas(modes[c], [&](const auto& deltas) {
        uint8_t* at = to + c * kChannelBytes;
        for (size_t i = 0; i < block; ++i, at += stride) {
          value = deltas.value(static_cast<uint32_t>(planes[0][i] | planes[1][i] << 8 | planes[2][i] << 16) |
                                   uint32_t{planes[3][i]} << 24,
                               value);
          store_channel(value, at);
        }
      });
    }
    before = to + (block - 1) * stride;
  }
  return decoder.is_at_end();
}

std::vector<uint8_t> encode_vertices(std::span<const uint8_t> rows, size_t stride) {
  return Encoder(rows, stride).run();
}

}  // namespace psplit
