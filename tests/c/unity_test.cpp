// The functions for Unity's package give libdraco's values, in Unity's coordinates if they are asked to.
#include <algorithm>
#include <cstring>
#include <memory>

#include "bindings/c/unity/encoder.h"
#include "bindings/c/unity/plugin.h"
#include "tests/support/draco_clouds.h"
#include "tests/support/draco_streams.h"
#include "tests/support/draco_subject.h"
#include "tests/support/expect.h"

namespace psplit {
namespace {

using Bytes = std::vector<uint8_t>;

// A decoded mesh, as the package holds it. Null if it does not decode.
struct UnityMesh {
  explicit UnityMesh(const Bytes& bytes) {
    void *decoder = nullptr, *buffer = nullptr;
    code = DecodeDracoMeshStep1(reinterpret_cast<const char*>(bytes.data()),
                                static_cast<uint32_t>(bytes.size()), &mesh, &decoder, &buffer);
    if (code == 0) {
      EXPECT_NE(decoder, nullptr);  // the package asserts it
      EXPECT_NE(buffer, nullptr);
    }
    if (code == 0) code = DecodeDracoMeshStep2(&mesh, decoder, buffer);
  }
  ~UnityMesh() {
    ReleaseDracoMesh(&mesh);
    EXPECT_EQ(mesh, nullptr);
  }
  DracoMesh* mesh = nullptr;
  int32_t code = 0;
};

// Nothing if the plugin does not give it.
std::optional<Bytes> data_of(const DracoMesh* mesh, const DracoAttribute* attribute, bool flip, int32_t stride,
                             size_t component_bytes) {
  DracoData* data = nullptr;
  if (!GetAttributeData(mesh, attribute, &data, flip, stride)) return std::nullopt;
  EXPECT_EQ(data->dataType, attribute->dataType);
  const auto* begin = static_cast<const uint8_t*>(data->data);
  const size_t size = static_cast<size_t>(mesh->numVertices) * static_cast<size_t>(stride) * component_bytes;
  Bytes bytes(begin, begin + size);
  ReleaseDracoData(&data);
  EXPECT_EQ(data, nullptr);
  return bytes;
}

void expect_equal(const DracoStream& stream, const RawMesh& expected, bool is_cloud) {
  SCOPED_TRACE(stream.name);
  const UnityMesh unity(stream.bytes);
  ASSERT_EQ(unity.code, 0);
  const DracoMesh* const mesh = unity.mesh;
  EXPECT_EQ(mesh->isPointCloud, is_cloud);
  EXPECT_EQ(mesh->numVertices, static_cast<int32_t>(expected.point_count));
  ASSERT_EQ(mesh->numFaces, static_cast<int32_t>(expected.faces.size()));
  ASSERT_EQ(mesh->numAttributes, static_cast<int32_t>(expected.attributes.size()));
  std::vector<std::array<uint32_t, 3>> faces(expected.faces.size() + 1);
  const auto count = static_cast<uint32_t>(3 * expected.faces.size());
  EXPECT_TRUE(GetMeshIndices(mesh, 6, faces.data(), count, false));
  faces.pop_back();
  EXPECT_TRUE(faces == expected.faces);
  for (size_t i = 0; i < expected.attributes.size(); ++i) {
    const RawAttribute& raw = expected.attributes[i];
    DracoAttribute* attribute = nullptr;
    ASSERT_TRUE(GetAttribute(mesh, static_cast<int32_t>(i), &attribute));
    EXPECT_EQ(attribute->attributeType, raw.type);
    EXPECT_EQ(attribute->dataType, raw.data_type);
    EXPECT_EQ(attribute->numComponents, raw.component_count);
    EXPECT_EQ(attribute->uniqueId, static_cast<int32_t>(raw.unique_id));
    const size_t values = static_cast<size_t>(raw.component_count) * expected.point_count;
    const size_t component_bytes = values == 0 ? 1 : raw.point_values.size() / values;
    const auto data = data_of(mesh, attribute, false, raw.component_count, component_bytes);
    const bool is_given = raw.component_count <= 4 && (raw.data_type <= 6 || raw.data_type == 9);
    EXPECT_EQ(data.has_value(), is_given);
    if (data) {
      EXPECT_TRUE(*data == raw.point_values);
    }
    ReleaseDracoAttribute(&attribute);
    EXPECT_EQ(attribute, nullptr);
  }
}

TEST(UnityPlugin, GivesLibdracosMeshes) {
  for (const DracoStream& stream : small_draco_streams())
    expect_equal(stream, must(decode_with_libdraco(stream.bytes)), false);
}

TEST(UnityPlugin, GivesLibdracosPointClouds) {
  for (const DracoStream& stream : small_draco_clouds())
    expect_equal(stream, must(decode_cloud_with_libdraco(stream.bytes)), true);
}

// The first stream that has an attribute of a type.
const DracoStream& stream_with(int32_t type) {
  for (const DracoStream& stream : small_draco_streams()) {
    const UnityMesh unity(stream.bytes);
    DracoAttribute* attribute = nullptr;
    if (!GetAttributeByType(unity.mesh, type, 0, &attribute)) continue;
    const bool is_float = attribute->dataType == 9;
    ReleaseDracoAttribute(&attribute);
    if (is_float) return stream;
  }
  throw std::runtime_error("no such stream");
}

TEST(UnityPlugin, TurnsCoordinatesIntoUnitys) {
  constexpr int32_t kPosition = 0, kTexCoord = 3;
  for (const int32_t type : {kPosition, kTexCoord}) {
    const UnityMesh unity(stream_with(type).bytes);
    DracoAttribute* attribute = nullptr;
    ASSERT_TRUE(GetAttributeByType(unity.mesh, type, 0, &attribute));
    DracoAttribute* same = nullptr;
    ASSERT_TRUE(GetAttributeByUniqueId(unity.mesh, attribute->uniqueId, &same));
    EXPECT_EQ(same->privateAttribute, attribute->privateAttribute);
    const int32_t components = attribute->numComponents, stride = components + 1;
    const Bytes plain = must(data_of(unity.mesh, attribute, false, components, sizeof(float)));
    const Bytes flipped = must(data_of(unity.mesh, attribute, true, stride, sizeof(float)));
    for (int32_t point = 0; point < unity.mesh->numVertices; ++point)
      for (int32_t k = 0; k < stride; ++k) {
        float expected = 0, seen = 0;
        if (k < components)
          std::memcpy(&expected, &plain[sizeof(float) * static_cast<size_t>(point * components + k)],
                      sizeof expected);
        if (components == 3 && k == 0) expected = -expected;
        if (components == 2 && k == 1) expected = 1 - expected;
        std::memcpy(&seen, &flipped[sizeof(float) * static_cast<size_t>(point * stride + k)], sizeof seen);
        EXPECT_EQ(seen, expected);
      }
    ReleaseDracoAttribute(&same);
    ReleaseDracoAttribute(&attribute);
  }
  const UnityMesh unity(stream_with(kPosition).bytes);
  const auto count = static_cast<uint32_t>(3 * unity.mesh->numFaces);
  std::vector<uint32_t> plain(count);
  std::vector<uint16_t> flipped(count);
  ASSERT_TRUE(GetMeshIndices(unity.mesh, 6, plain.data(), count, false));
  ASSERT_TRUE(GetMeshIndices(unity.mesh, 4, flipped.data(), count, true));
  for (size_t corner = 0; corner < count; corner += 3) {
    EXPECT_EQ(flipped[corner], plain[corner]);
    EXPECT_EQ(flipped[corner + 1], plain[corner + 2]);
    EXPECT_EQ(flipped[corner + 2], plain[corner + 1]);
  }
}

TEST(UnityPlugin, RefusesWhatItCannotDo) {
  const Bytes& bytes = stream_with(0).bytes;
  for (size_t size = 0; size < bytes.size(); size += 3)
    EXPECT_LT(UnityMesh(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size))).code, 0);
  UnityMesh unity(bytes);
  void *decoder = nullptr, *buffer = nullptr;
  const auto* const data = reinterpret_cast<const char*>(bytes.data());
  const auto length = static_cast<uint32_t>(bytes.size());
  EXPECT_EQ(DecodeDracoMeshStep1(data, length, &unity.mesh, &decoder, &buffer), -1);  // not null
  EXPECT_EQ(DecodeDracoMeshStep1(nullptr, 0, nullptr, &decoder, &buffer), -1);
  EXPECT_LT(DecodeDracoMeshStep2(nullptr, nullptr, nullptr), 0);
  DracoAttribute* attribute = nullptr;
  EXPECT_FALSE(GetAttribute(unity.mesh, unity.mesh->numAttributes, &attribute));
  EXPECT_FALSE(GetAttribute(unity.mesh, -1, &attribute));
  EXPECT_FALSE(GetAttributeByType(unity.mesh, 7, 0, &attribute));
  EXPECT_FALSE(GetAttributeByUniqueId(unity.mesh, 12345, &attribute));
  EXPECT_FALSE(GetAttribute(nullptr, 0, &attribute));
  EXPECT_EQ(attribute, nullptr);
  ASSERT_TRUE(GetAttribute(unity.mesh, 0, &attribute));
  EXPECT_FALSE(GetAttribute(unity.mesh, 0, &attribute));  // not null
  DracoData* values = nullptr;
  EXPECT_FALSE(GetAttributeData(unity.mesh, attribute, &values, false, attribute->numComponents - 1));
  EXPECT_FALSE(GetAttributeData(unity.mesh, nullptr, &values, false, 3));
  EXPECT_EQ(values, nullptr);
  uint32_t index = 0;
  EXPECT_FALSE(GetMeshIndices(unity.mesh, 6, &index, 1, false));
  EXPECT_FALSE(GetMeshIndices(unity.mesh, 9, &index, 1'000'000, false));
  ReleaseDracoAttribute(&attribute);
  ReleaseDracoAttribute(&attribute);
  ReleaseDracoData(&values);
  ReleaseDracoMesh(nullptr);
}

