// The bytes of some encoded documents are pinned, as tests/encoder/container_bytes_test.cpp pins containers:
// here the choice of codings, grids shared by meshes, the number of patches and the kind of storage count too.
#include <iomanip>

#include "gltf_ext/primitive/accessors.h"
#include "psplit/document.h"
#include "tests/gltf_ext/asset.h"
#include "tests/support/reproducible_meshes.h"

namespace psplit {
namespace {

// Meshes of different extents, one with normals that are not of unit length and with feature ids.
Document document_of_sheets() {
  Document document = document_from_mesh(make_sheet(60, 50));
  add_mesh(document, make_sheet_with_residue());
  Mesh odd = make_sheet(20, 20);
  for (size_t at = 0; at < odd.attributes[1].values.size(); at += 12) {
    const std::array<float, 3> normal = {0, 0, 3};
    std::memcpy(odd.attributes[1].values.data() + at, normal.data(), 12);
  }
  odd.attributes.back().semantic = "_FEATURE_ID_0";
  add_mesh(document, odd);
  return document;
}

struct Pinned {
  const char* name;
  EncodeDocumentOptions options;
  size_t bytes;
  uint64_t hash;
};

TEST(DocumentBytes, AreAsPinned) {
  EncodeDocumentOptions patches, small, speed, scene, lossless, khr, paper, all, fallback;
  patches.patches.count = 12;
  small.patches.faces = 300;
  small.normal_bits = 12;
  speed.patches.count = 9;
  speed.encode_speed = 10;
  scene.volume = QuantizationVolume::kScene;
  lossless.lossless = true;
  lossless.patches.count = 6;
  khr.compat = Compat::kKhr;
  khr.patches.count = 10;
  paper.method = PartitionMethod::kPaper;
  paper.patches.count = 8;
  all.keep_degenerate = all.keep_unused = all.keep_duplicates = true;
  all.patches.count = 5;
  fallback.fallback = Fallback::kUncompressed;
  const Pinned pins[] = {{"default", {}, 33507, 0x2c68ed0986e57f4eu},
                         {"12 patches", patches, 42647, 0xc96365c7b89c51d4u},
                         {"patches of 300 faces", small, 60216, 0x0a6fff51e67aace3u},
                         {"speed 10", speed, 62838, 0x31603c88a4708cf0u},
                         {"one grid", scene, 33012, 0xe5ed348e6c643542u},
                         {"lossless", lossless, 267123, 0xb7df49db81df19a6u},
                         {"compat khr", khr, 40707, 0xe37584c2ab7f5396u},
                         {"paper's method", paper, 39567, 0xb59ea65ab69b8070u},
                         {"all is kept", all, 37311, 0x27c46a61c98615e0u},
                         {"fallback", fallback, 381628, 0x6d2eb997302caf04u}};
  for (const Pinned& pinned : pins) {
    Document document = document_of_sheets();
    const auto reports = must(encode_document(document, pinned.options, draco_backend(), test_pool()));
    size_t size = 0;
    std::vector<uint8_t> bytes;
    for (const std::span<const uint8_t> buffer : document.buffers) {
      size += buffer.size();
      bytes.insert(bytes.end(), buffer.begin(), buffer.end());
    }
    const uint64_t hash = fnv1a(bytes);
    EXPECT_TRUE(size == pinned.bytes && hash == pinned.hash)
        << pinned.name << " is now " << size << ", 0x" << std::hex << std::setfill('0') << std::setw(16) << hash
        << ", with libdraco " << draco_version();
  }
}

}  // namespace
}  // namespace psplit
