// The functions for Blender's add-on give libdraco's values, and write streams that libdraco decodes.
#include <filesystem>
#include <fstream>
#include <iterator>

#include "bindings/c/blender/bridge.h"
#include "encoder/coding/choose_codings.h"
#include "encoder/libdraco/draco_backend.h"
#include "psplit/encode.h"
#include "tests/support/corpus_folder.h"
#include "tests/support/draco_clouds.h"
#include "tests/support/draco_streams.h"
#include "tests/support/expect.h"
#include "tests/support/mutants.h"
#include "tests/support/patched_samples.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/stock_stream.h"

namespace psplit {
namespace {

using DecoderHandle = std::unique_ptr<Decoder, decltype(&decoderRelease)>;
using EncoderHandle = std::unique_ptr<Encoder, decltype(&encoderRelease)>;

DecoderHandle make_decoder() { return {decoderCreate(), decoderRelease}; }
bool decode_bytes_of(Decoder* decoder, std::vector<uint8_t> bytes) {
  return decoderDecode(decoder, bytes.data(), bytes.size());
}

std::string element_type_of(int components) {
  return components == 1    ? "SCALAR"
         : components <= 4  ? "VEC" + std::to_string(components)
         : components == 9  ? "MAT3"
         : components == 16 ? "MAT4"
                            : "";
}

// Nothing if the type cannot be read.
std::optional<std::vector<uint8_t>> read_attribute_of(Decoder* decoder, uint32_t id, ComponentType type,
                                                      std::string element_type) {
  if (!decoderReadAttribute(decoder, id, static_cast<size_t>(type), element_type.data())) return std::nullopt;
  std::vector<uint8_t> values(decoderGetAttributeByteLength(decoder, id));
  decoderCopyAttribute(decoder, id, values.data());
  return values;
}

std::vector<uint8_t> indices_of(const RawMesh& mesh, size_t bytes) {
  std::vector<uint8_t> indices;
  for (const auto& face : mesh.faces)
    for (const uint32_t point : face) {
      const auto* const begin = reinterpret_cast<const uint8_t*>(&point);
      indices.insert(indices.end(), begin, begin + bytes);
    }
  return indices;
}

// Compares everything that a stream decodes to, in every type of glTF, with libdraco.
void expect_libdracos(const std::vector<uint8_t>& stream) {
  const RawMesh expected = must(decode_with_libdraco(stream));
  const DecoderHandle decoder = make_decoder();
  ASSERT_TRUE(decode_bytes_of(decoder.get(), stream));
  EXPECT_EQ(decoderGetVertexCount(decoder.get()), expected.point_count);
  EXPECT_EQ(decoderGetIndexCount(decoder.get()), 3 * expected.faces.size());
  for (const auto& [type, bytes] : {std::pair(5125, 4), std::pair(5123, 2), std::pair(5121, 1)}) {
    const bool fits = bytes == 4 || expected.point_count <= 1u << 8 * bytes;
    if (!fits) continue;
    ASSERT_TRUE(decoderReadIndices(decoder.get(), static_cast<size_t>(type)));
    std::vector<uint8_t> indices(decoderGetIndicesByteLength(decoder.get()));
    decoderCopyIndices(decoder.get(), indices.data());
    EXPECT_EQ(indices, indices_of(expected, static_cast<size_t>(bytes)));
  }
  for (const RawAttribute& attribute : expected.attributes) {
    EXPECT_EQ(decoderAttributeIsNormalized(decoder.get(), attribute.unique_id), attribute.normalized);
    const std::string element_type = element_type_of(attribute.component_count);
    if (element_type.empty()) continue;
    for (const ComponentType type : {ComponentType::kInt8, ComponentType::kUint8, ComponentType::kInt16,
                                     ComponentType::kUint16, ComponentType::kUint32, ComponentType::kFloat32}) {
      const AttributeRequest request{"", attribute.unique_id, type,
                                     static_cast<uint8_t>(attribute.component_count), false};
      const Expected<Mesh> mesh = decode_draco_stream(stream, {&request, 1});
      const auto values = read_attribute_of(decoder.get(), attribute.unique_id, type, element_type);
      ASSERT_EQ(values.has_value(), mesh.ok()) << static_cast<int>(type);
      if (!values) continue;
      const auto* const begin = reinterpret_cast<const uint8_t*>(mesh->attributes[0].values.data());
      EXPECT_EQ(*values, std::vector<uint8_t>(begin, begin + mesh->attributes[0].values.size()));
    }
  }
}

TEST(Blender, DecodesWhatLibdracoDecodes) {
  size_t count = 0;
  for (const DracoStream& stream : small_draco_streams()) {
    if (count++ % 9 != 0) continue;
    SCOPED_TRACE(stream.name);
    expect_libdracos(stream.bytes);
  }
  EXPECT_GT(count, 100u);
}

TEST(Blender, DecodesOlderStreamsOfTheCorpus) {
  const std::filesystem::path folder = corpus_folder() / "mesh" / "draco";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no corpus";
  size_t old = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".drc") continue;
    SCOPED_TRACE(entry.path().filename());
    std::ifstream file(entry.path(), std::ios::binary);
    const std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
    if (bytes.size() > 100000) continue;
    const std::optional<RawMesh> expected = decode_with_libdraco(bytes);
    if (!expected) continue;
    old += bytes[5] < 2 || bytes[6] < 2;
    // Streams before 1.3 have no ids: describe_draco_stream gives attributes their places.
    expect_libdracos(bytes);
  }
  EXPECT_GT(old, 0u);
}

