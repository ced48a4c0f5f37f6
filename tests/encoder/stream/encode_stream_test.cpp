// The bytes equal libdraco's, and the facts beside them are the ones that libdraco decodes.
#include "encoder/stream/encode_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>
#include <vector>

#include "encoder/libdraco/patch_stream.h"
#include "encoder/partition/cell_graph.h"
#include "encoder/welding/reduce.h"
#include "tests/encoder/stream/random_soup.h"
#include "tests/support/default_codings.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/sanitizers.h"

namespace psplit {
namespace {

struct Counts {
  size_t same = 0, refused = 0, with_neighbours = 0;
};

// The neighbours of the faces; empty if the partition would give none.
std::vector<std::array<uint32_t, 3>> neighbours_of(const WeldedMesh& welded, const PatchMesh& patch) {
  const auto positions = static_cast<size_t>(welded.mesh->find("POSITION") - welded.mesh->attributes.data());
  std::vector<std::array<uint32_t, 3>> faces = patch.faces;
  for (auto& face : faces) {
    for (uint32_t& point : face) point = welded.value_of_point[positions][patch.points[point]];
    if (repeats_a_point(face)) return {};
  }
  FaceGraph graph = face_graph(faces, welded.mesh->point_count, ThreadPool(1));
  return graph.extra.empty() ? std::move(graph.neighbours) : std::vector<std::array<uint32_t, 3>>();
}

void compare(const WeldedMesh& welded, const PatchMesh& patch, const std::vector<AttributeCoding>& codings,
             int speed, Counts& counts) {
  const Expected<EncodedPatch> ours = encode_stream(welded, patch, codings, speed, true),
                               reference = encode_edgebreaker(welded, patch, codings, speed, true);
  ASSERT_EQ(ours.ok(), reference.ok()) << ours.status().to_string() << reference.status().to_string();
  ++(ours.ok() ? counts.same : counts.refused);
  if (!ours) return;
  const auto different = std::ranges::mismatch(ours->bytes, reference->bytes);
  ASSERT_EQ(ours->bytes, reference->bytes) << "from byte " << different.in1 - ours->bytes.begin();
  EXPECT_EQ(ours->decoded.point_count, reference->decoded.point_count);
  EXPECT_EQ(ours->decoded.faces, reference->decoded.faces);
  const Expected<EncodedPatch> walked = encode_stream(welded, patch, codings, speed, false);
  ASSERT_TRUE(walked.ok()) << walked.status().to_string();
  EXPECT_EQ(walked->walk, reference->walk);
  ASSERT_EQ(ours->decoded.attributes.size(), reference->decoded.attributes.size());
  for (size_t i = 0; i < ours->decoded.attributes.size(); ++i) {
    const Attribute &a = ours->decoded.attributes[i], &b = reference->decoded.attributes[i];
    EXPECT_EQ(a.semantic, b.semantic);
    EXPECT_EQ(a.values, b.values) << a.semantic;
  }
  ASSERT_EQ(ours->patch_point.size(), reference->patch_point.size());
  for (size_t i = 0; i < ours->patch_point.size(); ++i) {
    const uint32_t a = patch.points[ours->patch_point[i]], b = patch.points[reference->patch_point[i]];
    for (const std::vector<uint32_t>& value : welded.value_of_point) EXPECT_EQ(value[a], value[b]);
  }
  PatchMesh linked = patch;
  linked.neighbours = neighbours_of(welded, patch);
  if (linked.neighbours.empty()) return;
  ++counts.with_neighbours;
  const Expected<EncodedPatch> same = encode_stream(welded, linked, codings, speed, false);
  ASSERT_TRUE(same.ok()) << same.status().to_string();
  EXPECT_EQ(same->bytes, ours->bytes);
  EXPECT_EQ(same->patch_point, ours->patch_point);
}

TEST(EncodeStream, MeshesAreAsByLibdraco) {
  Counts counts;
  for (const NamedMesh& named : all_meshes()) {
    if (named.mesh.faces.empty()) continue;
    SCOPED_TRACE(named.name);
    WeldedMesh welded = weld(named.mesh, ThreadPool(1));
    separate_flat_faces(welded);
    for (const bool lossless : {false, true})
      for (int speed = lossless ? 5 : 0; speed <= 10; speed += lossless ? 5 : 1) {
        SCOPED_TRACE("speed " + std::to_string(speed));
        compare(welded, whole_mesh(named.mesh), default_codings(named.mesh, lossless).codings, speed, counts);
        if (testing::Test::HasFatalFailure()) return;
      }
  }
  EXPECT_GT(counts.same, 500u);
  EXPECT_GT(counts.with_neighbours, 300u);
  RecordProperty("same", static_cast<int>(counts.same));
}

TEST(EncodeStream, RandomMeshesAreAsByLibdraco) {
  Counts counts;
  const size_t count = random_rounds(6000);
  for (size_t seed = 0; seed < count; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Soup soup;
    SoupMaker(seed).make(seed % 40 == 0 ? 5000 : seed % 4 == 0 ? 300 : 30, soup);
    compare(soup.welded, soup.patch, default_codings(soup.mesh, false).codings, static_cast<int>(seed % 11),
            counts);
    if (testing::Test::HasFatalFailure()) return;
  }
  EXPECT_GT(counts.same, count / 2);
  EXPECT_GT(counts.with_neighbours, count / 10);
  RecordProperty("same", static_cast<int>(counts.same));
}

}  // namespace
}  // namespace psplit
