#include "tools/gltf_psplit/compare/asset_parts.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "gltf_ext/json/json.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

// Two primitives of 3 points that share their positions, an image in a buffer, an image in the JSON, and 100
// bytes that nothing refers to.
Document sample() {
  Document document;
  document.source = "-";
  document.json() = Json::parse(R"({
    "asset": {"version": "2.0"},
    "buffers": [{"byteLength": 230}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 24},
                    {"buffer": 0, "byteOffset": 60, "byteLength": 70}],
    "accessors": [
      {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3},
      {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": 3},
      {"bufferView": 1, "byteOffset": 12, "componentType": 5125, "type": "SCALAR", "count": 3}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1},
                               {"attributes": {"POSITION": 0}, "indices": 2}]}],
    "images": [{"bufferView": 2, "mimeType": "image/png"}, {"bufferView": 2, "mimeType": "image/png"},
               {"uri": "data:image/png;base64,AAAA"}]})");
  return document;
}

TEST(AssetParts, CountsEveryByteOnce) {
  const Document document = sample();
  const std::vector<PrimitiveId> all{{0, 0}, {0, 1}};
  const AssetParts parts = measure_parts(document, all);
  const size_t json_bytes = document.json().dump().size();
  EXPECT_EQ(parts.meshes, 36u + 12 + 12);
  EXPECT_EQ(parts.textures, 70u + 26);
  EXPECT_EQ(parts.rest, 100u + json_bytes - 26);
  EXPECT_EQ(parts.total(), 230u + json_bytes);
  EXPECT_EQ(parts.missing_images, 0u);
  // Primitives that are not requested count as the rest.
  const AssetParts first = measure_parts(document, std::span(all).first(1));
  EXPECT_EQ(first.meshes, 36u + 12);
  EXPECT_EQ(first.total(), parts.total());
}

TEST(AssetParts, CountsImagesBesideTheAssetAndTellsOfMissingOnes) {
  const TestFolder folder;
  std::ofstream(folder / "a texture.png") << std::string(1234, 'x');
  Document document = sample();
  const uint64_t before = measure_parts(document, {}).textures;
  document.source = folder / "asset.gltf";
  for (const char* uri : {"a%20texture.png", "a%20texture.png", "none.png"})
    document.json()["images"].push_back({{"uri", uri}});
  const AssetParts parts = measure_parts(document, {});
  EXPECT_EQ(parts.textures, before + 1234);
  EXPECT_EQ(parts.missing_images, 1u);
}

TEST(AssetParts, TakesOverlappingAccessorsForNoNegativeRest) {
  Document document = sample();
  document.json()["accessors"][2]["byteOffset"] = 0;  // the bytes of accessor 1
  document.json()["bufferViews"][2]["byteOffset"] = 36;
  document.json()["buffers"][0]["byteLength"] = 36 + 70;
  const std::vector<PrimitiveId> all{{0, 0}, {0, 1}};
  EXPECT_LT(measure_parts(document, all).rest, document.json().dump().size());
}

}  // namespace
}  // namespace psplit
