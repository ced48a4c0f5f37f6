// Lossless means equal bits: for floats of every kind, at every speed, for whole documents and with both
// decoders.
#include "gltf_ext/convert/validate.h"
#include "psplit/decode.h"
#include "psplit/document.h"
#include "psplit/encode.h"
#include "tests/gltf_ext/asset.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/stock_stream.h"

namespace psplit {
namespace {

// Adds an attribute with the number of each point, so that points can be compared in any order.
Mesh labelled(Mesh mesh) {
  std::vector<uint16_t> labels;
  for (uint32_t point = 0; point < mesh.point_count; ++point) labels.push_back(static_cast<uint16_t>(point));
  mesh.attributes.push_back(make_attribute("_FEATURE_ID_0", ComponentType::kUint16, 1, false, labels));
  return mesh;
}

// The number of components of all attributes whose bits changed; all of them if points are missing.
size_t changed_components(const Mesh& before, const Mesh& after) {
  const std::vector<uint16_t> labels = values_of<uint16_t>(*after.find("_FEATURE_ID_0"));
  size_t changed = 0;
  std::vector<uint8_t> seen(before.point_count, 0);
  for (const uint16_t label : labels) ++seen.at(label);
  for (const uint8_t times : seen) changed += times != 1;
  for (const Attribute& wanted : before.attributes) {
    const Attribute& got = *after.find(wanted.semantic);
    const size_t stride = wanted.stride();
    EXPECT_EQ(got.stride(), stride);
    for (size_t point = 0; point < labels.size(); ++point)
      for (size_t at = 0; at < stride; ++at)
        changed += wanted.values[labels[point] * stride + at] != got.values[point * stride + at];
  }
  return changed;
}

TEST(Lossless, FloatsOfEveryKindComeBackAsTheSameBits) {
  const Mesh mesh = labelled(floats_of_every_kind());
  for (const int speed : {0, 5, 10})
    for (const uint64_t patches : {1u, 2u, 9u}) {
      SCOPED_TRACE("speed " + std::to_string(speed) + ", patches " + std::to_string(patches));
      Document document = document_from_mesh(mesh);
      const EncodeDocumentOptions options =
          DocumentOptions{.patches = {.count = patches}, .encode_speed = speed, .lossless = true};
      const auto reports = must(encode(document, options));
      EXPECT_EQ(reports.front().statistics.patch_count, patches);
      for (const DecodeBackend& backend : {cpu_backend(), draco_backend()}) {
        const auto decoded = must(read_primitive(document, {0, 0}, backend, test_pool()));
        ASSERT_EQ(decoded.point_count, mesh.point_count);
        EXPECT_EQ(changed_components(mesh, decoded), 0u) << backend.name;
        EXPECT_EQ(compare_meshes(mesh, decoded), "") << backend.name;
      }
    }
}

TEST(Lossless, OneStockStreamIsTheSameBitsToo) {
  const Mesh mesh = labelled(floats_of_every_kind());
  const std::vector<AttributeCoding> codings(mesh.attributes.size());
  const auto stock = must(encode_stock_stream(mesh, codings, 5));
  for (const DecodeBackend& backend : {cpu_backend(), draco_backend()}) {
    const auto decoded = must(decode_stream(backend, stock.bytes, stock.requests));
    EXPECT_EQ(changed_components(mesh, decoded), 0u) << backend.name;
  }
}

TEST(Lossless, DocumentsOfFloatsOfEveryKindAreValid) {
  Mesh mesh = labelled(floats_of_every_kind());
  // glTF allows no infinities and NaNs.
  std::erase_if(mesh.attributes, [](const Attribute& attribute) {
    return attribute.semantic != "POSITION" && attribute.semantic != "_FEATURE_ID_0";
  });
  Document document = document_from_mesh(mesh);
  const EncodeDocumentOptions options =
      DocumentOptions{.patches = {.count = 5}, .lossless = true, .fallback = Fallback::kUncompressed};
  ASSERT_TRUE(encode(document, options).ok());
  for (const DecodeBackend& backend : {cpu_backend(), draco_backend()})
    for (const Finding& finding : validate_document(document, backend, test_pool()))
      ADD_FAILURE() << backend.name << ": " << finding.message;
}

TEST(Lossless, TheTestWouldSeeOneBit) {
  const Mesh mesh = labelled(floats_of_every_kind());
  Mesh other = mesh;
  other.attributes[0].values[1000] ^= std::byte{1};
  EXPECT_EQ(changed_components(mesh, other), 1u);
}

// A mesh whose points have the attribute, point by point.
Document with_numbers(const char* semantic, const std::function<float(uint32_t)>& number) {
  Mesh mesh = labelled(make_grid(60, 60));
  std::vector<float> numbers;
  for (uint32_t point = 0; point < mesh.point_count; ++point) numbers.push_back(number(point));
  mesh.attributes.push_back(float_attribute(semantic, 1, numbers));
  return document_from_mesh(mesh);
}

size_t changed_numbers(const Document& document, const char* semantic,
                       const std::function<float(uint32_t)>& number) {
  const Mesh mesh = must(read(document));
  const std::vector<uint16_t> labels = values_of<uint16_t>(*mesh.find("_FEATURE_ID_0"));
  const std::vector<float> numbers = values_of<float>(*mesh.find(semantic));
  size_t changed = 0;
  for (size_t i = 0; i < labels.size(); ++i) changed += numbers[i] != number(labels[i]);
  return changed;
}

// Whole numbers name things.
TEST(WholeNumbers, ComeBackWithoutAnOption) {
  for (const char* semantic : {"_BATCH_ID", "_FEATURE_ID_1", "_OBJECTID", "_ANY"})
    for (const float step : {1.0f, 7.0f, 4096.0f, 12345.0f, 1e6f}) {
      const auto number = [&](uint32_t point) { return 5 + step * static_cast<float>(point); };
      for (const bool condense : {false, true}) {
        Document document = with_numbers(semantic, number);
        EncodeDocumentOptions options;
        options.condense = condense ? Condense::kFast : Condense::kNo;
        const auto reports = must(encode(document, options));
        EXPECT_TRUE(reports[0].warnings.empty());
        EXPECT_EQ(changed_numbers(document, semantic, number), 0u) << semantic << " " << step;
      }
    }
}

TEST(WholeNumbers, AreRoundedToBitsThatAreGivenWithAWarning) {
  const auto number = [](uint32_t point) { return static_cast<float>(3 * point); };
  EncodeDocumentOptions options = DocumentOptions{.generic_bits = 8};
  options.given.generic = true;
  Document document = with_numbers("_ANY", number);
  const auto reports = must(encode(document, options));
  EXPECT_EQ(reports[0].warnings,
            std::vector<std::string>{
                "_ANY: its whole numbers are rounded to a grid of 8 bits; 14 bits would keep them"});
  EXPECT_GT(changed_numbers(document, "_ANY", number), 3000u);
  options.generic_bits = 14;
  Document enough = with_numbers("_ANY", number);
  EXPECT_TRUE(must(encode(enough, options))[0].warnings.empty());
  EXPECT_EQ(changed_numbers(enough, "_ANY", number), 0u);
}

}  // namespace
}  // namespace psplit