TEST(Blender, RefusesWhatIsNoMesh) {
  const DecoderHandle decoder = make_decoder();
  EXPECT_FALSE(decode_bytes_of(decoder.get(), small_draco_clouds().front().bytes));
  EXPECT_FALSE(decode_bytes_of(decoder.get(), {}));
  EXPECT_FALSE(decoderDecode(decoder.get(), nullptr, 5));
  EXPECT_FALSE(decoderDecode(nullptr, nullptr, 0));
  EXPECT_EQ(decoderGetVertexCount(decoder.get()), 0u);
  std::vector<uint8_t> bytes = small_draco_streams().front().bytes;
  ASSERT_TRUE(decode_bytes_of(decoder.get(), bytes));
  const uint32_t id = must(decode_with_libdraco(bytes)).attributes[0].unique_id;
  std::string vec3 = "VEC3", vec2 = "VEC2", unknown = "VEC5";
  EXPECT_TRUE(decoderReadAttribute(decoder.get(), id, 5126, vec3.data()));
  EXPECT_FALSE(decoderReadAttribute(decoder.get(), id, 5126, vec2.data()));
  EXPECT_FALSE(decoderReadAttribute(decoder.get(), id, 5126, unknown.data()));
  EXPECT_FALSE(decoderReadAttribute(decoder.get(), id, 5126, nullptr));
  EXPECT_FALSE(decoderReadAttribute(decoder.get(), id, 5124, vec3.data()));
  EXPECT_FALSE(decoderReadAttribute(decoder.get(), 12345, 5126, vec3.data()));
  EXPECT_EQ(decoderGetAttributeByteLength(decoder.get(), 12345), 0u);
  EXPECT_FALSE(decoderReadIndices(decoder.get(), 5126));
  EXPECT_FALSE(decoderReadIndices(nullptr, 5125));
}

TEST(Blender, TruncationsAreRefused) {
  const StockStream stream = must(encode_stock_stream(make_grid(5, 5), std::vector<AttributeCoding>(1), 5));
  const DecoderHandle decoder = make_decoder();
  for_each_truncation(stream.bytes, [&](std::vector<uint8_t> part) {
    EXPECT_FALSE(decoderDecode(decoder.get(), part.data(), part.size()));
  });
}

