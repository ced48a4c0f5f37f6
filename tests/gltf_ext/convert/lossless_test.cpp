// Lossless means equal bits: for floats of every kind, at every speed, for whole documents and with both
// decoders.
#include "encoder/stock_stream.h"
#include "gltf_ext/convert/document_from_mesh.h"
#include "gltf_ext/convert/validate.h"
#include "src/cpu/cpu_backend.h"
#include "tests/gltf_ext/asset.h"
#include "tests/support/decode_bytes.h"

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
      const EncodeDocumentOptions options{
          .patches = {.count = patches}, .encode_speed = speed, .lossless = true};
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
  const EncodeDocumentOptions options{
      .patches = {.count = 5}, .lossless = true, .fallback = Fallback::kUncompressed};
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

}  // namespace
}  // namespace psplit