struct ReleaseEncoder {
  void operator()(UnityEncoder* encoder) const { dracoEncoderRelease(encoder); }
};
using OwnedEncoder = std::unique_ptr<UnityEncoder, ReleaseEncoder>;

// A square of four vertices, each with a position, two bytes of a gap and a joint index, as Unity has them.
struct UnityVertex {
  float position[3];
  uint16_t joint, gap;
};
constexpr UnityVertex kVertices[] = {
    {{0, 0, 1}, 7, 1}, {{1, 0, 2}, 8, 1}, {{0, 1, 3}, 9, 1}, {{1, 1, 4}, 300, 1}};
constexpr uint16_t kIndices[] = {0, 1, 2, 2, 1, 3};

OwnedEncoder encoder_of_square(bool flip) {
  OwnedEncoder encoder(dracoEncoderCreate(4));
  constexpr int32_t kPosition = 0, kGeneric = 4, kUint16 = 4, kFloat = 9;
  EXPECT_EQ(dracoEncoderSetAttribute(encoder.get(), kPosition, kFloat, 3, sizeof(UnityVertex), flip, kVertices),
            0u);
  EXPECT_EQ(dracoEncoderSetAttribute(encoder.get(), kGeneric, kUint16, 1, sizeof(UnityVertex), false,
                                     &kVertices[0].joint),
            1u);
  EXPECT_TRUE(dracoEncoderSetIndices(encoder.get(), kUint16, 6, flip, kIndices));
  dracoEncoderSetQuantizationBits(encoder.get(), 0, 0, 0, 0, 0);
  return encoder;
}

