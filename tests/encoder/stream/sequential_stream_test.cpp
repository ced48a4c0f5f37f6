// Sequential streams have the bytes of libdraco's encoder.
#include "encoder/stream/sequential_stream.h"

#include <map>
#include <random>

#include "encoder/libdraco/patch_stream.h"
#include "tests/support/default_codings.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

constexpr size_t kCompressed = 0, kPlain = 1;

// The place of the first byte after the numbers of faces and points.
size_t index_coding(std::span<const uint8_t> stream) {
  size_t at = 11;
  for (int number = 0; number < 2; ++number)
    while ((stream[at++] & 0x80) != 0) {
    }
  return stream[at];
}

// Counts streams by the coding of their indices.
using IndexCodings = std::map<size_t, size_t>;

void expect_same_stream(const std::string& name, const Mesh& mesh, std::span<const AttributeCoding> codings,
                        int speed, IndexCodings& seen) {
  SCOPED_TRACE(name + ", speed " + std::to_string(speed));
  const WeldedMesh welded = weld(mesh, ThreadPool(1));
  const PatchMesh whole = whole_mesh(mesh);
  const Expected<std::vector<uint8_t>> expected = encode_sequential(welded, whole, codings, speed);
  const Expected<std::vector<uint8_t>> made =
      write_sequential_stream({welded, codings, whole.points}, whole.faces, speed);
  ASSERT_EQ(made.status().ok(), expected.status().ok()) << made.status().message();
  if (!expected) return;
  ++seen[index_coding(*expected)];
  EXPECT_EQ(*made, *expected);
}

TEST(SequentialStream, EveryMeshAtEverySpeedHasTheBytesOfLibdraco) {
  IndexCodings seen;
  for (const NamedMesh& named : all_meshes())
    for (const bool lossless : {false, true}) {
      const Coded coded = default_codings(named.mesh, lossless);
      for (int speed = 0; speed <= 10; ++speed)
        expect_same_stream(named.name, named.mesh, coded.codings, speed, seen);
    }
  RecordProperty("streams", std::to_string(seen[kCompressed] + seen[kPlain]));
  EXPECT_GT(seen[kCompressed], 50u);
  EXPECT_GT(seen[kPlain], 50u);
}

// The number of points decides how an index is stored. Faces at random are not compressed.
TEST(SequentialStream, IndicesOfEveryWidthHaveTheBytesOfLibdraco) {
  IndexCodings seen;
  for (const uint32_t point_count : {1u, 2u, 255u, 256u, 257u, 65535u, 65536u, 65537u, 2097151u, 2097152u}) {
    std::mt19937 random(point_count);
    const auto any_point = [&] { return static_cast<uint32_t>(random()) % point_count; };
    std::vector<float> positions;
    for (uint32_t i = 0; i < 3 * point_count; ++i) positions.push_back(static_cast<float>(i % 7));
    Faces faces(100);
    for (auto& face : faces) face = {any_point(), any_point(), point_count - 1};
    const Mesh mesh = make_mesh(positions, faces);
    const std::vector<AttributeCoding> codings = {AttributeCoding{3, false, {0, 0, 0}, 7}};
    expect_same_stream(std::to_string(point_count) + " points", mesh, codings, 9, seen);
  }
  EXPECT_EQ(seen[kPlain] + seen[kCompressed], 10u);
}

}  // namespace
}  // namespace psplit