TEST(Blender, IndicesMustFitTheirType) {
  const Mesh mesh = make_grid(20, 20);
  const StockStream stream = must(encode_stock_stream(mesh, std::vector<AttributeCoding>(1), 5));
  const DecoderHandle decoder = make_decoder();
  ASSERT_TRUE(decode_bytes_of(decoder.get(), stream.bytes));
  EXPECT_FALSE(decoderReadIndices(decoder.get(), 5121));
  EXPECT_FALSE(decoderReadIndices(decoder.get(), 5120));
  EXPECT_TRUE(decoderReadIndices(decoder.get(), 5122));
}

// Encodes as the add-on does. Attributes are set in the order of the mesh.
struct Encoding {
  EncoderHandle encoder{nullptr, encoderRelease};
  std::vector<uint32_t> ids{};
  bool is_encoded = false;
  std::vector<uint8_t> bytes{};
};
Encoding encode_as_blender(const Mesh& mesh, bool keeps_order) {
  Encoding encoding;
  encoding.encoder.reset(encoderCreate(mesh.point_count));
  Encoder* const encoder = encoding.encoder.get();
  for (const Attribute& attribute : mesh.attributes) {
    std::string name = attribute.semantic, type = element_type_of(attribute.component_count);
    Array<std::byte> values = attribute.values;
    encoding.ids.push_back(encoderSetAttribute(
        encoder, name.data(), static_cast<size_t>(attribute.component_type), type.data(), values.data()));
  }
  std::vector<std::array<uint32_t, 3>> faces(mesh.faces.begin(), mesh.faces.end());
  encoderSetIndices(encoder, 5125, static_cast<uint32_t>(3 * faces.size()), faces.data());
  encoderSetCompressionLevel(encoder, 6);
  encoderSetQuantizationBits(encoder, 14, 10, 12, 10, 12);
  encoding.is_encoded = encoderEncode(encoder, keeps_order);
  encoding.bytes.resize(encoderGetByteLength(encoder));
  encoderCopy(encoder, encoding.bytes.data());
  return encoding;
}

TEST(Blender, EncodesWhatTheEncoderEncodes) {
  size_t encoded = 0;
  for (const auto& [name, mesh] : all_meshes()) {
    SCOPED_TRACE(name);
    for (const bool keeps_order : {false, true}) {
      const Encoding encoding = encode_as_blender(mesh, keeps_order);
      Mesh coded = mesh;
      for (Attribute& attribute : coded.attributes)
        attribute.normalized =
            attribute.component_type != ComponentType::kFloat32 &&
            (attribute.semantic.starts_with("COLOR_") || attribute.semantic.starts_with("TEXCOORD_") ||
             attribute.semantic.starts_with("WEIGHTS_"));
      EncodeOptions options;
      options.color_bits = 10;
      options.given = {true, true, true, true, true};  // Blender states them
      options.storage = keeps_order ? Storage::kInOrder : Storage::kOneStream;
      options.keep_duplicates = true;
      options.encode_speed = 4;
      if (!encoding.is_encoded) {
        EXPECT_TRUE(encoding.bytes.empty());
        EXPECT_EQ(encoderGetEncodedVertexCount(encoding.encoder.get()), 0u);
        continue;
      }
      const EncodedMesh expected = must(encode(coded, options, ThreadPool(1)));
      EXPECT_EQ(encoding.bytes, expected.pieces[0].bytes);
      for (size_t k = 0; k < encoding.ids.size(); ++k)
        EXPECT_EQ(encoding.ids[k], expected.requests[k].unique_id);
      const RawMesh decoded = must(decode_with_libdraco(encoding.bytes));
      EXPECT_EQ(encoderGetEncodedVertexCount(encoding.encoder.get()), decoded.point_count);
      EXPECT_EQ(encoderGetEncodedIndexCount(encoding.encoder.get()), 3 * decoded.faces.size());
      if (keeps_order) {
        EXPECT_EQ(decoded.point_count, mesh.point_count);
        EXPECT_TRUE(std::ranges::equal(decoded.faces, mesh.faces));
      }
      ++encoded;
    }
  }
  EXPECT_GT(encoded, 40u);
}

