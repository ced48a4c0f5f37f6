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

TEST(ContainerBytes, AreThoseOfTheReleaseBefore) {
  const auto small = [] { return make_sheet(24, 20); };
  const auto large = [] { return make_sheet(120, 100); };
  const auto soup = [] { return named("soup with seams"); };
  const auto seams = [] { return named("chessboard of texture seams"); };
  const auto genus = [] { return named("torus chain of genus 144"); };
  const Pinned all[] = {
      {"one patch", small, {}, false, 3871, 0x95e6c047d809f645u},
      {"one patch, lossless", small, {}, true, 28247, 0x01e7c722cbf596b8u},
      {"4 patches at speed 0", small, {.patch_count = 4, .encode_speed = 0}, false, 8021, 0xad7ad7decb23644eu},
      {"4 patches at speed 10",
       small,
       {.patch_count = 4, .encode_speed = 10},
       false,
       8969,
       0x008c2945bdf5010bu},
      {"17 patches", large, {.patch_count = 17}, false, 87373, 0xbcaece9fb4de3ca0u},
      {"17 patches, lossless", large, {.patch_count = 17}, true, 695760, 0x6a799a35efd49807u},
      {"64 patches, borders as they are",
       large,
       {.patch_count = 64, .refine = false},
       false,
       132783,
       0xd2304295f0a61fdcu},
      {"9 patches by the paper's method",
       large,
       {.patch_count = 9, .method = PartitionMethod::kPaper},
       false,
       78551,
       0x05c2ba27a0612adcu},
      {"9 patches by geodesic distances",
       large,
       {.patch_count = 9, .method = PartitionMethod::kPaper, .distance = PathDistance::kGeodesic},
       false,
       78752,
       0x7df974a906267cd8u},
      {"residue", make_sheet_with_residue, {.patch_count = 5}, false, 14131, 0x8ff04ca587412b58u},
      {"residue with duplicates",
       make_sheet_with_residue,
       {.patch_count = 5, .keep_duplicates = true},
       false,
       14716,
       0x9e493fe107f61b3au},
      {"nothing left over",
       make_sheet_with_residue,
       {.patch_count = 5, .drop_degenerate = true, .drop_unused = true},
       false,
       13634,
       0x13f5a64f554c46f8u},
      {"seams", seams, {.patch_count = 3}, false, 3557, 0x48c49992726a04d5u},
      {"handles", genus, {.patch_count = 6}, false, 4161, 0x88a8452054b96043u},
      {"non-manifold", soup, {.patch_count = 3}, false, 8633, 0x21470a2466e5f176u},
      {"non-manifold, with duplicates",
       soup,
       {.patch_count = 3, .keep_duplicates = true},
       true,
       21408,
       0x2311b69e9abe3c23u},
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
