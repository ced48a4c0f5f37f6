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

#include "encoder/coding/quantization.h"
#include "encoder/draco/draco_backend.h"
#include "encoder/encode_mesh.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/reproducible_meshes.h"

namespace psplit {
namespace {

Mesh named(const std::string& name) {
  for (NamedMesh& nasty : nasty_meshes())
    if (nasty.name == name) return std::move(nasty.mesh);
  ADD_FAILURE() << name;
  return make_grid(1, 1);
}

std::vector<AttributeCoding> codings_of(const Mesh& mesh, bool lossless) {
  std::vector<AttributeCoding> codings(mesh.attributes.size());
  for (size_t i = 0; i < codings.size() && !lossless; ++i) {
    const Attribute& attribute = mesh.attributes[i];
    if (attribute.semantic == "NORMAL")
      codings[i] = {10, true, {}, 0};
    else if (attribute.component_type == ComponentType::kFloat32)
      codings[i] = *fit_grid(attribute, attribute.semantic == "POSITION" ? 14 : 12);
  }
  return codings;
}

struct Pinned {
  const char* name;
  std::function<Mesh()> mesh;
  EncodeOptions options;
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
      {"one patch", small, {}, false, 3896, 0x1df75c3f3214d2cau},
      {"one patch, lossless", small, {}, true, 28272, 0xe63a7fcdeb70f8aau},
      {"4 patches at speed 0", small, {.patch_count = 4, .encode_speed = 0}, false, 8056, 0xf0b2bbc17a9b9911u},
      {"4 patches at speed 10",
       small,
       {.patch_count = 4, .encode_speed = 10},
       false,
       9003,
       0x18520671a32d6a47u},
      {"17 patches", large, {.patch_count = 17}, false, 87457, 0x2c1f8dc301d35010u},
      {"17 patches, lossless", large, {.patch_count = 17}, true, 695846, 0x20c17ba6f5832199u},
      {"64 patches, borders as they are",
       large,
       {.patch_count = 64, .refine = false},
       false,
       132937,
       0xa433b3ceb24fea8fu},
      {"9 patches by the paper's method",
       large,
       {.patch_count = 9, .method = PartitionMethod::kPaper},
       false,
       78611,
       0x1e2a0ffe1c829da4u},
      {"9 patches by geodesic distances",
       large,
       {.patch_count = 9, .method = PartitionMethod::kPaper, .distance = PathDistance::kGeodesic},
       false,
       78805,
       0xd77907e8bb5dde07u},
      {"residue", make_sheet_with_residue, {.patch_count = 5}, false, 14187, 0xb8dfa0730c1ac2ddu},
      {"residue with duplicates",
       make_sheet_with_residue,
       {.patch_count = 5, .keep_duplicates = true},
       false,
       14771,
       0x63a6f4c855ca11f3u},
      {"residue on its own",
       make_sheet_with_residue,
       {.patch_count = 5, .standalone_residue = true},
       false,
       15290,
       0xd6cc99a7e0ee2bd3u},
      {"nothing left over",
       make_sheet_with_residue,
       {.patch_count = 5, .drop_degenerate = true, .drop_unused = true},
       false,
       13685,
       0xd8b893b1fcd30e92u},
      {"seams", seams, {.patch_count = 3}, false, 3589, 0x35e5c0bb344e1256u},
      {"handles", genus, {.patch_count = 6}, false, 4208, 0x4b6fc1f57fd0125au},
      {"non-manifold", soup, {.patch_count = 3}, false, 8672, 0xe384be20e6b74816u},
      {"non-manifold, with duplicates",
       soup,
       {.patch_count = 3, .keep_duplicates = true},
       true,
       21446,
       0x3c7819d57ca69733u},
  };
  for (const Pinned& pinned : all) {
    const Mesh mesh = pinned.mesh();
    const auto encoded = encode_mesh(mesh, codings_of(mesh, pinned.lossless), pinned.options, ThreadPool(2));
    ASSERT_TRUE(encoded.ok()) << pinned.name << ": " << encoded.status().to_string();
    const uint64_t hash = fnv1a(encoded->container);
    EXPECT_TRUE(encoded->container.size() == pinned.bytes && hash == pinned.hash)
        << pinned.name << " is now " << encoded->container.size() << ", 0x" << std::hex << std::setfill('0')
        << std::setw(16) << hash << ", with libdraco " << draco_version();
  }
}

}  // namespace
}  // namespace psplit