TEST(Blender, IdsAreThoseOfTheStreamInAnyOrder) {
  Mesh mesh = make_grid(4, 4);
  std::vector<float> values(size_t{2} * mesh.point_count);
  for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 7);
  mesh.attributes.insert(mesh.attributes.begin(), float_attribute("TEXCOORD_0", 2, values));
  mesh.attributes.push_back(float_attribute("_WEAR", 2, values));
  const Encoding encoding = encode_as_blender(mesh, false);
  ASSERT_TRUE(encoding.is_encoded);
  EXPECT_EQ(encoding.ids, (std::vector<uint32_t>{1, 0, 2}));
  const RawMesh decoded = must(decode_with_libdraco(encoding.bytes));
  for (const RawAttribute& attribute : decoded.attributes)
    EXPECT_EQ(attribute.component_count, attribute.unique_id == 0 ? 3 : 2);
}

TEST(Blender, WrongArgumentsAreNotEncoded) {
  const auto is_encoded = [](auto change) {
    const EncoderHandle encoder(encoderCreate(3), encoderRelease);
    std::string position = "POSITION", vec3 = "VEC3";
    std::vector<float> values = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    std::vector<uint16_t> indices = {0, 1, 2};
    encoderSetAttribute(encoder.get(), position.data(), 5126, vec3.data(), values.data());
    encoderSetIndices(encoder.get(), 5123, 3, indices.data());
    change(encoder.get(), values);
    return encoderEncode(encoder.get(), 0);
  };
  using Values = std::vector<float>&;
  EXPECT_TRUE(is_encoded([](Encoder*, Values) {}));
  std::string name = "_A", scalar = "SCALAR", unknown = "VEC7", position = "POSITION", vec3 = "VEC3";
  std::vector<uint16_t> outside = {0, 1, 3};
  EXPECT_FALSE(is_encoded([&](Encoder* e, Values) { encoderSetIndices(e, 5123, 3, outside.data()); }));
  EXPECT_FALSE(is_encoded([&](Encoder* e, Values) { encoderSetIndices(e, 5126, 3, outside.data()); }));
  EXPECT_FALSE(is_encoded([&](Encoder* e, Values) { encoderSetIndices(e, 5123, 3, nullptr); }));
  EXPECT_FALSE(is_encoded([&](Encoder* e, Values) { encoderSetIndices(e, 5123, 0, nullptr); }));
  EXPECT_FALSE(is_encoded(
      [&](Encoder* e, Values v) { encoderSetAttribute(e, name.data(), 5124, scalar.data(), v.data()); }));
  EXPECT_FALSE(is_encoded(
      [&](Encoder* e, Values v) { encoderSetAttribute(e, name.data(), 5126, unknown.data(), v.data()); }));
  EXPECT_FALSE(is_encoded(
      [&](Encoder* e, Values) { encoderSetAttribute(e, name.data(), 5126, scalar.data(), nullptr); }));
  EXPECT_FALSE(is_encoded(
      [&](Encoder* e, Values v) { encoderSetAttribute(e, nullptr, 5126, scalar.data(), v.data()); }));
  EXPECT_FALSE(is_encoded(
      [&](Encoder* e, Values v) { encoderSetAttribute(e, position.data(), 5126, vec3.data(), v.data()); }));
  EXPECT_TRUE(is_encoded(
      [&](Encoder* e, Values v) { encoderSetAttribute(e, name.data(), 5126, scalar.data(), v.data()); }));
  EXPECT_TRUE(is_encoded([&](Encoder* e, Values) { encoderSetQuantizationBits(e, 99, 1, 0, 0, 0); }));
  EXPECT_TRUE(is_encoded([&](Encoder* e, Values) { encoderSetCompressionLevel(e, 99); }));
  EXPECT_FALSE(encoderEncode(nullptr, 0));
  EXPECT_EQ(encoderGetByteLength(nullptr), 0u);
}

}  // namespace
}  // namespace psplit