TEST(UnityEncoder, EncodesWhatThePluginDecodes) {
  for (const bool flip : {false, true})
    for (const bool keeps_order : {false, true}) {
      const OwnedEncoder encoder = encoder_of_square(flip);
      dracoEncoderSetCompressionSpeed(encoder.get(), 0, 4);
      EXPECT_EQ(dracoEncoderGetByteLength(encoder.get()), 0u);
      ASSERT_TRUE(dracoEncoderEncode(encoder.get(), keeps_order));
      EXPECT_EQ(dracoEncoderGetEncodedVertexCount(encoder.get()), 4u);
      EXPECT_EQ(dracoEncoderGetEncodedIndexCount(encoder.get()), 6u);
      Bytes bytes(dracoEncoderGetByteLength(encoder.get()));
      dracoEncoderCopy(encoder.get(), bytes.data());
      void* data = nullptr;
      uint64_t size = 0;
      dracoEncoderGetEncodeBuffer(encoder.get(), &data, &size);
      ASSERT_EQ(size, bytes.size());
      EXPECT_EQ(std::memcmp(data, bytes.data(), bytes.size()), 0);
      const UnityMesh unity(bytes);
      ASSERT_EQ(unity.code, 0);
      uint32_t indices[6];
      ASSERT_TRUE(GetMeshIndices(unity.mesh, 6, indices, 6, flip));
      DracoAttribute* attributes[2] = {};
      ASSERT_TRUE(GetAttributeByUniqueId(unity.mesh, 0, &attributes[0]));
      ASSERT_TRUE(GetAttributeByUniqueId(unity.mesh, 1, &attributes[1]));
      const Bytes positions = must(data_of(unity.mesh, attributes[0], flip, 3, sizeof(float)));
      const Bytes joints = must(data_of(unity.mesh, attributes[1], false, 1, sizeof(uint16_t)));
      // Each corner has the vertex that it had; in a sequential stream also its number.
      size_t found = 0;
      for (const uint32_t index : indices) {
        uint16_t joint = 0;
        std::memcpy(&joint, &joints[index * sizeof(joint)], sizeof(joint));
        for (const UnityVertex& vertex : kVertices)
          if (vertex.joint == joint)
            found += std::memcmp(&positions[index * sizeof(vertex.position)], vertex.position,
                                 sizeof(vertex.position)) == 0;
      }
      EXPECT_EQ(found, 6u);
      if (keeps_order) {
        EXPECT_TRUE(std::equal(std::begin(indices), std::end(indices), std::begin(kIndices)));
      }
      for (DracoAttribute*& attribute : attributes) ReleaseDracoAttribute(&attribute);
    }
}

