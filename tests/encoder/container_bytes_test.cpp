// The bytes of some containers, pinned: the same mesh with the same options gives the same container, from
// release to release, with any number of threads, any compiler, with and without sanitizers.
//
// The meshes are made of sums, products and square roots, which IEEE 754 rounds in one way only, and no
// function of libm. libdraco writes the streams, so another version of it may change these bytes: then the
// table is replaced in a commit of its own. A change of psplit that alters a byte is a decision, not a repair
// of this test.
#include <gtest/gtest.h>

#include <functional>
#include <iomanip>

#include "encoder/encode_mesh.h"
#include "psplit/encode.h"
#include "tests/support/default_codings.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/reproducible_meshes.h"

namespace psplit {
namespace {

Mesh named(const std::string& name) {
  for (const NamedMesh& nasty : nasty_meshes())
    if (nasty.name == name) return nasty.mesh;
  ADD_FAILURE() << name;
  return make_grid(1, 1);
}

struct Pinned {
  const char* name;
  std::function<Mesh()> mesh;
  StreamOptions options;
  bool lossless;
  size_t bytes;
  uint64_t hash;
};

TEST(ContainerBytes, AreAsPinned) {
  const auto small = [] { return make_sheet(24, 20); };
  const auto large = [] { return make_sheet(120, 100); };
  const auto soup = [] { return named("soup with seams"); };
  const auto seams = [] { return named("chessboard of texture seams"); };
  const auto genus = [] { return named("torus chain of genus 144"); };
  const Pinned all[] = {
      {"one patch", small, {}, false, 3871, 0x95e6c047d809f645u},
      {"one patch, lossless", small, {}, true, 28247, 0x01e7c722cbf596b8u},
      {"4 patches at speed 0", small, {.patch_count = 4, .encode_speed = 0}, false, 7994, 0xb7e5c395cef355abu},
      {"4 patches at speed 10",
       small,
       {.patch_count = 4, .encode_speed = 10},
       false,
       9113,
       0xd2e50a47257e22bbu},
      {"17 patches", large, {.patch_count = 17}, false, 87104, 0xe46ab65eec0fb0a5u},
      {"17 patches, lossless", large, {.patch_count = 17}, true, 698258, 0x1287b8b2e3871ba0u},
      {"64 patches, borders as they are",
       large,
       {.patch_count = 64, .refine = false},
       false,
       134978,
       0x5afc9bb7bad37f97u},
      {"9 patches by the paper's method",
       large,
       {.patch_count = 9, .method = PartitionMethod::kPaper},
       false,
       78335,
       0x84b7ff3503c19ff1u},
      {"9 patches by geodesic distances",
       large,
       {.patch_count = 9, .method = PartitionMethod::kPaper, .distance = PathDistance::kGeodesic},
       false,
       78996,
       0x922ae457f8f5f609u},
      {"residue", make_sheet_with_residue, {.patch_count = 5}, false, 14121, 0xf63e0d729bde580au},
      {"residue with duplicates",
       make_sheet_with_residue,
       {.patch_count = 5, .keep_duplicates = true},
       false,
       14704,
       0xebf81b8a8d58eb73u},
      {"nothing left over",
       make_sheet_with_residue,
       {.patch_count = 5, .drop_degenerate = true, .drop_unused = true},
       false,
       13624,
       0x60d7ea4b5b9977b4u},
      {"seams", seams, {.patch_count = 3}, false, 3548, 0x31e7430f7fdc95d3u},
      {"handles", genus, {.patch_count = 6}, false, 3936, 0x9b84ceb0dcec3dd9u},
      {"non-manifold", soup, {.patch_count = 3}, false, 8647, 0x1f138cd628d1a3adu},
      {"non-manifold, with duplicates",
       soup,
       {.patch_count = 3, .keep_duplicates = true},
       true,
       21422,
       0x944885b34e0bd0e9u},
  };
  for (const Pinned& pinned : all) {
    const Mesh mesh = pinned.mesh();
    const auto encoded =
        must(encode_mesh(mesh, default_codings(mesh, pinned.lossless).codings, pinned.options, ThreadPool(2)));
    const uint64_t hash = fnv1a(encoded.pieces[0].bytes);
    EXPECT_TRUE(encoded.pieces[0].bytes.size() == pinned.bytes && hash == pinned.hash)
        << pinned.name << " is now " << encoded.pieces[0].bytes.size() << ", 0x" << std::hex
        << std::setfill('0') << std::setw(16) << hash << ", with libdraco " << draco_version();
  }
}

}  // namespace
}  // namespace psplit
