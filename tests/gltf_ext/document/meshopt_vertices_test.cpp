// Version 1 of the codec of attributes decodes the streams of meshoptimizer's own encoder and of our encoder,
// and refuses broken bytes.

#include "gltf_ext/document/meshopt_vertices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <vector>

namespace psplit {
namespace {

using Bytes = std::vector<uint8_t>;

Bytes decoded_rows(const Bytes& stream, size_t stride, size_t count) {
  Bytes rows(count * stride, 0xcd);
  EXPECT_TRUE(decode_vertices(stream, stride, rows));
  return rows;
}

template <typename T>
void put(Bytes& rows, T value) {
  rows.resize(rows.size() + sizeof value);
  std::memcpy(rows.data() + rows.size() - sizeof value, &value, sizeof value);
}

// Streams of npm's meshoptimizer 1.3, with its highest level and version 1.
struct GoldenStream {
  size_t stride, count;
  Bytes stream, rows;
};

// 16-bit deltas in the first channel; in the second, deltas as they are, without header.
GoldenStream golden_shorts() {
  GoldenStream golden{
      8,
      37,
      {0xa1, 0x77, 0xff, 0x00, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58,
       0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58,
       0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x15, 0x2a, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0x80,
       0x00, 0x00, 0x00, 0x0e, 0x2a, 0x46, 0x62, 0x7e, 0x9a, 0xdf, 0xd2, 0xee, 0x8b, 0x26, 0x53, 0x5e, 0x1b,
       0x96, 0xe3, 0xc7, 0xea, 0x8f, 0x73, 0x57, 0x3b, 0x1f, 0x03, 0x18, 0x34, 0x50, 0x6c, 0x88, 0xf1, 0xc0,
       0xdc, 0x9d, 0x14, 0x30, 0x49, 0x15, 0x00, 0x01, 0x05, 0x55, 0x04, 0x00, 0x00, 0x04, 0x15, 0x40, 0x00,
       0x00, 0x00, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d,
       0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d, 0x9d,
       0x9d, 0x9d, 0x9d, 0x9d, 0x00, 0xf2, 0xf4, 0xf4, 0xf2, 0xf4, 0xf4, 0xf2, 0xf4, 0xf4, 0xf2, 0xf4, 0xf4,
       0xf2, 0xf4, 0xf4, 0xf4, 0xf2, 0xf4, 0xf4, 0xf2, 0xf4, 0xf4, 0xf2, 0xf4, 0xf4, 0xf2, 0xf4, 0xf4, 0xf4,
       0xf2, 0xf4, 0xf4, 0xf2, 0xf4, 0xf4, 0xf2, 0x00, 0x6e, 0x6e, 0x70, 0x6e, 0x70, 0x6e, 0x70, 0x6e, 0x70,
       0x6e, 0x70, 0x6e, 0x70, 0x6e, 0x70, 0x6e, 0x70, 0x6e, 0x70, 0x6e, 0x6e, 0x70, 0x6e, 0x70, 0x6e, 0x70,
       0x6e, 0x70, 0x6e, 0x70, 0x6e, 0x70, 0x6e, 0x70, 0x6e, 0x70, 0x00, 0xc3, 0xc3, 0xc3, 0xc3, 0xc1, 0xc3,
       0xc3, 0xc3, 0xc3, 0xc1, 0xc3, 0xc3, 0xc3, 0xc1, 0xc3, 0xc3, 0xc3, 0xc3, 0xc1, 0xc3, 0xc3, 0xc3, 0xc3,
       0xc1, 0xc3, 0xc3, 0xc3, 0xc1, 0xc3, 0xc3, 0xc3, 0xc3, 0xc1, 0xc3, 0xc3, 0xc3, 0x00, 0x00, 0x00, 0x00,
       0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x78, 0xec, 0x9c, 0xff, 0x00, 0x00, 0x00,
       0x00, 0x01, 0x00},
      {}};
  for (uint32_t i = 0; i < golden.count; ++i) {
    put(golden.rows, static_cast<int16_t>(300 * i - 5000));
    put(golden.rows, static_cast<int16_t>(static_cast<int>(i * i * 7 % 331) - 100));
    put(golden.rows, i * 2654435761u);
  }
  return golden;
}

// The exclusive or of floats, rotated by 6 bits.
GoldenStream golden_floats() {
  GoldenStream golden{
      4,
      40,
      {0xa1, 0x68, 0x05, 0x02, 0x00, 0x0f, 0x01, 0x00, 0x1f, 0x1a, 0x0f, 0xff, 0xf8, 0xf8, 0xf4, 0xc4, 0xf4,
       0xc4, 0x80, 0x20, 0x10, 0x70, 0x18, 0x38, 0x1c, 0xf2, 0x62, 0xe2, 0x62, 0xf2, 0x62, 0xe2, 0x62, 0xfc,
       0x1e, 0xdd, 0xdd, 0x00, 0x00, 0x3e, 0x03, 0x07, 0x03, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
       0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x62},
      {}};
  for (size_t i = 0; i < golden.count; ++i) put(golden.rows, static_cast<float>(i) / 8);
  return golden;
}

// Byte deltas of all sizes.
GoldenStream golden_bytes() {
  GoldenStream golden{
      4,
      50,
      {0xa1, 0x05, 0x2a, 0x06, 0x66, 0x66, 0x66, 0x66, 0x66, 0x66, 0x66, 0x66, 0x66, 0x66, 0x66, 0x66,
       0x66, 0x66, 0x66, 0x66, 0x66, 0x66, 0x66, 0x66, 0x66, 0x66, 0x66, 0x03, 0x00, 0x06, 0x06, 0x00,
       0x00, 0x01, 0x02, 0x01, 0x01, 0x01, 0x02, 0x01, 0x01, 0x01, 0x02, 0x01, 0x00, 0x01, 0x04, 0x30,
       0x00, 0x7d, 0x7e, 0x7c, 0x26, 0x05, 0x12, 0x60, 0x51, 0x26, 0x05, 0x12, 0x60, 0x51, 0x26, 0x05,
       0x12, 0x60, 0x51, 0x26, 0x02, 0x00, 0x05, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
       0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x07, 0x00, 0x00},
      {}};
  for (size_t i = 0; i < golden.count; ++i) {
    const size_t row[] = {i * 3, i >> 3 & 1, i == 20 ? 200u : 7u, i < 16 ? 0 : i * i % 5};
    for (const size_t byte : row) put(golden.rows, static_cast<uint8_t>(byte));
  }
  return golden;
}

// Two blocks that take 2 bits for each byte of a row.
GoldenStream golden_zeros() {
  return {4,
          300,
          {0xa1, 0xaa, 0xaa, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
           0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00},
          Bytes(1200)};
}

std::vector<GoldenStream> golden_streams() {
  return {golden_shorts(), golden_floats(), golden_bytes(), golden_zeros()};
}

TEST(MeshoptVertices, DecodesStreamsOfMeshoptimizer) {
  for (const GoldenStream& golden : golden_streams())
    EXPECT_EQ(decoded_rows(golden.stream, golden.stride, golden.count), golden.rows) << golden.count;
}

TEST(MeshoptVertices, EncodesNoLargerThanMeshoptimizer) {
  for (const GoldenStream& golden : golden_streams())
    EXPECT_LE(encode_vertices(golden.rows, golden.stride).size(), golden.stream.size()) << golden.count;
  EXPECT_EQ(encode_vertices(golden_zeros().rows, 4), golden_zeros().stream);
}

// Rows of kinds that need different deltas, bits and controls.
Bytes make_rows(size_t stride, size_t count, int kind, std::mt19937& random) {
  Bytes rows;
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t channel = 0; channel < stride / 4; ++channel) {
      const auto noise = static_cast<uint32_t>(random());
      if (kind == 0) put(rows, noise);
      if (kind == 1) put(rows, static_cast<float>(i) * 0.1f + static_cast<float>(channel));
      if (kind == 2) put(rows, (i * 3 + noise % 3) | (channel * 40 - i * i % 301) << 16);
      if (kind == 3) put(rows, i % 200 < 70 ? noise : i / 33);
      if (kind == 4) put(rows, noise % 40 == 0 ? noise : 0x07000000 + noise % 2);
    }
  return rows;
}

TEST(MeshoptVertices, EveryStrideComesBack) {
  std::mt19937 random(1);
  for (size_t stride = 4; stride <= 256; stride += stride < 64 ? 4 : 48)
    for (const size_t count : {0u, 1u, 15u, 16u, 17u, 255u, 256u, 257u, 700u})
      for (int kind = 0; kind < 5; ++kind) {
        const Bytes rows = make_rows(stride, count, kind, random), stream = encode_vertices(rows, stride);
        EXPECT_EQ(decoded_rows(stream, stride, count), rows) << stride << " " << count << " " << kind;
        EXPECT_LE(rows.size(), kMostBytesOfVersion1 * stream.size());
        // Noise takes no more than a control for each byte in a block, and the ends.
        const size_t blocks = count / std::min<size_t>(8192 / stride / 16 * 16, 256) + 1;
        EXPECT_LE(stream.size(), rows.size() + blocks * stride / 4 + 1 + stride + stride / 4 + 24);
      }
}

// Whether a stream decodes, from memory of exactly its size. What was decoded does not reach past the rows.
bool is_decodable(const Bytes& stream, size_t stride, size_t count) {
  Bytes rows(count * stride + 16, 0xcd);
  const bool is_decoded = decode_vertices(Bytes(stream), stride, std::span(rows).first(count * stride));
  EXPECT_TRUE(std::all_of(rows.end() - 16, rows.end(), [](uint8_t byte) { return byte == 0xcd; }));
  return is_decoded;
}

TEST(MeshoptVertices, StreamsOfAnotherLengthAreRefused) {
  for (const GoldenStream& golden : golden_streams()) {
    for (size_t length = 0; length < golden.stream.size(); ++length) {
      Bytes cut = golden.stream;
      cut.resize(length);
      EXPECT_FALSE(is_decodable(cut, golden.stride, golden.count)) << length;
    }
    Bytes longer = golden.stream;
    longer.insert(longer.end() - 24, 0);
    EXPECT_FALSE(is_decodable(longer, golden.stride, golden.count));
    EXPECT_FALSE(is_decodable(golden.stream, golden.stride, golden.count + 256));
    EXPECT_FALSE(is_decodable(golden.stream, golden.stride, 0));
  }
}

TEST(MeshoptVertices, UnknownModesAndVersionsAreRefused) {
  const GoldenStream golden = golden_shorts();
  const auto with = [&](size_t from_end, uint8_t byte) {
    Bytes changed = golden.stream;
    changed[changed.size() - from_end] = byte;
    return is_decodable(changed, golden.stride, golden.count);
  };
  for (const int mode : {0, 1, 0x02, 0xf2}) EXPECT_TRUE(with(1, static_cast<uint8_t>(mode))) << mode;
  for (const int mode : {3, 4, 0x0f, 0x10, 0x21, 0x43})
    EXPECT_FALSE(with(2, static_cast<uint8_t>(mode))) << mode;
  for (const int version : {0xa0, 0xa2, 0xe1, 0})
    EXPECT_FALSE(with(golden.stream.size(), static_cast<uint8_t>(version)));
}

TEST(MeshoptVertices, AnyBytesAreDecodedOrRefused) {
  std::mt19937 random(7);
  size_t decoded = 0, refused = 0;
  for (const GoldenStream& golden : golden_streams())
    for (int trial = 0; trial < 3000; ++trial) {
      Bytes mutant = golden.stream;
      for (auto changes = 1 + random() % 4; changes > 0; --changes)
        mutant[1 + random() % (mutant.size() - 1)] = static_cast<uint8_t>(random());
      (is_decodable(mutant, golden.stride, golden.count) ? decoded : refused) += 1;
    }
  EXPECT_GT(decoded, 100u);
  EXPECT_GT(refused, 100u);
}

}  // namespace
}  // namespace psplit
