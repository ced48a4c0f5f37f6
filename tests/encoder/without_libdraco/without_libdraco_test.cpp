// A build without libdraco: psplit's own encoding and decoding do not change, and calls of the reference say
// that libdraco is missing.
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "encoder/encode_mesh.h"
#include "encoder/libdraco/draco_backend.h"
#include "psplit/encode.h"
#include "src/container/patch_container.h"
#include "tests/support/choose_codings.h"
#include "tests/support/stock_stream.h"

namespace psplit {
namespace {

constexpr const char* kReason = "PSPLIT_WITH_DRACO=OFF";

Mesh sheet() {
  constexpr uint32_t kSize = 12;
  Mesh mesh;
  std::vector<float> positions;
  for (uint32_t y = 0; y <= kSize; ++y)
    for (uint32_t x = 0; x <= kSize; ++x)
      for (const uint32_t value : {x, y, (3 * x + 5 * y) % 7}) positions.push_back(static_cast<float>(value));
  mesh.point_count = (kSize + 1) * (kSize + 1);
  for (uint32_t y = 0; y < kSize; ++y)
    for (uint32_t x = 0; x < kSize; ++x) {
      const uint32_t a = y * (kSize + 1) + x, b = a + 1, c = a + kSize + 1, d = c + 1;
      mesh.faces.push_back({a, b, d});
      mesh.faces.push_back({a, d, c});
    }
  Attribute& attribute = mesh.attributes.emplace_back();
  attribute.semantic = "POSITION";
  attribute.values.resize(positions.size() * sizeof(float));
  std::memcpy(attribute.values.data(), positions.data(), attribute.values.size());
  return mesh;
}

TEST(WithoutDraco, EncodesVerifiesAndDecodes) {
  EXPECT_FALSE(has_draco());
  Mesh mesh = sheet();
  const std::vector<AttributeCoding> codings = choose_codings(mesh, {});
  const ThreadPool pool(1);
  const Expected<EncodedMesh> encoded = encode_mesh(mesh, codings, {.patch_count = 3}, pool);
  ASSERT_TRUE(encoded) << encoded.status().to_string();
  EXPECT_EQ(encoded->statistics.patch_count, 3u);
  EXPECT_EQ(encoded->pieces[0].decoded.faces.size(), mesh.faces.size());
  const Expected<StockStream> stock = encode_stock_stream(mesh, codings, 5);
  ASSERT_TRUE(stock) << stock.status().to_string();
  EXPECT_EQ(stock->decoded.faces.size(), mesh.faces.size());
}

TEST(WithoutDraco, SaysWhatIsMissing) {
  Mesh mesh = sheet();
  const std::vector<AttributeCoding> codings = choose_codings(mesh, {});
  const ThreadPool pool(1);
  const auto refuses = [](const Status& status, StatusCode code) {
    EXPECT_EQ(status.code(), code);
    EXPECT_NE(status.to_string().find(kReason), std::string::npos) << status.to_string();
  };
  const StreamOptions by_libdraco{.patch_count = 3, .by_libdraco = true};
  refuses(encode_mesh(mesh, codings, by_libdraco, pool).status(), StatusCode::kUsage);
  refuses(encode_stock_stream(mesh, codings, 5, true).status(), StatusCode::kUsage);
  const Expected<StockStream> stock = encode_stock_stream(mesh, codings, 5);
  ASSERT_TRUE(stock);
  refuses(draco_backend().decode(open_stream(stock->bytes), stock->requests, pool).status(),
          StatusCode::kUnsupported);
  refuses(decode_draco_stream(stock->bytes, stock->requests).status(), StatusCode::kUnsupported);
  refuses(describe_draco_stream(stock->bytes).status(), StatusCode::kUnsupported);
}

}  // namespace
}  // namespace psplit