TEST(UnityEncoder, FlipsCoordinates) {
  const OwnedEncoder encoder = encoder_of_square(true);
  ASSERT_TRUE(dracoEncoderEncode(encoder.get(), 1));
  Bytes bytes(dracoEncoderGetByteLength(encoder.get()));
  dracoEncoderCopy(encoder.get(), bytes.data());
  const RawMesh mesh = must(decode_with_libdraco(bytes));
  EXPECT_EQ(mesh.faces[0], (std::array<uint32_t, 3>{0, 2, 1}));
  float x = 0;
  std::memcpy(&x, &mesh.attributes[0].point_values[3 * sizeof(float)], sizeof(x));
  EXPECT_EQ(x, -1);
}

// As draco::Encoder does: a kD-tree, but at speed 10, or if a type of attributes is not quantized.
TEST(UnityEncoder, EncodesPointClouds) {
  for (const uint32_t speed : {0u, 5u, 10u})
    for (const uint32_t normal_bits : {0u, 9u}) {
      SCOPED_TRACE(std::to_string(speed) + ", " + std::to_string(normal_bits));
      const OwnedEncoder cloud(dracoEncoderCreatePointCloud(4));
      constexpr int32_t kFloat = 9;
      EXPECT_EQ(dracoEncoderSetAttribute(cloud.get(), 0, kFloat, 3, sizeof(UnityVertex), false, kVertices), 0u);
      EXPECT_EQ(dracoEncoderSetAttribute(cloud.get(), 1, kFloat, 3, sizeof(UnityVertex), false, kVertices), 1u);
      dracoEncoderSetCompressionSpeed(cloud.get(), speed, 0);
      dracoEncoderSetQuantizationBits(cloud.get(), 11, normal_bits, 12, 8, 8);
      ASSERT_TRUE(dracoEncoderEncode(cloud.get(), 0));
      EXPECT_EQ(dracoEncoderGetEncodedVertexCount(cloud.get()), 4u);
      EXPECT_EQ(dracoEncoderGetEncodedIndexCount(cloud.get()), 0u);
      std::vector<uint8_t> bytes(dracoEncoderGetByteLength(cloud.get()));
      dracoEncoderCopy(cloud.get(), bytes.data());
      Subject subject{.name = "square", .point_count = 4};
      subject.welded = false;
      for (const Role role : {Role::POSITION, Role::NORMAL}) {
        Values& values = subject.attributes.emplace_back();
        values = {role, draco::DT_FLOAT32, 3, false, {}};
        for (const auto& vertex : kVertices) {
          const auto* const from = reinterpret_cast<const uint8_t*>(&vertex);
          values.bytes.insert(values.bytes.end(), from, from + 3 * sizeof(float));
        }
      }
      const std::array bits{11, static_cast<int>(normal_bits)};
      EXPECT_EQ(bytes, encode_cloud(*build(subject), kAuto, static_cast<int>(speed), bits));
    }
}

TEST(UnityEncoder, RefusesWhatItCannotDo) {
  constexpr int32_t kFloat = 9, kFloat64 = 10, kUint32 = 6;
  OwnedEncoder encoder = encoder_of_square(false);
  EXPECT_EQ(dracoEncoderSetAttribute(encoder.get(), 1, kFloat64, 3, 24, false, kVertices), 0xffffffffu);
  EXPECT_FALSE(dracoEncoderEncode(encoder.get(), 0));
  encoder = encoder_of_square(false);
  EXPECT_FALSE(dracoEncoderSetIndices(encoder.get(), kFloat, 6, false, kIndices));
  EXPECT_FALSE(dracoEncoderEncode(encoder.get(), 0));
  encoder = encoder_of_square(false);
  const uint32_t far[] = {0, 1, 9};
  EXPECT_TRUE(dracoEncoderSetIndices(encoder.get(), kUint32, 3, false, far));
  EXPECT_FALSE(dracoEncoderEncode(encoder.get(), 0));
  const OwnedEncoder cloud(dracoEncoderCreatePointCloud(4));
  EXPECT_FALSE(dracoEncoderEncode(cloud.get(), 0));
  EXPECT_FALSE(dracoEncoderEncode(nullptr, 0));
  EXPECT_EQ(dracoEncoderGetByteLength(nullptr), 0u);
  dracoEncoderRelease(nullptr);
}

}  // namespace
}  // namespace psplit
